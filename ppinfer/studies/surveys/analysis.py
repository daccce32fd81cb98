"""What a survey says: answers by item and condition, scores by scale, and whether each scale hangs together."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, dataclass, field
from typing import Any, Literal

import numpy as np
from jaxtyping import Int

from ppinfer.studies.surveys.reliability import (
    Alpha,
    alphas_if_dropped,
    centred_within,
    item_rest_correlations,
)
from ppinfer.studies.surveys.summary import Summary
from ppinfer.studies.surveys.survey import Survey

Of = Literal["condition", "all responses", "within participants"]


@dataclass(frozen=True)
class ItemInScale:
    """What an item does in its scale: its correlation with the sum of the others, and the alpha without it."""

    item: str
    item_rest_correlation: float | None
    alpha_if_dropped: float | None


@dataclass(frozen=True)
class Reliability:
    """Whether a scale hangs together under one condition, over all responses, or within participants."""

    scale: str
    of: Of
    condition: str
    alpha: Alpha
    items: tuple[ItemInScale, ...]


@dataclass(frozen=True, eq=False)
class SurveyAnalysis:
    """What a survey says; made by `analyse_survey`.

    Attributes
    ----------
    survey : Survey
        The responses that count.
    missing : str
        How missing answers were treated.
    missing_answers, dropped_responses : int
        How many answers were missing in the table, and how many responses were left out for that.
    by : tuple of str
        The condition columns that are told apart.
    items, scales : tuple of Summary
        By item or scale, and condition.
    reliability : tuple of Reliability
        By scale: under each condition, over all responses and within participants.
    warnings : tuple of str
        What may be wrong: missing answers, an item that contradicts its scale.
    notes : tuple of str
        How to read the numbers.
    """

    survey: Survey = field(repr=False)
    missing: str
    missing_answers: int
    dropped_responses: int
    by: tuple[str, ...]
    items: tuple[Summary, ...]
    scales: tuple[Summary, ...]
    reliability: tuple[Reliability, ...]
    warnings: tuple[str, ...]
    notes: tuple[str, ...]

    def to_json(self) -> dict[str, Any]:
        """Return what ``ppinfer survey --json`` prints of the answers."""
        instrument = self.survey.instrument
        return {
            "title": instrument.title,
            "by": list(self.by),
            "conditions": list(self.survey.groups(self.by)),
            "participants": len(self.survey.participants),
            "responses": self.survey.n_responses,
            "missing": self.missing,
            "missing_answers": self.missing_answers,
            "dropped_responses": self.dropped_responses,
            "items": [
                {
                    "item": row.name,
                    "text": instrument.items[row.name].text,
                    "reversed": instrument.items[row.name].reversed,
                    **_numbers(row),
                    "counts": {str(number): count for number, count in (row.counts or {}).items()},
                }
                for row in self.items
            ],
            "scales": [
                {"scale": row.name, "title": instrument.scales[row.name].title, **_numbers(row)}
                for row in self.scales
            ],
            "reliability": [
                {
                    "scale": row.scale,
                    "of": row.of,
                    "condition": row.condition,
                    "responses": row.alpha.responses,
                    "alpha": row.alpha.alpha,
                    "low": row.alpha.low,
                    "high": row.alpha.high,
                    "standardized_alpha": row.alpha.standardized,
                    "reason": row.alpha.reason,
                    "items": [asdict(item) for item in row.items],
                }
                for row in self.reliability
            ],
            "warnings": list(self.warnings),
            "notes": list(self.notes),
        }


def analyse_survey(
    survey: Survey, *, missing: str = "refuse", by: Sequence[str] | None = None
) -> SurveyAnalysis:
    r"""Summarise the answers to a survey by condition, score its scales, and ask whether these hang together.

    Parameters
    ----------
    survey : Survey
        From `ppinfer.studies.surveys.reading.read_survey`.
    missing : {"refuse", "drop-responses", "mean-of-answered"}
        What becomes of responses that lack answers (`Survey.complete`).
    by : sequence of str, optional
        Condition columns to tell apart; by default all of the instrument's.

    Raises
    ------
    FaultyLogError
        If answers are missing and are refused.
    LogError
        If no response is left, or there is no such condition column.

    Examples
    --------
    >>> from pathlib import Path
    >>> from ppinfer.studies.surveys import Instrument, read_survey
    >>> _ = Path("answers.csv").write_text("user,robot,easy\nann,a,5\nann,b,2\nbob,a,4\nbob,b,2\n")
    >>> instrument = Instrument.parse('''
    ...     columns = {subject = "user", condition = "robot"}
    ...     anchors = {1 = "no", 5 = "yes"}
    ...     items.easy.text = "The robot was easy to work with."
    ... ''')
    >>> for row in analyse_survey(read_survey("answers.csv", instrument)).items:
    ...     print(row.condition, row.n, row.mean, row.sem)
    a 2 4.5 0.5
    b 2 2.0 0.0
    """
    kept = survey.complete(missing)
    instrument = kept.instrument
    told_apart = instrument.factors if by is None else tuple(by)
    groups = kept.groups(told_apart)
    scores = kept.scores()
    items = tuple(
        Summary.of(name, label, kept.values[rows, at], kept.participant[rows], points=instrument.points(name))
        for at, name in enumerate(instrument.items)
        for label, rows in groups.items()
    )
    scales = tuple(
        Summary.of(name, label, scores[rows, at], kept.participant[rows])
        for at, name in enumerate(instrument.scales)
        for label, rows in groups.items()
    )
    reliability = tuple(row for name in instrument.scales for row in _reliability(kept, name, groups))
    return SurveyAnalysis(
        kept,
        missing,
        int(survey.missing.sum()),
        survey.n_responses - kept.n_responses,
        told_apart,
        items,
        scales,
        reliability,
        tuple(_warnings(survey, kept, missing, reliability)),
        tuple(_notes(kept)),
    )


def _numbers(row: Summary) -> dict[str, Any]:
    names = ("condition", "n", "participants", "missing", "mean", "sd", "sem", "median")
    return {name: getattr(row, name) for name in names}


def _reliability(survey: Survey, scale: str, groups: dict[str, Int[np.ndarray, " row"]]) -> list[Reliability]:
    columns = survey.columns_of(scale)
    names = [list(survey.instrument.items)[at] for at in columns]
    values = survey.turned[:, columns]
    whole = ~np.isnan(values).any(axis=1)

    def told(of: Of, label: str, rows: np.ndarray, *, centred: bool = False) -> Reliability:
        rows = rows[whole[rows]]
        who = survey.participant[rows]
        answers = centred_within(values[rows], who) if centred else values[rows]
        alpha = Alpha.of(answers, independent=len(np.unique(who)) == len(who))
        each = zip(names, item_rest_correlations(answers), alphas_if_dropped(answers), strict=True)
        return Reliability(scale, of, label, alpha, tuple(ItemInScale(*item) for item in each))

    everything = np.arange(survey.n_responses)
    found = [told("condition", label, rows) for label, rows in groups.items()] if len(groups) > 1 else []
    found.append(told("all responses", "", everything))
    if len(survey.participants) < survey.n_responses:
        found.append(told("within participants", "", everything, centred=True))
    return found


def _warnings(survey: Survey, kept: Survey, missing: str, reliability: tuple[Reliability, ...]) -> list[str]:
    found = []
    lacking = int(survey.missing.sum())
    if lacking:
        dropped = survey.n_responses - kept.n_responses
        done = (
            f"{dropped} of {survey.n_responses} responses were left out"
            if missing == "drop-responses"
            else "scores are means of the items that were answered, alpha is of responses that answered all"
        )
        found.append(f"{lacking} missing answer{'s' if lacking > 1 else ''}: {done}")
    instrument = kept.instrument
    for row in reliability:
        if row.of == "all responses":
            for item in row.items:
                if item.item_rest_correlation is not None and item.item_rest_correlation < 0:
                    turned = (
                        "it is reversed; should it be?"
                        if instrument.items[item.item].reversed
                        else "is it reversed?"
                    )
                    found.append(
                        f"scale {row.scale!r}: item {item.item!r} correlates negatively with the rest "
                        f"({item.item_rest_correlation:.2f}): {turned}"
                    )
    return found


def _notes(survey: Survey) -> list[str]:
    if not survey.instrument.scales or len(survey.participants) == survey.n_responses:
        return []
    return [
        "alpha over all responses counts participants as often as they answered, and mixes how they differ with how "
        "conditions differ: report that of each condition; that within participants is of what changes between a "
        "participant's responses; neither of the two has an interval, since responses are not independent"
    ]
