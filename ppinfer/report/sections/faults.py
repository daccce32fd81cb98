"""What the checks found: sound or not, and every fault and warning with where it is."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from ppinfer.report.parts import Part
from ppinfer.studies.faults import Fault, Report


def faults_part(checked: Report, *, what: str, notes: str = "") -> Part:
    """Return the part that tells what validation found.

    Parameters
    ----------
    checked
        What it found.
    what
        What was checked: the log, the posterior.
    notes
        What a reader of another format left out or took for granted, a line each.
    """
    return Part(
        "sections/faults.html.j2",
        {
            "what": what,
            "verdict": _verdict(checked, what),
            "faults": _listed(checked.faults, checked.fault_counts),
            "warnings": _listed(checked.warnings, checked.warning_counts),
            "left_out": [line for line in notes.splitlines() if line.strip()],
        },
    )


def unsound_warning(checked: Report) -> str:
    """Say that nothing is concluded from a log with faults."""
    count = sum(checked.fault_counts.values())
    return (
        f"the log has {count:,} fault{'s' * (count != 1)}, so nothing is concluded from it; mend it "
        "(see 'ppinfer validate')"
    )


def _verdict(checked: Report, what: str) -> str:
    count = sum(checked.fault_counts.values())
    if count:
        return (
            f"{what.capitalize()} is not sound: its checks found {count:,} fault{'s' * (count != 1)} (“ppinfer "
            "validate”). Nothing is concluded from it."
        )
    if checked.warning_counts:
        return f"{what.capitalize()} is sound: its checks found no fault (“ppinfer validate”)."
    return f"{what.capitalize()} is sound: its checks found nothing (“ppinfer validate”)."


def _listed(faults: Sequence[Fault], counts: Mapping[str, int]) -> list[dict[str, Any]]:
    rows = [
        {"kind": each.kind, "where": _where(each), "count": each.count, "what": _what(each)}
        for each in faults
    ]
    told: dict[str, int] = {}
    for each in faults:
        told[each.kind] = told.get(each.kind, 0) + each.count
    return rows + [
        {
            "kind": kind,
            "where": "elsewhere",
            "count": count - told.get(kind, 0),
            "what": "more of this kind, not listed",
        }
        for kind, count in counts.items()
        if count > told.get(kind, 0)
    ]


def _where(fault: Fault) -> str:
    places = [
        None if fault.line is None else f"line {fault.line}",
        None if fault.trial is None else f"trial {fault.trial}",
        None if fault.sample is None else f"sample {fault.sample}",
        None if fault.replan is None else f"replan {fault.replan}",
        None if fault.column is None else f"column {fault.column}",
    ]
    return ", ".join(place for place in places if place is not None) or "the file"


def _what(fault: Fault) -> str:
    return f"{fault.message}; {fault.remedy}" if fault.remedy else fault.message
