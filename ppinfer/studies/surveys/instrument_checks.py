"""What cannot be meant in an instrument, though each entry by itself is well written."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING

from ppinfer.studies.readers.mapping import closest

if TYPE_CHECKING:
    from ppinfer.studies.surveys.instrument import Instrument

MOST_POINTS = 101
_WHOLE = re.compile(r"[+-]?\d{1,6}", re.ASCII)


def contradictions(instrument: Instrument) -> list[str]:
    """Return what is wrong with the anchors, the scales and the columns of an instrument, in sentences.

    Examples
    --------
    >>> from ppinfer.studies.surveys.instrument import Instrument
    >>> contradictions(Instrument.model_validate({"columns": {"subject": "user"}, "items": {"user": {}}}))[1]
    "'items.user' and 'columns.subject' are the same column 'user'"
    """
    return [*_wrong_anchors(instrument), *_wrong_scales(instrument), *_wrong_columns(instrument)]


def folded(text: str) -> str:
    """Return a text without what people change when they type it: case and spaces.

    Examples
    --------
    >>> folded(" Strongly  Agree ")
    'strongly agree'
    """
    return " ".join(text.casefold().split())


def _wrong_anchors(instrument: Instrument) -> list[str]:
    found = []
    given = {"anchors": instrument.anchors} if instrument.anchors else {}
    for name, item in instrument.items.items():
        if item.anchors is not None:
            given[f"items.{name}.anchors"] = item.anchors
        elif not instrument.anchors:
            found.append(
                f'item {name!r} has no anchors: give [anchors] for all items, e.g. 1 = "Strongly Disagree" and '
                '5 = "Strongly Agree", or some of its own'
            )
    for where, anchors in given.items():
        wrong = [number for number in anchors if not _WHOLE.fullmatch(number)]
        if wrong:
            found.append(f"{where!r}: an anchor belongs to a whole number, got {', '.join(map(repr, wrong))}")
            continue
        numbers = [int(number) for number in anchors]
        if len(set(numbers)) < max(2, len(numbers)):
            found.append(f"{where!r}: give the lowest and the highest number, each once")
        elif max(numbers) - min(numbers) >= MOST_POINTS:
            found.append(f"{where!r}: a scale has at most {MOST_POINTS} points")
        texts = [folded(text) for text in anchors.values() if text.strip()]
        if len(set(texts)) < len(texts):
            found.append(
                f"{where!r}: two numbers have the same text, so that the text would not tell them apart"
            )
        for number, text in anchors.items():
            if _WHOLE.fullmatch(text.strip()) and int(text) != int(number):
                found.append(f"{where!r}: {number} is called {text!r}, which is another number")
    return found


def _wrong_scales(instrument: Instrument) -> list[str]:
    found = []
    for name, scale in instrument.scales.items():
        where = f"scales.{name}.items"
        unknown = [item for item in scale.items if item not in instrument.items]
        found += [f"{where!r}: no item {item!r}; {closest(item, instrument.items)}" for item in unknown]
        if not scale.items:
            found.append(f"{where!r}: a scale has at least one item")
        if len(set(scale.items)) < len(scale.items):
            found.append(f"{where!r}: each item once")
        if not unknown and not _wrong_anchors(instrument):
            ranges = {(points[0], points[-1]) for points in map(instrument.points, scale.items)}
            if len(ranges) > 1:
                told = ", ".join(f"{low} to {high}" for low, high in sorted(ranges))
                found.append(
                    f"{where!r}: the items of a scale are answered on the same numbers, these on {told}"
                )
    return found


def _wrong_columns(instrument: Instrument) -> list[str]:
    found = []
    own = instrument.columns
    if own.condition is not None and not instrument.factors:
        found.append("'columns.condition': an empty list; leave it out where there are no conditions")
    roles = [("columns.subject", own.subject), *(("columns.condition", name) for name in instrument.factors)]
    roles += [] if own.position is None else [("columns.position", own.position)]
    roles += [(f"items.{name}", instrument.column(name)) for name in instrument.items]
    first: dict[str, str] = {}
    for role, column in roles:
        if column in first:
            found.append(f"{role!r} and {first[column]!r} are the same column {column!r}")
        first.setdefault(column, role)
    found += [
        f"'conditions.{name}': no column of a condition is called so; {closest(name, instrument.factors)}"
        for name in instrument.conditions
        if name not in instrument.factors
    ]
    found += [
        f"'conditions.{name}': name at least one condition"
        for name, labels in instrument.conditions.items()
        if not labels
    ]
    # what a table of scores has as columns
    names = ["participant", *instrument.factors, *instrument.score_names, *instrument.scales]
    names += ["position"] if own.position is not None else []
    found += [
        f"{name!r} would be {names.count(name)} columns of a table of scores: items, scales and conditions have names "
        "of their own, and none is called 'participant'"
        for name in dict.fromkeys(names)
        if names.count(name) > 1
    ]
    if instrument.orders is not None and len(set(instrument.orders.positions)) < max(
        2, len(instrument.orders.positions)
    ):
        found.append("'orders.positions': name at least two columns, each once")
    return found
