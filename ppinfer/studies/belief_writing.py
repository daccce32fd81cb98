"""Beliefs over goals written to a posterior file, block by block, in flat memory."""

from __future__ import annotations

import os
import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

from ppinfer.errors import LogError
from ppinfer.goals.belief import GoalBelief
from ppinfer.goals.evidence import GoalEvidence
from ppinfer.studies.blocks import iter_blocks
from ppinfer.studies.checksums import file_sha256
from ppinfer.studies.goal_evidence import agent_index
from ppinfer.studies.log_inference import (
    TRIAL_LEVEL,
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


# what evidence is made of, as far as the log has it
MOTION_AND_GOALS = (
    "time", "position", "velocity", "control", "observed", "goal_position", "goal_present"
)  # fmt: skip

#: From a block of a log, whose goals, and the log's time step in s, to the evidence and the belief.
BeliefOf = Callable[[xr.Dataset, str, float | None], tuple[GoalEvidence, GoalBelief]]


def write_beliefs(
    log_path: str | os.PathLike[str],
    posterior_path: str | os.PathLike[str],
    belief_of: BeliefOf,
    *,
    agent: str | None,
    attrs: Mapping[str, Any],
    describe: Callable[[str, float | None], Mapping[str, str]],
    variables: Sequence[str] = (),
    has_outliers: bool = False,
    block_samples: int = BLOCK_SAMPLES,
    progress: ProgressCallback = silent,
) -> Inference:
    """Write the belief over an agent's goals at every sample of a log, with the log's trials and segments.

    Parameters
    ----------
    log_path, posterior_path : path
        What is read, and what is written: under a temporary name, and renamed when it is whole.
    belief_of : callable
        Asked for each block of whole trials.
    agent : str or None
        Whose goals; None as in `default_agent`.
    attrs : mapping
        Attributes of the file, besides those on input and version.
    describe : callable
        From whose goals and the log's time step to further attributes.
    variables : sequence of str
        What of each sample is read, besides motion and goals.
    has_outliers : bool
        Whether the beliefs come with outliers.
    block_samples : int
        Samples worked on at a time.
    progress : callable
        Told how many samples are done, of how many.

    Raises
    ------
    LogError
        Where the log is not sound, has no goals or not that agent.
    """
    with open_log(log_path, verify=True) as log:
        whose = default_agent(log) if agent is None else agent
        agent_index(log, whose)
        _require_goals(log, Path(log_path))
        log_attrs = dict(log.attrs)
        names = [
            name for name in (*MOTION_AND_GOALS, *variables) if name in log and "sample" in log[name].dims
        ]
        moving = "sample" in log["goal_position"].dims
        samples, trials = int(log.sizes["sample"]), int(log.sizes["trial"])
        goals = [str(label) for label in log["goal"].values]
        space = [str(label) for label in log["space"].values]
        units = str(log["position"].attrs.get("units", "m"))
        step = nominal_time_step(log)
        still = log[[name for name in TRIAL_LEVEL if name in log and "sample" not in log[name].dims]].load()
    about: dict[str, Any] = {
        "hypothesis": "goal",
        "agent": whose,
        **attrs,
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
        attrs=about,
        has_outliers=has_outliers,
        position_units=units,
    ) as writer:
        for block in iter_blocks(log_path, max_samples=block_samples, variables=names):
            refuse_faulty(block, log_path)
            evidence, belief = belief_of(block, whose, step)
            _write_block(writer, block, evidence, belief, done, moving=moving, outliers=has_outliers)
            source = source or belief.state_source
            missing += int((~evidence.seen).sum())
            gated += 0 if belief.outliers is None else int(belief.outliers.sum())
            done += evidence.samples
            progress(done, samples)
        segments = _write_still(writer, still, whose, moving=moving)
        writer.set_attrs(
            **describe(whose, step),
            state_source=source,
            samples_missing=missing,
            outliers_gated=gated,
        )
    return Inference(whose, trials, samples, segments, missing, gated, source, Path(log_path).name)


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
