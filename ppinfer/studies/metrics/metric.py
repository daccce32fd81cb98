"""What a metric is: one number a trial, with its units, its meaning and what a log must have for it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

import numpy as np
import xarray as xr
from jaxtyping import Float

from ppinfer.studies.metrics.context import TrialContext
from ppinfer.studies.metrics.roles import ROLES, Role, Roles

Measure = Callable[[TrialContext], Float[np.ndarray, " trial"]]


def _nothing(log: xr.Dataset, roles: Roles) -> str:
    return ""


@dataclass(frozen=True)
class Metric:
    """One number a trial that a study log may be able to give.

    Parameters
    ----------
    name : str
        What it is called in tables and on the command line. Names of agents in it are roles: ``robot``, ``human``.
    units : str
        Of its values; empty for counts and shares. ``{position}`` stands for the log's units of position.
    meaning : str
        One line for people: the definition, and when it is undefined.
    measure : callable
        From some whole trials to one float64 a trial; NaN where it is undefined in a trial.
    roles : tuple of str
        Which agents it needs: ``robot``, ``human``.
    needs : tuple of str
        The variables it is made of; ``"a or b"`` is satisfied by either, ``{robot}`` and ``{human}`` stand for the
        labels of these agents.
    reads : tuple of str
        Variables that it also looks at where a log has them.
    lacks : callable, optional
        From the log and its roles to what is missing besides, in words; empty where nothing is.

    Examples
    --------
    >>> from ppinfer.testing import example_log
    >>> from ppinfer.studies.metrics import trial_metrics
    >>> longest = Metric("samples", "", "samples of the trial", lambda trials: trials.row_size.astype(float))
    >>> trial_metrics(example_log(participants=1, trials=2), names=[longest]).values.tolist()
    [[20.0], [20.0]]
    """

    name: str
    units: str
    meaning: str
    measure: Measure
    roles: tuple[str, ...] = ()
    needs: tuple[str, ...] = ()
    reads: tuple[str, ...] = ()
    lacks: Callable[[xr.Dataset, Roles], str] = _nothing

    def missing(self, log: xr.Dataset, roles: Roles) -> str:
        """Return in words why a log cannot give this metric; empty where it can.

        Examples
        --------
        >>> from ppinfer.testing import example_log
        >>> log = example_log(participants=1, trials=1)
        >>> Metric("m", "", "", lambda trials: trials.duration, needs=("stops or held",)).missing(
        ...     log, Roles.of(log)
        ... )
        'the log has no stops or held'
        """
        absent = [role for role in self.roles if roles.index(role) is None]
        if absent:
            return roles.absent(absent[0])
        lacking = [
            need
            for need in (roles.filled(need) for need in self.needs)
            if not any(name in log.variables for name in need.split(" or "))
        ]
        if lacking:
            return f"the log has no {', no '.join(lacking)}"
        return self.lacks(log, roles)

    def variables(self, roles: Roles) -> set[str]:
        """Return the names of all variables that it may look at."""
        return {name for need in (*self.needs, *self.reads) for name in roles.filled(need).split(" or ")}


def metric_of_each_role(
    name: str,
    units: str,
    meaning: str,
    measure: Callable[..., Float[np.ndarray, " trial"]],
    *,
    needs: tuple[str, ...] = (),
    reads: tuple[str, ...] = (),
    lacks: Callable[[Role, xr.Dataset, Roles], str] | None = None,
) -> tuple[Metric, ...]:
    """Return one metric of the robot and one of the human.

    Parameters
    ----------
    name, meaning : str
        As of `Metric`, with ``{role}`` where they say whose it is.
    units : str
        As of `Metric`.
    measure : callable
        From some whole trials, and ``role=``, to one float64 a trial.
    needs, reads : tuple of str
        As of `Metric`; ``{{role}}`` stands for the label of the agent in that role.
    lacks : callable, optional
        As of `Metric`, with the role before the log.

    Examples
    --------
    >>> seen = metric_of_each_role("{role}_is_there", "", "1", lambda trials, role: trials.duration * 0 + 1)
    >>> [(metric.name, metric.roles) for metric in seen]
    [('robot_is_there', ('robot',)), ('human_is_there', ('human',))]
    """
    return tuple(
        Metric(
            name.replace("{role}", role),
            units,
            meaning.replace("{role}", role),
            partial(measure, role=role),
            roles=(role,),
            needs=tuple(need.replace("{role}", role) for need in needs),
            reads=reads,
            lacks=_nothing if lacks is None else partial(lacks, role),
        )
        for role in ROLES
    )
