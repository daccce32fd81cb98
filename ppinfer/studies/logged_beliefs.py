"""Beliefs over goals that a log holds, because the robot of the study held them live, as posteriors to compare with."""

from __future__ import annotations

import os
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import xarray as xr
from jaxtyping import Float

from ppinfer.distributions import Distribution
from ppinfer.errors import LogError
from ppinfer.goals.belief import GoalBelief
from ppinfer.goals.evidence import GoalEvidence
from ppinfer.goals.naming import choices
from ppinfer.studies.belief_writing import BLOCK_SAMPLES, Inference, write_beliefs
from ppinfer.studies.goal_evidence import goal_evidence
from ppinfer.studies.progress import ProgressCallback, silent
from ppinfer.studies.storage import open_log

# how readers and worlds call what was believed live; what begins with the last holds logarithms
PREFIXES = ("logged_", "live_", "live_log_")
# a sum that is off by no more is one that was written down with rounding
ROUNDING = 1e-9


@dataclass(frozen=True)
class LoggedBelief:
    """What became of a logged belief.

    Parameters
    ----------
    inference : Inference
        How much there was.
    variable : str
        The log's name of it.
    zeros : int
        Probabilities of goals that were present which the log gives as zero: they stay zero, and a true goal among them
        scores a log posterior of minus infinity.
    normalised : int
        Samples whose probabilities did not sum to one, and were divided by their sum.
    """

    inference: Inference
    variable: str
    zeros: int
    normalised: int


def belief_variables(log: xr.Dataset) -> list[str]:
    """Return the variables of a log that hold one number for every sample and goal.

    Examples
    --------
    >>> from ppinfer.testing import example_log
    >>> log = example_log(participants=1, trials=1)
    >>> log["live_belief"] = (("sample", "goal"), np.full((log.sizes["sample"], log.sizes["goal"]), 0.5))
    >>> belief_variables(log)
    ['live_belief']
    """
    known = (str(name) for name, variable in log.data_vars.items() if variable.dims == ("sample", "goal"))
    return [name for name in known if name.startswith(PREFIXES)]


def write_logged_belief(
    log_path: str | os.PathLike[str],
    posterior_path: str | os.PathLike[str],
    belief: str,
    *,
    agent: str | None = None,
    block_samples: int = BLOCK_SAMPLES,
    progress: ProgressCallback = silent,
) -> LoggedBelief:
    """Write a belief over goals that a log holds as a posterior file, with the log's trials and segments.

    Parameters
    ----------
    log_path, posterior_path : path
        What is read, and what is written.
    belief : str
        The variable over (sample, goal), by its name or by what follows ``logged_`` or ``live_`` in it. One that begins
        with ``live_log_`` holds logarithms.
    agent : str, optional
        Whose goals it is over; default ``human`` where there is one, or the only agent.
    block_samples, progress
        As in `infer_posterior`.

    Raises
    ------
    LogError
        Where there is no such belief (those there are, are listed), or it is not a number, negative or zero for every
        goal that is present at a sample, or positive for one that is absent.

    Examples
    --------
    >>> import tempfile
    >>> from pathlib import Path
    >>> from ppinfer.studies import write_log
    >>> from ppinfer.testing import example_log
    >>> log = example_log(participants=1, trials=1)
    >>> log["live_belief"] = (("sample", "goal"), np.full((log.sizes["sample"], log.sizes["goal"]), 1.0))
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     write_log(log, Path(folder, "log.nc"))
    ...     done = write_logged_belief(Path(folder, "log.nc"), Path(folder, "post.nc"), "belief")
    >>> done.variable, done.zeros, done.normalised == log.sizes["sample"]
    ('live_belief', 0, True)
    """
    with open_log(log_path) as log:
        name = _named(belief, belief_variables(log), str(log_path))
    zeros = normalised = 0

    def read(block: xr.Dataset, whose: str, step: float | None) -> tuple[GoalEvidence, GoalBelief]:
        nonlocal zeros, normalised
        evidence = goal_evidence(block, whose, time_step=step)
        weights = _weights(block[name], evidence, in_logs=name.startswith("live_log_"))
        total = weights.sum(axis=1)
        zeros += int(((weights == 0) & evidence.goal_present[evidence.row_of_sample]).sum())
        normalised += int((np.abs(total - 1.0) > ROUNDING).sum())
        with np.errstate(divide="ignore"):
            log_posterior = np.log(weights / total[:, None])
        axes = (evidence.sample_axis, evidence.goal_axis)
        held = Distribution._sound(axes, log_posterior, ("batch", "random"))
        return evidence, GoalBelief(held, f"logged: {name}")

    done = write_beliefs(
        log_path,
        posterior_path,
        read,
        agent=agent,
        variables=(name,),
        attrs={"mode": "filter", "model": f"logged {name}"},
        describe=lambda whose, step: {},
        block_samples=block_samples,
        progress=progress,
    )
    return LoggedBelief(done, name, zeros, normalised)


def _named(belief: str, known: Sequence[str], log: str) -> str:
    for candidate in (belief, *(prefix + belief for prefix in PREFIXES)):
        if candidate in known:
            return candidate
    short = [name.removeprefix("logged_").removeprefix("live_") for name in known]
    there = f"expected {choices(belief, short)}" if known else "it holds none over (sample, goal)"
    raise LogError(f"{log}: the log has no belief {belief!r}: {there}")


def _weights(
    values: xr.DataArray, evidence: GoalEvidence, *, in_logs: bool
) -> Float[np.ndarray, "sample goal"]:
    """Return probabilities up to a factor for each sample; refuse what cannot be any."""
    numbers = values.values.astype(np.float64)
    weights: np.ndarray = np.exp(numbers) if in_logs else numbers
    present = evidence.goal_present[evidence.row_of_sample]
    faults = {
        "is not a number": ~np.isfinite(weights),
        "is negative": weights < 0,
        "is above zero for a goal that is absent": (weights > 0) & ~present,
        "is zero for every goal that is present": ~((weights > 0) & present).any(axis=1, keepdims=True),
    }
    for what, cells in faults.items():
        wrong = cells.any(axis=1)
        if wrong.any():
            sample = int(np.argmax(wrong))
            raise LogError(
                f"{evidence.describe_sample(sample)}: {values.name} {what}: {weights[sample].tolist()}; a belief over "
                "the goals is expected at every sample"
            )
    return weights
