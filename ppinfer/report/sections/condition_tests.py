"""Do conditions differ? Repeated-measures analyses of variance of every metric, and pairs where they do."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from ppinfer.errors import LogError
from ppinfer.report.parts import Part, sentence
from ppinfer.report.sections.metrics import Measured
from ppinfer.studies.statistics import Analysis, RepeatedMeasures, analyse

LEVEL = 0.05


@dataclass(frozen=True, eq=False)
class Tested:
    """What was tested, or why nothing was.

    Attributes
    ----------
    within
        The column of conditions.
    analysis
        None where nothing could be tested.
    p_over_metrics
        The sphericity-corrected p of each metric, adjusted for how many metrics there are (Holm).
    why_none
        Why nothing was tested; empty where something was.
    notes
        What a reader has to know: metrics that are left out, participants that are.
    """

    within: str | None
    analysis: Analysis | None
    p_over_metrics: tuple[float, ...] = ()
    why_none: str = ""
    notes: tuple[str, ...] = ()

    def to_json(self) -> dict[str, Any]:
        """Return what ``ppinfer report --json`` says of tests."""
        told: dict[str, list[dict[str, object]]] = {"anova": [], "posthoc": []}
        if self.analysis is not None:
            told = self.analysis.to_json()
        return {
            "within": self.within,
            "anova": [
                {**row, "p_over_metrics": None if np.isnan(p) else p}
                for row, p in zip(told["anova"], self.p_over_metrics, strict=True)
            ],
            "posthoc": told["posthoc"],
            "why_none": self.why_none or None,
            "notes": list(self.notes),
        }


def compare_conditions(measured: Measured) -> Tested:
    """Test of every metric whether conditions differ, over the participants that met all of them.

    1. Each participant's mean over its trials in a condition; repeated-measures analysis of variance over these, with
       the degrees of freedom corrected by Greenhouse and Geisser.
    2. p adjusted for the number of metrics by Holm's method.
    3. Pairs of conditions by paired t-tests, adjusted for the pairs of a metric by Holm's method.
    """
    why = _why_not(measured)
    if why:
        return Tested(measured.by, None, why_none=why)
    assert measured.by is not None
    notes: list[str] = []
    usable: list[RepeatedMeasures] = []
    same, lacking = [], []
    for name in measured.metrics.names:
        measures = measured.metrics.measures(name, within=measured.by)
        try:
            whole = measures.complete("drop-subjects")
        except LogError:
            lacking.append(name)
            continue
        if np.ptp(whole.values - whole.values.mean(axis=1, keepdims=True)) == 0:
            same.append(name)
            continue
        notes += [f"{each}." for each in whole.notes if each not in measures.notes]
        usable.append(whole)
    if same:
        notes.append(f"The same in all conditions, and not tested: {', '.join(same)}.")
    if lacking:
        notes.append(
            f"Undefined in some condition for all participants but one at most, and not tested: {', '.join(lacking)}."
        )
    if not usable:
        return Tested(measured.by, None, why_none="No metric can be tested.", notes=tuple(notes))
    analysis = analyse(usable, posthoc="holm")
    notes += [
        f"{each[:1].upper()}{each[1:]}." for each in analysis.warnings if "means of several rows" not in each
    ]
    corrected = np.array([effect.p_gg for effect in analysis.anova])
    return Tested(measured.by, analysis, tuple(_holm(corrected).tolist()), notes=tuple(dict.fromkeys(notes)))


def tests_parts(tested: Tested) -> list[Part]:
    """Return the tables of tests, or why there are none."""
    if tested.analysis is None:
        return [sentence(f"Nothing is tested. {tested.why_none}"), *[sentence(note) for note in tested.notes]]
    rows = list(zip(tested.analysis.anova, tested.p_over_metrics, strict=True))
    differing = {effect.dv for effect, p in rows if p < LEVEL}
    return [
        Part(
            "sections/tests.html.j2",
            {
                "within": (tested.within or "").replace("_", " "),
                "rows": rows,
                "levels": len(tested.analysis.anova[0].means),
                "pairs": [test for test in tested.analysis.posthoc if test.dv in differing],
                "notes": tested.notes,
                "level": LEVEL,
                "level_shown": f"{LEVEL:g}".removeprefix("0"),
            },
        )
    ]


def _why_not(measured: Measured) -> str:
    if measured.by is None:
        return "The trials have no conditions."
    name = measured.by.replace("_", " ")
    columns = measured.metrics.columns
    conditions = columns[measured.by].astype(str)
    if len(np.unique(conditions)) < 2:
        return f"There is one {name} only."
    people = columns["participant"].astype(str)
    if len(np.unique(people)) < 2:
        return "There is one participant only."
    met = {person: len(np.unique(conditions[people == person])) for person in np.unique(people).tolist()}
    once = [person for person, count in met.items() if count < 2]
    if once:
        count = len(once)
        return (
            f"{count:,} of {len(met):,} participants met one {name} only, so that conditions cannot be compared within "
            "participants."
        )
    return ""


def _holm(p: np.ndarray) -> np.ndarray:
    """Adjust p-values for their number; one that is not defined counts for nothing."""
    known = np.flatnonzero(~np.isnan(p))
    order = known[np.argsort(p[known], kind="stable")]
    adjusted = np.full(len(p), np.nan)
    factors = len(order) - np.arange(len(order))
    adjusted[order] = np.minimum(1.0, np.maximum.accumulate(factors * p[order]))
    return adjusted
