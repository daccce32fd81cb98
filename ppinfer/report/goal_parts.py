"""What a page says of a posterior over goals: scores, trials, participants, calibration."""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial

import numpy as np
import xarray as xr
from jaxtyping import Float

from ppinfer.report.figures import calibration_figure, participants_figure, score_figure, trial_figure
from ppinfer.report.options import ReportOptions
from ppinfer.report.parts import Part, sentence
from ppinfer.report.trial_choice import ChosenTrial, choose_trials, named_trials
from ppinfer.studies.calibration import Calibration, calibrate_posterior
from ppinfer.studies.posterior import rows
from ppinfer.studies.scores import Score, Scores, score_posterior
from ppinfer.studies.segment_selection import describe_left_out, select_segments

_CURVE_SHARES = tuple(percent / 100 for percent in range(5, 101, 5))


@dataclass(frozen=True, eq=False)
class ScoredPosterior:
    """A posterior over goals with its scores.

    Attributes
    ----------
    scores, calibration
        None where no segment can be scored.
    chosen
        The trials to show.
    warnings
        What a reader has to know.
    """

    posterior: xr.Dataset
    scores: Scores | None
    calibration: Calibration | None
    chosen: tuple[ChosenTrial, ...]
    warnings: tuple[str, ...]

    @property
    def shown(self) -> tuple[str, ...]:
        """Names of the trials to show."""
        names = self.posterior["trial_id"].values
        return tuple(str(names[each.index]) for each in self.chosen)


def scored_posterior(posterior: xr.Dataset, options: ReportOptions) -> ScoredPosterior:
    """Score a posterior as asked, and choose the trials to show.

    Raises
    ------
    LogError
        If a trial or participant is unknown.
    """
    named = None if options.trials is None else named_trials(posterior, options.trials)
    selected = select_segments(posterior, **options.selection)
    if not len(selected.index):
        left_out = describe_left_out(selected.left_out)
        warning = f"no segment can be scored: {left_out or 'the log names no segments with true goals'}"
        chosen = named or choose_trials(posterior, None)
        return ScoredPosterior(posterior, None, None, tuple(chosen), (warning,))
    scores = score_posterior(posterior, at=options.at, **options.selection)
    calibration = calibrate_posterior(posterior, at=options.at, **options.selection)
    chosen = named or choose_trials(posterior, scores)
    return ScoredPosterior(posterior, scores, calibration, tuple(chosen), tuple(scores.warnings))


def headline_parts(scored: ScoredPosterior) -> list[Part]:
    """Return the most important numbers; nothing where nothing is scored."""
    if scored.scores is None or scored.calibration is None:
        return []
    return [
        Part("goals/headline.html.j2", {"middle": _middle(scored.scores), "calibration": scored.calibration})
    ]


def posterior_parts(scored: ScoredPosterior, options: ReportOptions, note: str = "") -> list[Part]:
    """Return scores, participants and trials; ``note`` says before them what the posterior is."""
    parts = [sentence(note)] if note else []
    if scored.scores is not None:
        selection = options.selection
        curve = score_posterior(scored.posterior, at=_CURVE_SHARES, **selection)
        middle = _middle(scored.scores).at
        people = [each for each in scored.scores.by_participant if each.at == middle]
        parts.append(
            Part(
                "goals/scores.html.j2",
                {
                    "scores": scored.scores,
                    "left_out": describe_left_out(scored.scores.left_out),
                },
                {
                    "figures": [partial(score_figure, curve.overall, guessing(scored.posterior))],
                    "people": [partial(participants_figure, people)],
                },
            )
        )
    else:
        parts.append(sentence(f"{scored.warnings[0][:1].upper()}{scored.warnings[0][1:]}."))
    parts.append(
        Part(
            "sections/trials.html.j2",
            {"heading": "Trials, instant by instant", "how_chosen": ""},
            {
                "figures": [
                    partial(trial_figure, scored.posterior, each.index, number=number, why=each.why)
                    for number, each in enumerate(scored.chosen, start=1)
                ]
            },
        )
    )
    return parts


def calibration_parts(scored: ScoredPosterior) -> list[Part]:
    """Return whether the probabilities mean what they say."""
    if scored.calibration is None:
        return [sentence("Without true goals nothing is known of how often beliefs come true.")]
    return [
        Part(
            "goals/calibration.html.j2",
            {"calibration": scored.calibration},
            {"figures": [partial(calibration_figure, scored.calibration)]},
        )
    ]


def guessing(posterior: xr.Dataset) -> tuple[float, float]:
    """Return accuracy and mean log posterior of a uniform guess among the goals that are present."""
    selection = select_segments(posterior)
    present = posterior["goal_present"]
    trial = posterior["segment_trial"].values[selection.index]
    leading = selection.first if present.dims[0] == "sample" else trial
    choices: Float[np.ndarray, " segment"] = np.maximum(1, (rows(present, leading) != 0).sum(axis=1))
    return float((1 / choices).mean()), float(-np.log(choices).mean())


def _middle(scores: Scores) -> Score:
    return scores.overall[len(scores.overall) // 2]
