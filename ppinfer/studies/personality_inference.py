"""From a study log to the posterior over theta at every replan, block by block."""

from __future__ import annotations

import json
import os
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr
from jaxtyping import Float, Int

from ppinfer.coordination import PersonalityModel, infer_personality
from ppinfer.distributions import Distribution
from ppinfer.errors import ImpossibleEvidenceError, LogError
from ppinfer.studies.belief_writing import refuse_faulty
from ppinfer.studies.blocks import iter_blocks
from ppinfer.studies.checksums import file_sha256
from ppinfer.studies.log_inference import ppinfer_version
from ppinfer.studies.personality_models import AS_LOGGED, personality_of_text, personality_text
from ppinfer.studies.play_history import HISTORY_VARIABLES, play_history, require_replans
from ppinfer.studies.posterior_layout import POSTERIOR_FORMAT, POSTERIOR_FORMAT_VERSION
from ppinfer.studies.progress import ProgressCallback, silent
from ppinfer.studies.storage import open_log
from ppinfer.studies.structure_checks import trial_names
from ppinfer.studies.theta_posterior import HYPOTHESIS, THETA_VARIABLES, write_theta_posterior
from ppinfer.studies.trial_selection import select_trials

BLOCK_NUMBERS = 250_000
"""Waypoints and profiles worked on at a time (whole trials)."""

_MADE_HERE = ("model", "replan_row_size")
_FROM_TRIALS = tuple(
    name for name, spec in THETA_VARIABLES.items() if spec.dims[:1] == ("trial",) and name not in _MADE_HERE
)


@dataclass(frozen=True)
class PersonalityInference:
    """What an inference of personalities did, in numbers a person wants to see first.

    Parameters
    ----------
    agent : str
        Whose beliefs they are.
    trials, replans : int
        How much there was; replans of that agent.
    theta : tuple of str
        Whom equilibria may favour.
    models : dict
        How many trials each model was applied to, by its JSON text.
    live_replans : int
        Replans at which the log has what the agent believed.
    live_difference : float or None
        The largest absolute difference between a probability inferred and the one held live; None where there is none.
    log_name : str
        Name of the log.
    """

    agent: str
    trials: int
    replans: int
    theta: tuple[str, ...]
    models: dict[str, int]
    live_replans: int
    live_difference: float | None
    log_name: str

    @classmethod
    def of(cls, posterior: xr.Dataset, log_name: str) -> PersonalityInference:
        """Return the summary of a posterior over theta."""
        models, counts = np.unique(posterior["model"].values.astype(str), return_counts=True)
        compared, difference = live_difference(posterior)
        return cls(
            agent=str(posterior.attrs["agent"]),
            trials=posterior.sizes["trial"],
            replans=posterior.sizes["replan"],
            theta=tuple(str(label) for label in posterior["theta"].values),
            models=dict(zip(models.tolist(), counts.tolist(), strict=True)),
            live_replans=compared,
            live_difference=difference,
            log_name=log_name,
        )


def infer_personalities(
    log_path: str | os.PathLike[str],
    posterior_path: str | os.PathLike[str],
    model: PersonalityModel | None = None,
    *,
    agent: str | None = None,
    seed: int = 0,
    block_numbers: int = BLOCK_NUMBERS,
    progress: ProgressCallback = silent,
) -> PersonalityInference:
    """Write the posterior over theta at every replan of one agent in a log.

    Parameters
    ----------
    log_path : path
        A study log with replans.
    posterior_path : path
        Where the posterior goes (``.nc``); written under a temporary name and renamed when it is whole.
    model : PersonalityModel, optional
        For all trials. By default each trial is inferred with the model that its agent used live (``live_model``), so
        that offline equals live; trials without one with the default `Personality`.
    agent : str, optional
        Whose beliefs; default ``robot`` where it replanned, or the only agent that did.
    seed : int
        Recorded with the result; nothing here is random.
    block_numbers : int
        Waypoints and profiles worked on at a time (whole trials): memory does not grow with the study.
    progress : callable
        Told how many trials are done, of how many.

    Raises
    ------
    LogError
        Where the log is not sound (the first fault is told), has no replans or none of that agent.
    ImpossibleEvidenceError
        Where every personality is ruled out; the message names trial and replan. Nothing is written.

    Examples
    --------
    >>> from ppinfer.studies import write_log
    >>> from ppinfer.testing.example_plays import example_planned_log
    >>> write_log(example_planned_log(trials=2, replans=3), "plays.nc")
    >>> done = infer_personalities("plays.nc", "theta.nc")
    >>> done.agent, done.trials, done.replans
    ('robot', 2, 6)
    """
    source = Path(log_path)
    with open_log(source, verify=True) as log:
        require_replans(log, source)
        viewer = _viewer(log, agent, source)
        names = [name for name in HISTORY_VARIABLES if name in log]
        title, trials = str(log.attrs.get("title", "")), int(log.sizes["trial"])
    parts = _Parts(viewer, model)
    for block in iter_blocks(source, max_samples=block_numbers, variables=names):
        refuse_faulty(block, source)
        parts.add(block)
        progress(parts.trials, trials)
    attrs = {"seed": seed, "input": source.name, "input_sha256": file_sha256(source), "title": title}
    posterior = parts.posterior(source.name, attrs)
    write_theta_posterior(posterior, posterior_path)
    return PersonalityInference.of(posterior, source.name)


def infer_log_personality(
    log: xr.Dataset, model: PersonalityModel | None = None, *, agent: str | None = None
) -> xr.Dataset:
    """Return the posterior over theta at every replan of one agent of a log in memory.

    The numbers are those that `infer_personalities` writes from a file, and the Dataset has the form of that file.

    Parameters
    ----------
    log : xarray.Dataset
        A study log with replans.
    model : PersonalityModel, optional
        For all trials; by default each trial's own, see `infer_personalities`.
    agent : str, optional
        Whose beliefs; default ``robot`` where it replanned, or the only agent that did.

    Raises
    ------
    LogError
        Where the log has no replans, or none of that agent.
    ImpossibleEvidenceError
        Where every personality is ruled out.

    Examples
    --------
    >>> from ppinfer.testing.example_plays import example_planned_log
    >>> posterior = infer_log_personality(example_planned_log(trials=2, replans=3))
    >>> np.exp(posterior["log_posterior"].values[0])
    array([0.5, 0.5])
    """
    require_replans(log, "log")
    parts = _Parts(_viewer(log, agent, "log"), model)
    parts.add(log)
    return parts.posterior("log", {})


def live_difference(posterior: xr.Dataset) -> tuple[int, float | None]:
    """Return at how many replans a posterior over theta can be compared with the live one, and how far apart they are.

    The largest absolute difference between two probabilities; None where there is no live posterior that a model made.

    Examples
    --------
    >>> from ppinfer.testing.example_plays import example_planned_log
    >>> live_difference(infer_log_personality(example_planned_log(trials=2, replans=3)))[0]
    6
    """
    if "live_log_posterior" not in posterior:
        return 0, None
    live = posterior["live_log_posterior"].values
    held = ~np.isnan(live).all(axis=1)
    if "live_model" in posterior:
        # who was told, as an oracle is, inferred nothing
        inferred = posterior["live_model"].values.astype(str) != ""
        held &= np.repeat(inferred, posterior["replan_row_size"].values)
    if not held.any():
        return 0, None
    apart = np.abs(np.exp(posterior["log_posterior"].values[held]) - np.exp(live[held]))
    return int(held.sum()), float(apart.max())


def _viewer(log: xr.Dataset, agent: str | None, source: object) -> str:
    viewers = sorted(set(log["replan_agent"].values.tolist()))
    if agent is not None and agent not in viewers:
        raise LogError(
            f"{source}: no replan is of {agent!r}; those that replanned: {', '.join(map(repr, viewers))}"
        )
    if not viewers:
        raise LogError(f"{source}: nobody replanned in any trial, so there is nothing to infer")
    if agent is not None or len(viewers) == 1:
        return agent or str(viewers[0])
    if "robot" in viewers:
        return "robot"
    raise LogError(
        f"{source}: {', '.join(map(repr, viewers))} replanned; say whose beliefs are meant with --agent"
    )


@dataclass
class _Parts:
    """What has been inferred so far, block after block."""

    viewer: str
    model: PersonalityModel | None
    trials: int = 0
    # of the trials of each block
    still: list[xr.Dataset] = field(default_factory=list)
    # of the viewer's replans of each block: places, beliefs by label, live beliefs
    replans: list[xr.Dataset] = field(default_factory=list)
    labels: dict[str, None] = field(default_factory=dict)
    beliefs: list[dict[str, Float[np.ndarray, " replan"]]] = field(default_factory=list)

    def add(self, block: xr.Dataset) -> None:
        """Infer a block of whole trials."""
        mine = np.flatnonzero(block["replan_agent"].values.astype(str) == self.viewer)
        row_size = _replans_of(block, mine)
        applied = np.empty(block.sizes["trial"], object)
        # a label that a model does not have is impossible
        belief: dict[str, Float[np.ndarray, " replan"]] = {}
        starts = np.cumsum(row_size) - row_size
        for model, trials in self._models(block):
            applied[trials] = personality_text(model)
            seen = trials[row_size[trials] > 0]
            if not seen.size:
                continue
            some = block if seen.size == block.sizes["trial"] else select_trials(block, seen)
            inferred = _inferred(model, some, self.viewer)
            (theta,) = (axis for axis in inferred.axes if axis.name == "theta")
            values = inferred.align(
                *(axis for axis in inferred.axes if axis.name == "replan"), theta
            ).log_values
            places = np.concatenate(
                [np.arange(starts[trial], starts[trial] + row_size[trial]) for trial in seen]
            )
            for column, label in enumerate(map(str, theta.labels)):
                self.labels[label] = None
                belief.setdefault(label, np.full(mine.size, -np.inf))[places] = values[:, column]
        self.beliefs.append(belief)
        kept = ["agent", *(name for name in _FROM_TRIALS if name in block)]
        still = block[kept].drop_vars(["theta", "goal", "space", "table"], errors="ignore")
        self.still.append(still.assign(model=("trial", applied), replan_row_size=("trial", row_size)))
        names = [
            name
            for name in ("replan_time", "replan_sample", "replan_agent", "live_log_posterior")
            if name in block
        ]
        self.replans.append(block[names].isel(replan=mine))
        self.trials += block.sizes["trial"]

    def _models(self, block: xr.Dataset) -> Iterator[tuple[PersonalityModel, Int[np.ndarray, " trial"]]]:
        trials = np.arange(block.sizes["trial"])
        if self.model is not None:
            yield self.model, trials
            return
        texts = block["live_model"].values.astype(str) if "live_model" in block else np.full(trials.size, "")
        for text in dict.fromkeys(texts.tolist()):
            chosen = trials[texts == text]
            try:
                model = personality_of_text(text)
            except LogError as error:
                raise LogError(f"trial {trial_names(block)[chosen[0]]!r}: {error}") from error
            yield model, chosen

    def posterior(self, log_name: str, attrs: dict[str, Any]) -> xr.Dataset:
        """Return everything as one Dataset."""
        labels = list(self.labels)
        values = [
            np.stack([belief.get(label, np.full(part.sizes["replan"], -np.inf)) for label in labels], axis=1)
            for belief, part in zip(self.beliefs, self.replans, strict=True)
        ]
        still, replans = (xr.concat(parts, dim, data_vars="minimal", coords="minimal", compat="equals", join="exact")
                          for parts, dim in ((self.still, "trial"), (self.replans, "replan")))  # fmt: skip
        out = still.assign(
            {name: replans.variables[name] for name in ("replan_time", "replan_sample", "replan_agent")}
        )
        out = out.assign_coords(theta=("theta", np.array(labels, object)))
        out["log_posterior"] = (("replan", "theta"), np.concatenate(values))
        if "live_log_posterior" in replans:
            out["live_log_posterior"] = (("replan", "theta"), _aligned(replans, labels, log_name))
        for name, spec in THETA_VARIABLES.items():
            if name in out.variables:
                out[name].attrs = {"long_name": spec.meaning}
        out["replan_row_size"].attrs["sample_dimension"] = "replan"
        out["replan_time"].attrs["units"] = "s"
        out["trial_id"].attrs["cf_role"] = "trajectory_id"
        variant = AS_LOGGED if self.model is None else self.model.name
        out.attrs = {
            "Conventions": "CF-1.11",
            "featureType": "trajectory",
            "ppinfer_format": POSTERIOR_FORMAT,
            "ppinfer_format_version": POSTERIOR_FORMAT_VERSION,
            "ppinfer_version": ppinfer_version(),
            "hypothesis": HYPOTHESIS,
            "agent": self.viewer,
            "mode": "filter",
            "model": "personality",
            "variant": variant,
            "configuration": json.dumps(
                {
                    "model": "personality",
                    "variant": variant,
                    "applied": None if self.model is None else json.loads(personality_text(self.model)),
                    "agent": self.viewer,
                },
                allow_nan=False,
            ),
            **attrs,
        }
        return out


def _inferred(model: PersonalityModel, log: xr.Dataset, viewer: str) -> Distribution:
    try:
        return infer_personality(model, play_history(log), viewer)
    except ImpossibleEvidenceError:
        # it counts trials in these alone, which says nothing to who has the log: find the one, and name it
        for trial, name in enumerate(trial_names(log)):
            try:
                infer_personality(model, play_history(select_trials(log, [trial])), viewer)
            except ImpossibleEvidenceError as error:
                raise ImpossibleEvidenceError(
                    f"trial {name!r}: {str(error).replace(' of trial 0', '')}"
                ) from error
        raise


def _replans_of(block: xr.Dataset, mine: Int[np.ndarray, " replan"]) -> Int[np.ndarray, " trial"]:
    ends = np.cumsum(block["replan_row_size"].values)
    trial = np.searchsorted(ends, mine, side="right")
    counted: np.ndarray = np.bincount(trial, minlength=ends.size).astype(np.int64)
    return counted


def _aligned(replans: xr.Dataset, labels: list[str], log_name: str) -> Float[np.ndarray, "replan theta"]:
    """Return the live beliefs in the order of these labels; a label that nobody held then is impossible."""
    there = [str(label) for label in replans["theta"].values]
    live = replans["live_log_posterior"].values
    # NaN, where nobody held a belief, is not above anything
    if any((live[:, column] > -np.inf).any() for column, label in enumerate(there) if label not in labels):
        raise LogError(
            f"{log_name}: beliefs were held over theta {there}, but what is inferred is over {labels}; choose the "
            "model that was used"
        )
    out = np.where(np.isnan(live).all(axis=1)[:, None], np.nan, np.full((len(live), len(labels)), -np.inf))
    for column, label in enumerate(there):
        if label in labels:
            out[:, labels.index(label)] = live[:, column]
    return out
