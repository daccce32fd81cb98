"""What is believed of where one of two agents will go: with and without the other, inferred of a log and held live."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr
from jaxtyping import Bool, Float, Int

from ppinfer.goals import GoalModel, infer_goals
from ppinfer.goals.coupled import GoalCoupled
from ppinfer.report.interaction_choice import MIN_SAMPLES, StretchNumbers, stretch_numbers
from ppinfer.report.options import Pair, ReportOptions
from ppinfer.studies.assumed_reactions import assumed_reactions, told_reactions
from ppinfer.studies.blocks import iter_blocks
from ppinfer.studies.calibration import Calibration, calibrate_posterior
from ppinfer.studies.conditional_beliefs import infer_log_conditional
from ppinfer.studies.goal_evidence import goal_evidence
from ppinfer.studies.interaction import (
    Interaction,
    Stretch,
    live_names,
    live_probabilities,
    read_interaction,
    stretches,
)
from ppinfer.studies.log_inference import nominal_time_step, posterior_dataset
from ppinfer.studies.scores import score_posterior
from ppinfer.studies.segment_selection import describe_left_out, select_segments
from ppinfer.studies.trial_selection import select_trials

_BLOCK_SAMPLES = 1 << 17
_VARIABLES = ("log_belief", "log_given", "log_overall")

#: A model that learned from people what a partner's motion tells; the other beliefs have no fitted parameter.
COUPLED = GoalCoupled.name


@dataclass(frozen=True, eq=False)
class InferredBeliefs:
    """Beliefs at every sample of a log, and what the choice of interactions depends on.

    Attributes
    ----------
    values
        Logarithms of probabilities, (sample, goal), by what each belief is called.
    numbers
        Of every stretch with the same goals.
    whole
        Stretches that are long enough to show.
    attrs
        Of how they were inferred.
    """

    values: dict[str, Float[np.ndarray, "sample goal"]]
    numbers: StretchNumbers
    whole: Bool[np.ndarray, " stretch"]
    attrs: dict[str, Any]


@dataclass(frozen=True, eq=False)
class ScoredBelief:
    """A belief, its scores after each share of the segments, and its calibration."""

    name: str
    scores: tuple[dict[str, Any], ...]
    calibration: Calibration
    posterior: xr.Dataset


def infer_beliefs(
    path: Path, log: xr.Dataset, pair: Pair, models: Mapping[str, GoalModel]
) -> InferredBeliefs:
    """Infer of a log what is believed of the human's goal: without the robot, given its goal, overall, by models."""
    agent, partner = pair.human, pair.robot
    called = dict(
        zip(_VARIABLES, (f"without the {partner}", f"given the {partner}'s goal", "overall"), strict=True)
    )
    step = nominal_time_step(log)
    parts: dict[str, list[np.ndarray]] = {name: [] for name in (*called.values(), *models)}
    found: list[Stretch] = []
    differences: list[np.ndarray] = []
    gains: list[np.ndarray] = []
    attrs: dict[str, Any] = {}
    trial = sample = 0
    for block in iter_blocks(path, max_samples=_BLOCK_SAMPLES):
        beliefs = infer_log_conditional(block, agent=agent, partner=partner, time_step=step)
        attrs = dict(beliefs.attrs)
        goals = goal_evidence(block, agent, time_step=step)
        for name, model in models.items():
            parts[name].append(infer_goals(model, goals).log_posterior)
        for variable, name in called.items():
            parts[name].append(beliefs[variable].values)
        here = stretches(block, agent)
        numbers = stretch_numbers(
            here,
            np.exp(beliefs["log_belief"].values),
            np.exp(beliefs["log_given"].values),
            _true_goals(block, agent),
        )
        found += [Stretch(one.trial + trial, one.start + sample, one.stop + sample) for one in here]
        differences.append(numbers.difference)
        gains.append(numbers.gain)
        trial, sample = trial + block.sizes["trial"], sample + block.sizes["sample"]
    # a block need not hold every robot
    configuration = json.loads(attrs["configuration"])
    configuration["conditional"] = told_reactions(assumed_reactions(log, partner))
    attrs["configuration"] = json.dumps(configuration, allow_nan=False)
    return InferredBeliefs(
        {name: np.concatenate(held) for name, held in parts.items()},
        StretchNumbers(tuple(found), np.concatenate(differences), np.concatenate(gains)),
        np.array([one.stop - one.start >= MIN_SAMPLES for one in found]),
        attrs,
    )


def _true_goals(log: xr.Dataset, agent: str) -> Int[np.ndarray, " sample"]:
    """Return the true goal of the agent's segment at every sample; -1 where there is none."""
    found = np.full(log.sizes["sample"], -1, np.int64)
    if "segment_trial" not in log:
        return found
    labels = {str(goal): index for index, goal in enumerate(log["goal"].values)}
    first = np.cumsum(log["row_size"].values) - log["row_size"].values
    for at in np.flatnonzero(log["segment_agent"].values.astype(str) == agent).tolist():
        start = int(first[log["segment_trial"].values[at]])
        here = slice(
            start + int(log["segment_start"].values[at]), start + int(log["segment_stop"].values[at])
        )
        found[here] = labels.get(str(log["true_goal"].values[at]), -1)
    return found


def read_stretch(log: xr.Dataset, stretch: Stretch, pair: Pair) -> Interaction:
    """Read one stretch of a log with its beliefs."""
    first = int(log["row_size"].values[: stretch.trial].sum())
    one = select_trials(log, [stretch.trial]).load()
    beliefs = infer_log_conditional(
        one, agent=pair.human, partner=pair.robot, time_step=nominal_time_step(log)
    )
    return read_interaction(one, beliefs, Stretch(0, stretch.start - first, stretch.stop - first))


def score_beliefs(
    log: xr.Dataset, pair: Pair, inferred: InferredBeliefs, options: ReportOptions
) -> tuple[list[ScoredBelief], str]:
    """Return every belief with its scores, all on the same segments, and what was left out; none if none are scored."""
    evidence = goal_evidence(log, pair.human)
    held = dict(inferred.values)
    names: Sequence[str] = (f"without the {pair.robot}", f"given the {pair.robot}")
    for name, said in zip(live_names(log), names, strict=False):
        with np.errstate(divide="ignore"):
            live = np.log(live_probabilities(log, name))
        if not np.isnan(live).any():
            held[f"live, {said} ({name})"] = live
    selection, left_out = options.selection, ""
    scored = []
    for name, values in held.items():
        posterior = posterior_dataset(log, evidence, values, pair.human, {"model": name})
        selected = select_segments(posterior, **selection)
        if not len(selected.index):
            return [], describe_left_out(selected.left_out)
        scores = score_posterior(posterior, at=options.at, **selection)
        left_out = describe_left_out(scores.left_out)
        rows = tuple({"belief": name, **asdict(score)} for score in scores.overall)
        scored.append(ScoredBelief(name, rows, calibrate_posterior(posterior, **selection), posterior))
    return scored, left_out


def belief_warnings(scores: Sequence[Mapping[str, Any]], left_out: str) -> list[str]:
    """Say what a reader of the scores has to know."""
    if not scores:
        said = left_out or "the log names no segments of it with true goals"
        return [f"no belief can be scored: {said}"]
    return [
        f"{row['belief']}: at {row['at']:g} the true goal of {row['impossible']} of {row['segments']} segments has "
        "probability zero, so the mean log posterior is -inf"
        for row in scores
        if row["impossible"]
    ]
