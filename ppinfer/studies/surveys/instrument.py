"""A survey instrument, a TOML file: which column is which item, its anchors, what is reversed, and the scales."""

from __future__ import annotations

import os
import tomllib
from functools import cached_property
from pathlib import Path
from typing import Any

from pydantic import BaseModel, ConfigDict, Field, ValidationError

from ppinfer.guarding import read_small_text
from ppinfer.studies.faults import Fault, Faults
from ppinfer.studies.readers.mapping import FileOptions, closest
from ppinfer.studies.surveys.instrument_checks import contradictions


class _Table(BaseModel):
    model_config = ConfigDict(extra="forbid", frozen=True, strict=True)


class Columns(_Table):
    """``[columns]``: who answered, under which condition or conditions, and when in the order of conditions."""

    subject: str
    condition: str | list[str] | None = None
    position: str | None = None


class Orders(_Table):
    """``[orders]``: the columns of a table of orders with one row a participant and one column a position."""

    positions: list[str]
    subject: str | None = None


class Item(_Table):
    """``[items.NAME]``: one statement that is answered on a scale of whole numbers."""

    column: str | None = None
    text: str = ""
    reversed: bool = False
    anchors: dict[str, str] | None = None


class Scale(_Table):
    """``[scales.NAME]``: items whose mean, after reversing, is one score."""

    items: list[str]
    title: str = ""


class Instrument(_Table):
    """Which columns of a table are a survey, and what its answers mean.

    Columns that it does not name are never read: neither names nor remarks get from the table into any result.

    Parameters
    ----------
    title
        What the survey is called.
    columns
        The columns of the participant, of the condition or conditions (none: everybody answered once) and of the
        position of the condition in the participant's order, from 1.
    items
        By name; each with its column (by default its name), its text, and whether agreeing means less of what its
        scales measure.
    anchors
        The texts of the numbers that can be answered, for all items that have none of their own: at least of the
        lowest and the highest, all whole numbers between which can be answered.
    scales
        By name; each with its items.
    conditions
        By column of a condition: its labels in the order in which they are shown, with a title each. Others are
        then faults.
    file
        How a CSV file is written.
    orders
        The columns of a table of orders.

    Examples
    --------
    >>> instrument = Instrument.parse('''
    ...     columns = {subject = "user", condition = "robot"}
    ...     anchors = {1 = "Strongly Disagree", 5 = "Strongly Agree"}
    ...     items.easy.text = "The robot was easy to work with."
    ...     items.hindered = {text = "The robot was in the way.", reversed = true}
    ...     scales.fluency.items = ["easy", "hindered"]
    ... ''')
    >>> list(instrument.items), instrument.points("easy"), instrument.factors
    (['easy', 'hindered'], range(1, 6), ('robot',))
    """

    title: str = ""
    columns: Columns
    items: dict[str, Item] = Field(min_length=1)
    anchors: dict[str, str] = Field(default_factory=dict)
    scales: dict[str, Scale] = Field(default_factory=dict)
    conditions: dict[str, dict[str, str]] = Field(default_factory=dict)
    file: FileOptions = Field(default_factory=lambda: FileOptions.model_validate({}))
    orders: Orders | None = None

    @classmethod
    def load(cls, path: str | os.PathLike[str]) -> Instrument:
        """Read an instrument from a TOML file.

        Raises
        ------
        FaultyLogError
            If the file cannot be read or anything in it is wrong; all faults are told.
        """
        where = Path(path)
        faults = Faults()
        instrument = None
        try:
            instrument = _parse(read_small_text(where), where.name, faults)
        except OSError as error:
            faults.add(Fault("unreadable", f"cannot be read: {error.strerror}"))
        except UnicodeDecodeError:
            faults.add(Fault("unreadable", "is not UTF-8 text", "save it as UTF-8"))
        faults.raise_if_any(str(where))
        assert instrument is not None
        return instrument

    @classmethod
    def parse(cls, text: str, *, source: str = "instrument") -> Instrument:
        """Read an instrument from the text of a TOML file.

        Raises
        ------
        FaultyLogError
            If anything in it is wrong; all faults are told.
        """
        faults = Faults()
        instrument = _parse(text, source, faults)
        faults.raise_if_any(source)
        assert instrument is not None
        return instrument

    @property
    def factors(self) -> tuple[str, ...]:
        """The columns of the conditions."""
        condition = self.columns.condition
        return tuple([condition] if isinstance(condition, str) else condition or ())

    def column(self, item: str) -> str:
        """Return the column of an item."""
        return self.items[item].column or item

    def points(self, item: str) -> range:
        """Return the numbers that can be answered."""
        numbers = self.texts(item)
        return range(min(numbers), max(numbers) + 1)

    def texts(self, item: str) -> dict[int, str]:
        """Return the anchors of an item: numbers, ascending, and their texts."""
        own = self.items[item].anchors
        return {int(number): text for number, text in sorted((own or self.anchors).items(), key=_number)}

    def wording(self, item: str) -> str:
        """Return the text of an item, or its name where it has none."""
        return self.items[item].text or item

    @cached_property
    def score_names(self) -> tuple[str, ...]:
        """What the items are called in a table of scores: one that is reversed there says so."""
        return tuple(f"{name}_reversed" if item.reversed else name for name, item in self.items.items())


def _number(anchor: tuple[str, str]) -> int:
    return int(anchor[0])


def _parse(text: str, file: str, faults: Faults) -> Instrument | None:
    try:
        told = tomllib.loads(text)
    except (ValueError, RecursionError) as error:
        faults.add(
            Fault("instrument", f"is not TOML: {error}", "see docs/surveys.md for an example", file=file)
        )
        return None
    try:
        instrument = Instrument.model_validate(told)
    except ValidationError as error:
        for wrong in error.errors():
            faults.add(_wrong_entry(wrong, file))
        return None
    for message in contradictions(instrument):
        faults.add(Fault("instrument", message, file=file))
    return instrument


_MODELS: dict[str, type[BaseModel]] = {
    "columns": Columns, "orders": Orders, "items": Item, "scales": Scale, "file": FileOptions
}  # fmt: skip


def _wrong_entry(wrong: Any, file: str) -> Fault:
    place = [str(part) for part in wrong["loc"]]
    where = ".".join(place)
    if wrong["type"] == "extra_forbidden":
        model = Instrument if len(place) == 1 else _MODELS.get(place[0], Instrument)
        remedy = closest(place[-1], model.model_fields)
        return Fault("instrument", f"there is no entry {where!r}", remedy, file=file)
    if wrong["type"] == "missing":
        return Fault("instrument", f"{where!r} is missing", file=file)
    return Fault("instrument", f"{where!r}: {wrong['msg']}, got {str(wrong['input'])[:60]!r}", file=file)
