"""From a log file to a posterior file: beliefs over goals inferred by a model."""

from __future__ import annotations

import os

import xarray as xr

from ppinfer.goals import GoalModel, infer_goals
from ppinfer.goals.belief import GoalBelief, Mode
from ppinfer.goals.evidence import GoalEvidence
from ppinfer.studies.belief_writing import BLOCK_SAMPLES, Inference, write_beliefs
from ppinfer.studies.goal_evidence import Restart, goal_evidence
from ppinfer.studies.log_inference import configuration_text
from ppinfer.studies.progress import ProgressCallback, silent

__all__ = ["Inference", "infer_posterior"]


def infer_posterior(
    log_path: str | os.PathLike[str],
    posterior_path: str | os.PathLike[str],
    model: GoalModel,
    *,
    agent: str | None = None,
    mode: Mode = "filter",
    restart: Restart = "goals",
    carry: bool = False,
    seed: int = 0,
    block_samples: int = BLOCK_SAMPLES,
    partner: str | None = None,
    progress: ProgressCallback = silent,
) -> Inference:
    """Write the posterior over an agent's goals at every sample of a log.

    Parameters
    ----------
    log_path : path
        A study log (NetCDF or Zarr).
    posterior_path : path
        Where the posterior goes; written under a temporary name and renamed when it is whole.
    model : GoalModel
        The likelihood.
    agent : str, optional
        Whose goals; default ``human`` where there is one, or the only agent.
    mode : {"filter", "smooth"}
        Given the samples so far, or given the whole row.
    restart, carry
        Where the belief starts anew within a trial, and from what; see `goal_evidence`.
    seed : int
        Recorded with the result; nothing here is random.
    block_samples : int
        Samples worked on at a time (whole trials): memory does not grow with the study.
    partner : str, optional
        The other agent that a model looks at which looks at any; default: all other agents of the log.
    progress : callable
        Told how many samples are done, of how many.

    Raises
    ------
    LogError
        Where the log is not sound (the first fault is told; `validate_log` finds all), has no goals or not
        that agent.
    ModelError
        Where the model looks at other agents and the log has one only.
    ImpossibleEvidenceError
        Where every goal is ruled out; the message names trial and sample. Nothing is written.

    Examples
    --------
    >>> import tempfile
    >>> from pathlib import Path
    >>> import numpy as np
    >>> from ppinfer.goals import GoalLQR
    >>> from ppinfer.studies import build_log, write_log
    >>> log = build_log(
    ...     agents=["human"], goals=["cup", "pan"], row_size=[3], time=[0.0, 0.1, 0.2], participant=["p1"],
    ...     position=np.array([[[0.0, 0.0]], [[0.1, 0.0]], [[0.2, 0.0]]]),
    ...     goal_position=np.array([[1.0, 0.0], [0.0, 1.0]]),
    ... )
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     write_log(log, Path(folder, "log.nc"))
    ...     done = infer_posterior(Path(folder, "log.nc"), Path(folder, "post.nc"), GoalLQR())
    >>> done.trials, done.samples
    (1, 3)
    """

    def infer(block: xr.Dataset, whose: str, step: float | None) -> tuple[GoalEvidence, GoalBelief]:
        evidence = goal_evidence(block, whose, restart=restart, carry=carry, time_step=step, partner=partner)
        return evidence, infer_goals(model, evidence, mode=mode)

    def describe(whose: str, step: float | None) -> dict[str, str]:
        return {
            "configuration": configuration_text(
                model, whose, mode, restart, carry=carry, time_step=step, partner=partner
            )
        }

    return write_beliefs(
        log_path,
        posterior_path,
        infer,
        agent=agent,
        attrs={"mode": mode, "model": model.name, "seed": seed},
        describe=describe,
        has_outliers=model.gates_outliers,
        block_samples=block_samples,
        progress=progress,
    )
