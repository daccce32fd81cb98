"""Which rule says who is idle in a log: its waiting flags, or speeds and the threshold that suits them."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
import xarray as xr
from jaxtyping import Shaped

from ppinfer.errors import LogError
from ppinfer.studies.blocks import iter_blocks
from ppinfer.studies.metrics.context import TrialContext
from ppinfer.studies.metrics.idleness import IDLE_FROM, IdleFrom, IdleRule, flag_of
from ppinfer.studies.metrics.roles import ROLES, Role, Roles

SPEED_SHARE, SPEED_QUANTILE = 0.1, 0.95
"""By default an agent is idle up to this share of this quantile of its speeds in the log."""


def idle_rule(
    log: xr.Dataset,
    roles: Roles,
    *,
    idle: IdleFrom = "auto",
    idle_speed: float | None = None,
    max_samples: int = 1_000_000,
) -> IdleRule:
    """Return what counts as idle in a log.

    1. With ``auto``, flags are used where the log has one for the robot and one for the human (for whom there is), and
       each of them is sometimes 1 and sometimes 0: one that never changes was hardly logged. Both agents are judged
       by flags or neither is.
    2. By motion, an agent that is seen is idle up to ``idle_speed``; by default up to a tenth of the 95th percentile of
       its speeds in the log.

    Parameters
    ----------
    log : xarray.Dataset
        A study log.
    roles : Roles
        Who is the robot and who the human.
    idle : {"auto", "flags", "motion"}
        Where idleness is taken from.
    idle_speed : float, optional
        The threshold of both agents, in the log's units of position a second.
    max_samples : int
        Samples looked at at a time.

    Raises
    ------
    LogError
        If flags are asked for and there are none, or the threshold is no speed.

    Examples
    --------
    >>> from ppinfer.testing import example_log
    >>> log = example_log()
    >>> rule = idle_rule(log, Roles.of(log))
    >>> rule.source, sorted(rule.speed)
    ('motion', ['human'])
    """
    if idle not in IDLE_FROM:
        raise LogError(f"idle is {idle!r}; expected one of {', '.join(IDLE_FROM)}")
    if idle_speed is not None and not (np.isfinite(idle_speed) and idle_speed >= 0):
        raise LogError(
            f"the speed up to which an agent is idle is {idle_speed}; expected a number, 0 or more"
        )
    there = [role for role in ROLES if roles.index(role) is not None]
    flags = [roles.filled(flag_of(role)) for role in there]
    missing = [name for name in flags if name not in log.variables]
    if idle == "flags" and (missing or not flags):
        raise LogError(f"the log has no {', no '.join(missing) or 'agents'}; take idleness from motion")
    unused = ""
    if idle != "motion" and flags and not missing:
        constant = [name for name in flags if idle == "auto" and _is_constant(log[name].values)]
        if not constant:
            return IdleRule("flags")
        unused = (
            f"{' and '.join(constant)} never changes in this log, so that idleness is taken from motion "
            "(flags are taken as they are where they are asked for)"
        )
    units = f"{log['position'].attrs.get('units', 'm')}/s"
    if idle_speed is not None:
        return IdleRule("motion", dict.fromkeys(there, float(idle_speed)), units, unused)
    blocks = iter_blocks(log, max_samples=max_samples, variables=["time", "position", "observed"])
    return IdleRule("motion", _usual_speeds(blocks, roles, there), units, unused)


def _is_constant(flag: Shaped[np.ndarray, " sample"]) -> bool:
    return bool((flag == flag[:1]).all())


def _usual_speeds(blocks: Iterable[xr.Dataset], roles: Roles, there: list[Role]) -> dict[str, float]:
    found: dict[str, list[np.ndarray]] = {role: [] for role in there}
    for block in blocks:
        trials = TrialContext(block, roles, IdleRule())
        for role in there:
            seen = trials.seen(role)
            found[role].append(trials.step_length(role)[seen] / trials.interval[seen])
    speeds = {role: np.concatenate(parts) for role, parts in found.items()}
    return {
        role: SPEED_SHARE * float(np.quantile(values, SPEED_QUANTILE)) if values.size else 0.0
        for role, values in speeds.items()
    }
