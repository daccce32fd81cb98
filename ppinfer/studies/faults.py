"""What is wrong with a log: faults, gathered so that all of them are told at once."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import asdict, dataclass, field
from typing import Any

from ppinfer.errors import LogError, printable

LISTED_PER_KIND = 20
"""How many faults of one kind are listed one by one; all of them are counted."""
_SHOWN = 600
"""Letters of a message that are shown: a cell may hold a whole file that lost its quotes."""


@dataclass(frozen=True, slots=True)
class Fault:
    """One thing that is wrong, where it is, and what to do.

    Parameters
    ----------
    kind
        A short stable word for programs, e.g. ``"time-not-increasing"``.
    message
        What was found and what was expected.
    remedy
        What to do about it.
    file, line
        The input file and the line in it (1 = the first; for Parquet the row).
    trial, sample, replan
        The trial's id, and the index of the sample or replan within the trial (0 = the first).
    column
        The variable of the log, or the column of the input.
    count
        How many occurrences this one line stands for.

    Examples
    --------
    >>> print(Fault("not-finite", "position is inf", "mark a dropout", trial="a", sample=3, column="x"))
    trial 'a': sample 3: column 'x': position is inf; mark a dropout
    """

    kind: str
    message: str
    remedy: str = ""
    file: str | None = None
    line: int | None = None
    trial: str | None = None
    sample: int | None = None
    replan: int | None = None
    column: str | None = None
    count: int = 1

    def __str__(self) -> str:
        counted = "row" if (self.file or "").endswith((".parquet", ".pq")) else "line"
        where = [
            self.file,
            None if self.line is None else f"{counted} {self.line}",
            None if self.trial is None else f"trial {self.trial!r}",
            None if self.sample is None else f"sample {self.sample}",
            None if self.replan is None else f"replan {self.replan}",
            None if self.column is None else f"column {self.column!r}",
        ]
        told = [_shortened(part) for part in [*where, self.message] if part is not None]
        text = ": ".join(told)
        return printable(" ".join((f"{text}; {_shortened(self.remedy)}" if self.remedy else text).split()))


def _shortened(text: str) -> str:
    return text if len(text) <= _SHOWN else f"{text[: _SHOWN * 2 // 3]} ... {text[-_SHOWN // 3 :]}"


class FaultyLogError(LogError):
    """A log, or an input of one, that has faults.

    ``faults`` lists the first of each kind, ``counts`` says how many there are, ``lines`` has one line each.

    Examples
    --------
    >>> error = FaultyLogError("log.nc", Faults([Fault("unreadable", "the file is empty")]))
    >>> print(error)
    log.nc: 1 fault: the file is empty
    """

    def __init__(self, source: str, faults: Faults) -> None:
        self.source = source
        self.faults: tuple[Fault, ...] = tuple(faults.listed)
        self.counts: dict[str, int] = dict(faults.counts)
        self.lines: list[str] = faults.lines()
        total = sum(self.counts.values())
        first = str(self.faults[0]) if self.faults else ""
        if self.faults and self.faults[0].file is not None and first.startswith(source):
            first = first.removeprefix(source).lstrip("/: ")
        text = (
            f"{source}: 1 fault: {first}" if total == 1 else f"{source}: {total} faults; the first: {first}"
        )
        super().__init__(text)


class Faults:
    """A growing collection of faults: the first few of each kind are kept, all are counted.

    Examples
    --------
    >>> faults = Faults(limit=1)
    >>> faults.add(Fault("not-finite", "x is inf", line=2))
    >>> faults.add(Fault("not-finite", "x is inf", line=9))
    >>> faults.lines()
    ['line 2: x is inf', '... and 1 more of kind not-finite']
    """

    def __init__(self, faults: Iterable[Fault] = (), *, limit: int = LISTED_PER_KIND) -> None:
        self.limit = limit
        self.listed: list[Fault] = []
        self.counts: Counter[str] = Counter()
        for fault in faults:
            self.add(fault)

    def __bool__(self) -> bool:
        return bool(self.counts)

    @property
    def total(self) -> int:
        """The number of faults, listed or not."""
        return sum(self.counts.values())

    def add(self, fault: Fault) -> None:
        """Count one fault, and keep it unless its kind has been listed often enough."""
        if self.counts[fault.kind] < self.limit:
            self.listed.append(fault)
        self.counts[fault.kind] += fault.count

    def add_each(self, kind: str, places: Sequence[int], describe: Callable[[int], Fault]) -> None:
        """Count a fault at each place; only those that will be listed are described."""
        room = max(0, self.limit - self.counts[kind])
        self.listed.extend(describe(int(place)) for place in places[:room])
        self.counts[kind] += len(places)
        if self.counts[kind] == 0:
            del self.counts[kind]

    def extend(self, others: Faults) -> None:
        """Count all faults of another collection, and keep those that are listed there as far as there is room."""
        for fault in others.listed:
            if self.counts[fault.kind] < self.limit:
                self.listed.append(fault)
            self.counts[fault.kind] += fault.count
        unlisted = Counter(others.counts)
        for fault in others.listed:
            unlisted[fault.kind] -= fault.count
        self.counts.update(unlisted)

    def to_json(self) -> dict[str, Any]:
        """Return what `from_json` makes the same collection of."""
        return {"listed": [asdict(fault) for fault in self.listed], "counts": dict(self.counts)}

    @classmethod
    def from_json(cls, told: Mapping[str, Any]) -> Faults:
        """Return the collection that `to_json` told.

        Examples
        --------
        >>> told = Faults([Fault("not-finite", "x is inf", line=line) for line in range(50)]).to_json()
        >>> (len(told["listed"]), Faults.from_json(told).to_json() == told)
        (20, True)
        """
        faults = cls(Fault(**fault) for fault in told["listed"])
        faults.counts.clear()
        faults.counts.update(told["counts"])
        return faults

    def lines(self) -> list[str]:
        """Return one line a listed fault, and one line for what is left out of each kind."""
        return [str(fault) for fault in self.listed] + _unlisted(self.listed, self.counts)

    def raise_if_any(self, source: str) -> None:
        """Raise `FaultyLogError` when there is at least one fault."""
        if self:
            raise FaultyLogError(source, self)


@dataclass(frozen=True)
class Report:
    """What validation found: faults (the log cannot be trusted) and warnings (look at these).

    Examples
    --------
    >>> Report.of("log.nc", Faults(), Faults()).ok
    True
    """

    source: str
    faults: tuple[Fault, ...]
    warnings: tuple[Fault, ...]
    fault_counts: dict[str, int]
    warning_counts: dict[str, int]
    sizes: dict[str, int] = field(default_factory=dict)

    @classmethod
    def of(cls, source: str, faults: Faults, warnings: Faults, sizes: dict[str, int] | None = None) -> Report:
        """Close two collections into a report; damage comes first, since other faults may follow from it."""
        return cls(
            source,
            tuple(sorted(faults.listed, key=lambda fault: fault.kind != "checksum")),
            tuple(warnings.listed),
            dict(faults.counts),
            dict(warnings.counts),
            dict(sizes or {}),
        )

    def told(self) -> dict[str, Any]:
        """Return the ``report`` as JSON and the ``lines`` that people read."""
        return {"report": self.to_json(), "lines": self.lines()}

    @classmethod
    def from_json(cls, told: Mapping[str, Any]) -> Report:
        """Return the report that `to_json` told.

        Examples
        --------
        >>> report = Report.of("log.nc", Faults([Fault("empty", "there are no rows")]), Faults())
        >>> Report.from_json(report.to_json()) == report
        True
        """
        return cls(
            told["source"],
            tuple(Fault(**fault) for fault in told["faults"]),
            tuple(Fault(**fault) for fault in told["warnings"]),
            dict(told["fault_counts"]),
            dict(told["warning_counts"]),
            dict(told["sizes"]),
        )

    @property
    def ok(self) -> bool:
        """Whether the log is sound (it may still have warnings)."""
        return not self.fault_counts

    def lines(self) -> list[str]:
        """Return one line a fault, then one line a warning."""
        found = []
        for label, items, counts in (
            ("fault", self.faults, self.fault_counts),
            ("warning", self.warnings, self.warning_counts),
        ):
            found += [f"{label}: {line}" for line in [*map(str, items), *_unlisted(items, counts)]]
        return found

    def raise_if_faulty(self) -> None:
        """Raise `FaultyLogError` unless the log is sound."""
        if not self.ok:
            faults = Faults(self.faults)
            faults.counts.update(
                {kind: count - faults.counts[kind] for kind, count in self.fault_counts.items()}
            )
            raise FaultyLogError(self.source, faults)

    def to_json(self) -> dict[str, Any]:
        """Return what ``ppinfer validate --json`` prints."""
        return {
            "source": self.source,
            "ok": self.ok,
            "sizes": self.sizes,
            "fault_counts": self.fault_counts,
            "warning_counts": self.warning_counts,
            "faults": [asdict(fault) for fault in self.faults],
            "warnings": [asdict(fault) for fault in self.warnings],
        }


def _unlisted(listed: Iterable[Fault], counts: Mapping[str, int]) -> list[str]:
    told: Counter[str] = Counter()
    for fault in listed:
        told[fault.kind] += fault.count
    return [
        f"... and {count - told[kind]} more of kind {kind}"
        for kind, count in counts.items()
        if count > told[kind]
    ]
