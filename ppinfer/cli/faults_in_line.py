"""All faults of an input in the one line that a failure has: each of them, and once what to do."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

from ppinfer.studies.faults import Fault, FaultyLogError


def faults_in_line(error: FaultyLogError) -> str:
    """Return every fault in one line: where and what it is, and at the end what to do, without repeating it.

    Examples
    --------
    >>> from ppinfer.studies.faults import Faults
    >>> twice = [Fault("empty", "no answer", "fill it in", file="a.csv", line=line) for line in (2, 5)]
    >>> faults_in_line(FaultyLogError("a.csv", Faults(twice)))
    'a.csv: 2 faults: line 2: no answer | line 5: no answer; fill it in'
    """
    total = sum(error.counts.values())
    name = Path(error.source).name or error.source
    told = [_own(fault) for fault in error.faults] + error.lines[len(error.faults) :]
    told = [line.removeprefix(f"{name}: ") for line in told]
    shared = dict.fromkeys(filter(None, (_shared(fault) for fault in error.faults)))
    counted = "" if total == 1 else f"{total} faults: "
    return f"{error.source}: {counted}{'; '.join([' | '.join(told), *shared])}"


def _own(fault: Fault) -> str:
    """Return a fault with the part of its remedy that is of no other one: the name that may be meant."""
    meant, listed, _ = fault.remedy.partition("? there are ")
    return str(replace(fault, remedy=f"{meant}?" if listed else ""))


def _shared(fault: Fault) -> str:
    _, listed, names = fault.remedy.partition("? there are ")
    return f"there are {names}" if listed else fault.remedy
