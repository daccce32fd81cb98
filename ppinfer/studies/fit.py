"""Fitting a goal model to a study, cross-validated over its participants."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass

import numpy as np
import xarray as xr
from jaxtyping import Bool, Float, Int

from ppinfer.distributions import expand, row_starts
from ppinfer.errors import LogError
from ppinfer.goals import GoalEvidence, GoalModel, infer_goals
from ppinfer.goals.fitting import Fit, LabelledEvidence, Objective, fit_goals
from ppinfer.studies.calibration import calibrate_posterior
from ppinfer.studies.goal_evidence import Restart, goal_evidence
from ppinfer.studies.log_inference import default_agent, nominal_time_step, posterior_dataset
from ppinfer.studies.progress import ProgressCallback, silent
from ppinfer.studies.scores import DEFAULT_SHARES, Score, score_posterior
from ppinfer.studies.segment_selection import SegmentOptions

# one participant left out at a time up to this many; beyond, that many groups of participants
MOST_FOLDS = 20


@dataclass(frozen=True)
class StudyFit:
    """A model fitted to a study, with what it predicts of participants that it was not fitted to.

    Parameters
    ----------
    fit : Fit
        On all participants chosen.
    participants : tuple of str
        To whom it was fitted.
    segments, samples : int
        How much of their motion had a known goal.
    folds : tuple of Fit
        The fits of the cross-validation, one for each group of participants left out; empty without one.
    held_out : tuple of Score
        Scores of the segments of the participants left out, each by the fit that had not seen them.
    expected_calibration_error : float
        Of these held-out predictions (nan without a cross-validation).
    held_out_posterior : xarray.Dataset or None
        The held-out posterior itself, in the form of a posterior file.
    """

    fit: Fit
    participants: tuple[str, ...]
    segments: int
    samples: int
    folds: tuple[Fit, ...]
    held_out: tuple[Score, ...]
    expected_calibration_error: float
    held_out_posterior: xr.Dataset | None


def fit_study(
    log: xr.Dataset,
    model: GoalModel,
    *,
    agent: str | None = None,
    objective: Objective = "predictive",
    fixed: Collection[str] = (),
    participants: Sequence[str] | None = None,
    exclude: Sequence[str] | None = None,
    restart: Restart = "goals",
    folds: int | None = None,
    seed: int = 0,
    at: Sequence[float] = DEFAULT_SHARES,
    min_samples: int | None = None,
    min_distance: float | None = None,
    partner: str | None = None,
    progress: ProgressCallback = silent,
) -> StudyFit:
    """Fit a goal model to the segments of a study whose goal is known, cross-validated over participants.

    Parameters
    ----------
    log : xarray.Dataset
        A study log with segments and their ``true_goal``.
    model : GoalModel
        What to fit; see `ppinfer.goals.fitting.fit_goals` for `objective` and `fixed`.
    agent : str, optional
        Whose motion; default as in `infer_posterior`.
    participants, exclude : sequence of str, optional
        Fit to these participants only, or to all but these.
    restart : {"goals", "segments"}
        Where beliefs start anew; see `goal_evidence`.
    folds : int, optional
        Groups of participants left out in turn: 0 for none; default: one participant each, or 20 groups.
    seed : int
        Deals participants into groups.
    at, min_samples, min_distance
        Which held-out scores to report; see `ppinfer.studies.scores.score_posterior`.
    partner : str, optional
        The other agent that a model looks at which looks at any; default: all other agents of the log.
    progress : callable
        Told how many fits are done, of how many.

    Returns
    -------
    StudyFit
        Every segment weighs the same, whatever its length.

    Raises
    ------
    LogError
        Where the log has no segments of this agent with a known goal, or a participant is unknown.

    Examples
    --------
    >>> from ppinfer.goals import NearestGoal
    >>> from ppinfer.testing import example_log
    >>> fitted = fit_study(example_log(participants=2, trials=2), NearestGoal())
    >>> len(fitted.folds), [score.at for score in fitted.held_out]
    (2, [0.25, 0.5, 0.75])
    """
    whose = default_agent(log) if agent is None else agent
    chosen = _choose(log, participants, exclude)
    evidence = goal_evidence(log, whose, restart=restart, time_step=nominal_time_step(log), partner=partner)
    true_goal, weight, segment_count = _labels(log, whose, evidence)
    trial_of_row = np.searchsorted(row_starts(log["row_size"].values), evidence.row_start, side="right") - 1
    participant = log["participant"].values.astype(str)[trial_of_row]
    groups = _groups(chosen, len(chosen) if folds is None else folds, seed)
    total = 1 + len(groups)

    def fit_to(people: Sequence[str]) -> Fit:
        data = _labelled_rows(evidence, true_goal, weight, np.isin(participant, people))
        return fit_goals(model, data, objective=objective, fixed=fixed)

    whole = fit_to(chosen)
    progress(1, total)
    fits: list[Fit] = []
    log_posterior = np.full((evidence.samples, len(evidence.goal_labels)), np.nan)
    for done, group in enumerate(groups, start=2):
        fits.append(fit_to([name for name in chosen if name not in group]))
        rows = np.flatnonzero(np.isin(participant, group))
        belief = infer_goals(fits[-1].model, evidence.take_rows(rows))
        log_posterior[np.isin(evidence.row_of_sample, rows)] = belief.log_posterior
        progress(done, total)
    labelled = (weight > 0) & np.isin(participant, chosen)[evidence.row_of_sample]
    held_out: tuple[Score, ...] = ()
    error, posterior = float("nan"), None
    if fits:
        posterior = posterior_dataset(
            log, evidence, log_posterior, whose, {"model": model.name, "held_out_folds": len(fits)}
        )
        posterior = _only_participants(posterior, chosen)
        selection = SegmentOptions(min_samples=min_samples, min_distance=min_distance)
        held_out = score_posterior(posterior, at=at, **selection).overall
        error = calibrate_posterior(posterior, at=at, **selection).expected_calibration_error
    return StudyFit(
        fit=whole,
        participants=tuple(chosen),
        segments=int(segment_count[np.isin(log["participant"].values.astype(str), chosen)].sum()),
        samples=int(labelled.sum()),
        folds=tuple(fits),
        held_out=held_out,
        expected_calibration_error=error,
        held_out_posterior=posterior,
    )


def _choose(log: xr.Dataset, participants: Sequence[str] | None, exclude: Sequence[str] | None) -> list[str]:
    known = list(dict.fromkeys(log["participant"].values.astype(str).tolist()))
    for name in [*(participants or ()), *(exclude or ())]:
        if name not in known:
            raise LogError(f"there is no participant {name!r}; there are {', '.join(known[:20])}")
    kept = [
        name
        for name in known
        if (participants is None or name in participants) and name not in (exclude or ())
    ]
    if not kept:
        raise LogError("no participant is left to fit to")
    return kept


def _labels(
    log: xr.Dataset, agent: str, evidence: GoalEvidence
) -> tuple[Int[np.ndarray, " sample"], Float[np.ndarray, " sample"], Int[np.ndarray, " trial"]]:
    """Return the true goal and the weight of every sample, and how many labelled segments each trial has."""
    true_goal = np.full(evidence.samples, -1, dtype=np.int64)
    weight = np.zeros(evidence.samples)
    count = np.zeros(log.sizes["trial"], dtype=np.int64)
    if "segment_trial" in log and log.sizes.get("segment", 0):
        named = log["true_goal"].values.astype(str)
        mine = (log["segment_agent"].values.astype(str) == agent) & (named != "")
        trial, stop = log["segment_trial"].values[mine], log["segment_stop"].values[mine]
        start = log["segment_start"].values[mine]
        size = stop - start
        goal = np.array([evidence.goal_labels.index(name) for name in named[mine].tolist()], dtype=np.int64)
        index = expand(row_starts(log["row_size"].values)[trial] + start, size)
        true_goal[index] = np.repeat(goal, size)
        weight[index] = np.repeat(1.0 / size, size)
        np.add.at(count, trial, 1)
    if not count.any():
        raise LogError(
            f"the log has no segment of agent {agent!r} with a true_goal, so there is nothing to fit to"
        )
    return true_goal, weight, count


def _labelled_rows(
    evidence: GoalEvidence,
    true_goal: Int[np.ndarray, " sample"],
    weight: Float[np.ndarray, " sample"],
    wanted: Bool[np.ndarray, " row"],
) -> LabelledEvidence:
    """Return the rows of some participants that hold any labelled sample."""
    labelled = np.add.reduceat(weight, evidence.row_start) > 0
    rows = np.flatnonzero(wanted & labelled)
    if len(rows) == 0:
        raise LogError("the participants chosen have no segment with a true_goal")
    samples = np.isin(evidence.row_of_sample, rows)
    share = weight[samples]
    return LabelledEvidence(evidence.take_rows(rows), true_goal[samples], share / share.sum())


def _groups(participants: Sequence[str], folds: int, seed: int) -> list[list[str]]:
    """Deal participants into `folds` groups, at most `MOST_FOLDS`; none where fewer than two are asked for."""
    if folds < 0:
        raise LogError(f"folds must not be negative; got {folds}")
    count = min(folds, len(participants), MOST_FOLDS)
    if count < 2:
        return []
    dealt = np.random.default_rng(seed).permutation(len(participants))
    return [[participants[i] for i in sorted(dealt[group::count].tolist())] for group in range(count)]


def _only_participants(posterior: xr.Dataset, chosen: Sequence[str]) -> xr.Dataset:
    """Drop the trials of other participants, their samples and their segments."""
    kept = np.isin(posterior["participant"].values.astype(str), chosen)
    if kept.all():
        return posterior
    samples = np.repeat(kept, posterior["row_size"].values)
    segments = kept[posterior["segment_trial"].values]
    number = np.cumsum(kept) - 1
    out = posterior.isel(
        trial=np.flatnonzero(kept), sample=np.flatnonzero(samples), segment=np.flatnonzero(segments)
    )
    out["segment_trial"] = ("segment", number[out["segment_trial"].values])
    return out
