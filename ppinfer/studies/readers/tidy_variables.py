"""Further variables of a tidy table: one value a trial or a sample, or one for each agent of these."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from jaxtyping import Bool, Int, Shaped

from ppinfer.studies.faults import Fault, Faults
from ppinfer.studies.readers.cell_kinds import cell_values, kind_of_cells
from ppinfer.studies.readers.mapping import Mapping, VariableColumn
from ppinfer.studies.readers.tables import Table
from ppinfer.studies.readers.tidy_samples import Samples
from ppinfer.studies.readers.variable_names import (
    ARGUMENTS,
    DIMS_OF,
    CellKind,
    Per,
    known_variable,
    wrong_with_variable,
)

_FILL: dict[CellKind, Any] = {"number": np.nan, "time": np.nan, "integer": 0, "flag": 0, "text": ""}


@dataclass(frozen=True)
class _Part:
    """One column: its values, and the agent of each row."""

    column: str
    values: Shaped[np.ndarray, " row"]
    row_agent: Int[np.ndarray, " row"]


def read_variables(table: Table, mapping: Mapping, samples: Samples, faults: Faults) -> dict[str, Any]:
    """Return ``variables`` and further arguments of `ppinfer.studies.build_log`, and ``notes`` on what was inferred."""
    variables: dict[str, tuple[Any, ...]] = {}
    arguments: dict[str, Any] = {}
    notes = []
    for name, told in mapping.variables.items():
        wrong = wrong_with_variable(name, told, samples.agents, wide=bool(mapping.agents))
        for message in wrong:
            faults.add(Fault("mapping", message))
        if wrong:
            continue
        known = known_variable(name, samples.agents)
        kind = told.kind or (known.kinds[0] if known else kind_of_cells(table, told.all_columns(), faults))
        if kind is None:
            continue
        before = faults.total
        parts = _parts(table, mapping, told, kind, samples, faults)
        if faults.total > before:
            # a wrong cell is told once, and not for differing from the others too
            continue
        per = told.per or (known.per if known else _inferred(parts, samples, told.columns is not None))
        values = _gathered(table, parts, name, per, kind, samples, faults)
        if name in ARGUMENTS:
            arguments[name] = values
        else:
            variables[name] = (DIMS_OF[per], values, {"units": "s"} if kind == "time" else {})
        if known is None and (told.per is None or told.kind is None):
            notes.append(f"variable {name!r}: {kind}, one a {per}, as its cells say")
    return {"variables": variables, **arguments, "notes": "\n".join(notes)}


def check_variables(table: Table, mapping: Mapping, faults: Faults) -> None:
    """Report the faults of cells whose kind is said, where there are no samples to put them in."""
    for name, told in mapping.variables.items():
        known = known_variable(name, list(mapping.agents))
        kind = told.kind or (known.kinds[0] if known else None)
        if kind is not None:
            for column in told.all_columns():
                cell_values(table, column, kind, mapping.units.time, faults)


def _parts(
    table: Table, mapping: Mapping, told: VariableColumn, kind: CellKind, samples: Samples, faults: Faults
) -> list[_Part]:
    unit = mapping.units.time
    if told.columns is None:
        return [
            _Part(column, cell_values(table, column, kind, unit, faults), samples.row_agent)
            for column in told.all_columns()
        ]
    return [
        _Part(
            column,
            cell_values(table, column, kind, unit, faults),
            np.full(table.n_rows, samples.agents.index(agent)),
        )
        for agent, column in told.columns.items()
    ]


def _inferred(parts: list[_Part], samples: Samples, of_agents: bool) -> Per:
    """Return the first of these that all cells allow."""
    order: list[Per] = ["trial-agent"] if of_agents else ["trial", "sample", "trial-agent"]
    for per in order:
        if not any(_strays(part, _places(part, per, samples)).any() for part in parts):
            return per
    return "sample-agent"


def _places(part: _Part, per: Per, samples: Samples) -> Int[np.ndarray, " row"]:
    """Return where the value of each row belongs."""
    rows = samples.row_trial if per.startswith("trial") else samples.row_sample
    return rows * len(samples.agents) + part.row_agent if per.endswith("-agent") else rows


def _first_rows(places: Int[np.ndarray, " row"]) -> tuple[Int[np.ndarray, " place"], Int[np.ndarray, " row"]]:
    """Return the first row of each place that has one, and for each row the first row of its place."""
    _, first, which = np.unique(places, return_index=True, return_inverse=True)
    return first, first[which.reshape(-1)]


def _strays(part: _Part, places: Int[np.ndarray, " row"]) -> Bool[np.ndarray, " row"]:
    """Return the rows that say something else than the first row of their place."""
    usual = part.values[_first_rows(places)[1]]
    values = part.values
    # NaN is the same as itself
    same: np.ndarray = (values == usual) | ((values != values) & (usual != usual))
    return ~same.astype(bool)


def _gathered(
    table: Table, parts: list[_Part], name: str, per: Per, kind: CellKind, samples: Samples, faults: Faults
) -> Shaped[np.ndarray, "..."]:
    shape = [len(samples.trial_ids) if per.startswith("trial") else samples.time.size]
    shape += [len(samples.agents)] if per.endswith("-agent") else []
    size = int(np.prod(shape))
    gathered = np.full(size, _FILL[kind], parts[0].values.dtype)
    filled = np.zeros(size, bool)
    for part in parts:
        places = _places(part, per, samples)
        first, usual = _first_rows(places)
        _report_strays(table, part, name, per, np.flatnonzero(_strays(part, places)), usual, samples, faults)
        gathered[places[first]] = part.values[first]
        filled[places[first]] = True
    if kind in ("integer", "flag") and not filled.all():
        _report_absent(table, parts[0].column, name, per, np.flatnonzero(~filled), samples, faults)
    return gathered.reshape(shape)


def _report_strays(
    table: Table,
    part: _Part,
    name: str,
    per: Per,
    strays: Int[np.ndarray, " stray"],
    usual: Int[np.ndarray, " row"],
    samples: Samples,
    faults: Faults,
) -> None:
    def describe(row: int) -> Fault:
        trial = samples.trial_ids[samples.row_trial[row]]
        agent = samples.agents[part.row_agent[row]] if per.endswith("-agent") else ""
        at = f"of trial {trial!r}" + (f" and agent {agent!r}" if agent else "")
        return table.fault(
            "not-constant",
            f"{name} is {_shown(part.values[row])}, in line {table.lines[usual[row]]} {at} it is "
            f"{_shown(part.values[usual[row]])}",
            row,
            part.column,
            {
                "trial": 'a trial has one; say per = "sample" in [variables] if samples differ',
                "sample": 'agents of one sample share it; say per = "sample-agent" in [variables] if each has its own',
                "trial-agent": "an agent has one in a trial",
                "sample-agent": "an agent has one at each sample",
            }[per],
        )

    faults.add_each("not-constant", strays.tolist(), describe)


def _report_absent(
    table: Table,
    column: str,
    name: str,
    per: Per,
    places: Int[np.ndarray, " place"],
    samples: Samples,
    faults: Faults,
) -> None:
    rows = samples.row_trial if per.startswith("trial") else samples.row_sample

    def describe(place: int) -> Fault:
        at, agent = divmod(place, len(samples.agents))
        return table.fault(
            "missing-value",
            f"there is no row of {samples.agents[agent]!r} here that says its {name}",
            int(np.flatnonzero(rows == at)[0]),
            column,
            'add it, or say kind = "number" in [variables]: then it is NaN',
        )

    faults.add_each("missing-value", places.tolist(), describe)


def _shown(value: Any) -> str:
    return repr(value) if isinstance(value, str) else f"{value:.12g}"
