"""The answers to a survey: one row a response, one column an item."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import Literal, cast, get_args

import numpy as np
from jaxtyping import Bool, Float, Int

from ppinfer.errors import LogError
from ppinfer.studies.faults import Fault, Faults
from ppinfer.studies.readers.mapping import closest
from ppinfer.studies.surveys.instrument import Instrument
from ppinfer.studies.surveys.pseudonyms import pseudonyms

Missing = Literal["refuse", "drop-responses", "mean-of-answered"]
MISSING: tuple[str, ...] = get_args(Missing)
BETWEEN_FACTORS = " / "


@dataclass(frozen=True, eq=False)
class Survey:
    """Who answered what under which condition.

    Attributes
    ----------
    instrument : Instrument
        What the columns mean.
    values : (response, item) float64
        As answered, nothing reversed; NaN where there is no answer.
    participant : (response,) int64
        Index of the participant.
    participants : tuple of str
        Pseudonyms, or the names in the table where they were kept.
    conditions : tuple of tuple of str
        The condition of each response: a label for each of the instrument's condition columns.
    position : (response,) int64
        Of the condition in the participant's order, from 1; 0 = unknown.
    line : (response,) int64
        Where the response stands in its file.
    source : str
        That file's name.
    """

    instrument: Instrument
    values: Float[np.ndarray, "response item"]
    participant: Int[np.ndarray, " response"]
    participants: tuple[str, ...] = field(repr=False)
    conditions: tuple[tuple[str, ...], ...] = field(repr=False)
    position: Int[np.ndarray, " response"]
    line: Int[np.ndarray, " response"]
    source: str = ""

    @property
    def n_responses(self) -> int:
        """How many responses there are."""
        return len(self.values)

    @property
    def missing(self) -> Bool[np.ndarray, "response item"]:
        """Where there is no answer."""
        return cast("Bool[np.ndarray, 'response item']", np.isnan(self.values))

    @property
    def turned(self) -> Float[np.ndarray, "response item"]:
        """The answers after reversing: lowest + highest - answer for items that are reversed."""
        values = self.values.copy()
        for at, (name, item) in enumerate(self.instrument.items.items()):
            if item.reversed:
                points = self.instrument.points(name)
                values[:, at] = points[0] + points[-1] - values[:, at]
        return values

    def scores(self) -> Float[np.ndarray, "response scale"]:
        """Return the score of each response on each scale: the mean of its answered items after reversing."""
        turned = self.turned
        scores = np.full((len(turned), len(self.instrument.scales)), np.nan)
        for at, name in enumerate(self.instrument.scales):
            rows = turned[:, self.columns_of(name)]
            answered = ~np.isnan(rows)
            some = answered.any(axis=1)
            scores[some, at] = np.where(answered, rows, 0.0).sum(axis=1)[some] / answered.sum(axis=1)[some]
        return scores

    def columns_of(self, scale: str) -> list[int]:
        """Return which columns of `values` are the items of a scale."""
        names = list(self.instrument.items)
        return [names.index(item) for item in self.instrument.scales[scale].items]

    def labels(self, by: Sequence[str] | None = None) -> list[str]:
        """Return one label a response: its conditions, or those of some condition columns.

        Raises
        ------
        LogError
            If the instrument has no such condition column.
        """
        factors = self.instrument.factors
        for name in by or ():
            if name not in factors:
                raise LogError(
                    f"no condition column {name!r} in the instrument; {closest(name, factors)}; "
                    "name it under [columns] condition"
                )
        kept = range(len(factors)) if by is None else [factors.index(name) for name in by]
        return [BETWEEN_FACTORS.join(condition[at] for at in kept) for condition in self.conditions]

    def groups(self, by: Sequence[str] | None = None) -> dict[str, Int[np.ndarray, " row"]]:
        """Return the responses under each condition, in the instrument's order or else sorted."""
        factors = self.instrument.factors
        kept = range(len(factors)) if by is None else [factors.index(name) for name in by if name in factors]
        labels = self.labels(by)
        rank = {
            label: tuple(self._rank(factors[at], condition[at]) for at in kept)
            for label, condition in zip(labels, self.conditions, strict=True)
        }
        ordered = sorted(rank, key=lambda label: rank[label])
        names = np.array(labels, object)
        return {label: np.flatnonzero(names == label) for label in ordered}

    def _rank(self, factor: str, label: str) -> tuple[int, str]:
        listed = list(self.instrument.conditions.get(factor, ()))
        return (listed.index(label) if label in listed else len(listed), label)

    def take(self, rows: Int[np.ndarray, " row"]) -> Survey:
        """Return some of the responses; participants without any are left out."""
        kept, participant = np.unique(self.participant[rows], return_inverse=True)
        return replace(
            self,
            values=self.values[rows],
            participant=participant,
            participants=tuple(self.participants[who] for who in kept),
            conditions=tuple(self.conditions[row] for row in rows),
            position=self.position[rows],
            line=self.line[rows],
        )

    def pseudonyms(self, seed: int = 0) -> dict[str, str]:
        """Return a pseudonym for each participant, made of the answers alone (`pseudonyms`)."""
        keys = list(zip(self.conditions, self.position.tolist(), strict=True))
        return dict(
            zip(self.participants, pseudonyms(self.participant, keys, self.values, seed=seed), strict=True)
        )

    def pseudonymised(self, seed: int = 0) -> Survey:
        """Return the same with participants called P01, P02, ..., and responses in that order.

        Even sums of numbers with digits after the point depend on their order, so nothing is left of the table's.
        """
        named = self.pseudonyms(seed)
        names = sorted(named.values())
        number = np.array([names.index(named[who]) for who in self.participants], np.int64)[self.participant]
        ranks = {row: rank for rank, rows in enumerate(self.groups().values()) for row in rows.tolist()}
        rows = np.array(sorted(range(len(number)), key=lambda row: (number[row], ranks[row])), np.int64)
        renumbered = replace(self, participant=number, participants=tuple(names))
        return renumbered.take(rows)

    def complete(self, missing: str = "refuse") -> Survey:
        """Return the survey with missing answers treated as chosen.

        Parameters
        ----------
        missing : {"refuse", "drop-responses", "mean-of-answered"}
            Refuse them; leave out every response that lacks an answer; or keep them: an item is then summarised over
            those who answered it, a scale's score is the mean of its answered items, and its alpha is that of the
            responses that answered all of its items.

        Raises
        ------
        FaultyLogError
            If answers are missing and are refused: with line, condition and column of each.
        LogError
            If no response is left.
        """
        if missing not in MISSING:
            raise LogError(f"missing={missing!r}; expected one of {', '.join(MISSING)}")
        if not self.missing.any() or missing == "mean-of-answered":
            return self
        if missing == "refuse":
            faults = Faults()
            for fault in self.missing_cells():
                faults.add(fault)
            faults.raise_if_any(self.source)
        rows = np.flatnonzero(~self.missing.any(axis=1))
        if not len(rows):
            raise LogError(f"{self.source}: every response lacks an answer, so that none is left")
        return self.take(rows)

    def missing_cells(self) -> list[Fault]:
        """Return where answers are missing, in the order of the file; nobody is named."""
        names = list(self.instrument.items)
        rows, columns = np.nonzero(self.missing)
        order = np.lexsort((columns, self.line[rows]))
        labels = self.labels()
        return [
            Fault(
                "missing-answer",
                "no answer" + (f" (condition {labels[row]!r})" if labels[row] else ""),
                "choose --missing drop-responses or mean-of-answered",
                file=self.source,
                line=int(self.line[row]),
                column=self.instrument.column(names[column]),
            )
            for row, column in zip(rows[order].tolist(), columns[order].tolist(), strict=True)
        ]
