"""From a log file to a posterior file, block by block, in flat memory."""

from __future__ import annotations

import os
import re
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

from ppinfer.errors import LogError
from ppinfer.goals import GoalModel, infer_goals
from ppinfer.goals.belief import GoalBelief, Mode
from ppinfer.goals.evidence import GoalEvidence
from ppinfer.studies.blocks import iter_blocks
from ppinfer.studies.checksums import file_sha256
from ppinfer.studies.goal_evidence import Restart, agent_index, goal_evidence
from ppinfer.studies.log_inference import (
    TRIAL_LEVEL,
    configuration_text,
    default_agent,
    nominal_time_step,
    ppinfer_version,
    presence,
    segments_of_agent,
)
from ppinfer.studies.posterior_writer import PosteriorWriter
from ppinfer.studies.progress import ProgressCallback, silent
from ppinfer.studies.storage import open_log
from ppinfer.studies.validation import validate_log

BLOCK_SAMPLES = 250_000


@dataclass(frozen=True)
class Inference:
    """What an inference did, in numbers a person wants to see first.

    Parameters
    ----------
    trials, samples, segments
        How much there was.
    samples_missing, outliers_gated
        Samples at which the agent was not seen, or was set aside as an outlier.
    state_source
        How velocities and controls were obtained.
    """

    agent: str
    trials: int
    samples: int
    segments: int
    samples_missing: int
    outliers_gated: int
    state_source: str
    log_name: str


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
    progress : callable
        Told how many samples are done, of how many.

    Raises
    ------
    LogError
        Where the log is not sound (the first fault is told; `validate_log` finds all), has no goals or not
        that agent.
    ImpossibleEvidenceError
        Where every goal is ruled out; the message names trial and sample. Nothing is written.

    Examples
    --------
    >>> import tempfile
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
    with open_log(log_path, verify=True) as log:
        whose = default_agent(log) if agent is None else agent
        index = agent_index(log, whose)
        _require_goals(log, Path(log_path))
        log_attrs = dict(log.attrs)
        names = [name for name in _USED if name in log and "sample" in log[name].dims]
        moving = "sample" in log["goal_position"].dims
        samples, trials = int(log.sizes["sample"]), int(log.sizes["trial"])
        goals = [str(label) for label in log["goal"].values]
        space = [str(label) for label in log["space"].values]
        units = str(log["position"].attrs.get("units", "m"))
        step = nominal_time_step(log)
        still = log[[name for name in TRIAL_LEVEL if name in log and "sample" not in log[name].dims]].load()
    attrs: dict[str, Any] = {
        "hypothesis": "goal",
        "agent": whose,
        "mode": mode,
        "model": model.name,
        "seed": seed,
        "ppinfer_version": ppinfer_version(),
        "input": Path(log_path).name,
        "input_sha256": file_sha256(log_path),
        "title": str(log_attrs.get("title", "")),
    }
    missing = gated = done = 0
    source = ""
    with PosteriorWriter(
        posterior_path,
        n_samples=samples,
        goals=goals,
        space=space,
        goal_position_dims="sample" if moving else "trial",
        attrs=attrs,
        has_outliers=model.gates_outliers,
        position_units=units,
    ) as writer:
        for block in iter_blocks(log_path, max_samples=block_samples, variables=names):
            refuse_faulty(block, log_path)
            evidence = goal_evidence(block, whose, restart=restart, carry=carry, time_step=step)
            belief = infer_goals(model, evidence, mode=mode)
            _write_block(
                writer, block, evidence, belief, index, done, moving=moving, outliers=model.gates_outliers
            )
            source = source or belief.state_source
            missing += int((~evidence.seen).sum())
            gated += 0 if belief.outliers is None else int(belief.outliers.sum())
            done += evidence.samples
            progress(done, samples)
        segments = _write_still(writer, still, whose, moving=moving)
        writer.set_attrs(
            configuration=configuration_text(model, whose, mode, restart, carry=carry, time_step=step),
            state_source=source,
            samples_missing=missing,
            outliers_gated=gated,
        )
    return Inference(whose, trials, samples, segments, missing, gated, source, Path(log_path).name)


_USED = ("time", "position", "velocity", "control", "observed", "goal_position", "goal_present")


def refuse_faulty(block: xr.Dataset, log_path: str | os.PathLike[str]) -> None:
    """Raise a LogError that tells the first fault of a block of a log, if it has any."""
    report = validate_log(block)
    if report.ok:
        return
    first = report.faults[0]
    # segments are numbered within the block here, which says nothing to who has the log: trial and sample do
    told = replace(first, message=re.sub(r"^segment \d+: ", "its segment: ", first.message))
    raise LogError(
        f"{log_path}: {told}; inference stopped at this first fault and wrote nothing: run 'ppinfer validate "
        f"{log_path}' for all of them"
    )


def _write_block(
    writer: PosteriorWriter,
    block: xr.Dataset,
    evidence: GoalEvidence,
    belief: GoalBelief,
    index: int,
    start: int,
    *,
    moving: bool,
    outliers: bool,
) -> None:
    optional: dict[str, Any] = {}
    if moving:
        optional["goal_position"] = block["goal_position"].values
        optional["goal_present"] = presence(block)
    if outliers:
        assert belief.outliers is not None
        optional["outlier"] = belief.outliers.astype(np.int8)
    writer.write_samples(
        start,
        time=evidence.time,
        position=evidence.position,
        observed=evidence.seen.astype(np.int8),
        log_posterior=belief.log_posterior,
        **optional,
    )


def _write_still(writer: PosteriorWriter, still: xr.Dataset, agent: str, *, moving: bool) -> int:
    optional: dict[str, Any] = {name: still[name].values for name in ("condition", "round") if name in still}
    if not moving:
        optional["goal_position"] = still["goal_position"].values
        optional["goal_present"] = presence(still)
    writer.write_trials(
        trial_id=still["trial_id"].values,
        row_size=still["row_size"].values,
        participant=still["participant"].values,
        **optional,
    )
    segments = segments_of_agent(still, agent)
    writer.write_segments(
        trial=segments["segment_trial"],
        start=segments["segment_start"],
        stop=segments["segment_stop"],
        true_goal=segments["true_goal"],
    )
    return len(segments["segment_trial"])


def _require_goals(log: xr.Dataset, path: Path) -> None:
    if "goal_position" not in log:
        instead = (
            "it holds replans: personalities are inferred with --model personality"
            if "replan_row_size" in log
            else "give them when converting (see docs/log-format.md)"
        )
        raise LogError(f"{path}: the log holds no goals (goal_position); {instead}")
