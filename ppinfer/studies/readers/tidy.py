"""Tidy tables: a row a sample (or a row a sample and agent), with a mapping of the columns."""

from __future__ import annotations

import os
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import xarray as xr
from jaxtyping import Bool, Float, Int

from ppinfer.studies.assembling import build_log
from ppinfer.studies.checksums import file_sha256
from ppinfer.studies.faults import Faults

if TYPE_CHECKING:
    from ppinfer.studies.readers.mapping import Mapping
    from ppinfer.studies.readers.tables import Labels, Table
    from ppinfer.studies.readers.tidy_samples import Samples


def read_tidy(path: str | os.PathLike[str], mapping: str | os.PathLike[str]) -> xr.Dataset:
    r"""Read a CSV or Parquet table through a mapping of its columns.

    Trials may lie one after another or interleaved; within a trial (and agent) times must increase. See
    ``docs/log-format.md`` for the mapping.

    Parameters
    ----------
    path
        The table; ``.parquet`` or ``.pq`` is Parquet, anything else CSV.
    mapping
        The mapping, a TOML file.

    Raises
    ------
    FaultyLogError
        Listing everything wrong with the mapping, or everything wrong with the table: each with line and
        column.

    Examples
    --------
    >>> _ = Path("reaches.csv").write_text("game,who,t,px,py\n1,p1,0.0,0,0\n1,p1,0.1,0,1\n")
    >>> columns = 'trial = "game"\nparticipant = "who"\ntime = "t"\nx = "px"\ny = "py"\n'
    >>> units = '[units]\ntime = "s"\nposition = "m"\n'
    >>> _ = Path("reaches.toml").write_text(f'[columns]\n{columns}[constants]\nagent = "human"\n{units}')
    >>> read_tidy("reaches.csv", "reaches.toml").sizes["sample"]
    2
    """
    from ppinfer.studies.readers.mapping import read_mapping
    from ppinfer.studies.readers.tables import read_table
    from ppinfer.studies.readers.tidy_goals import read_goals
    from ppinfer.studies.readers.tidy_samples import read_samples
    from ppinfer.studies.readers.tidy_segments import read_segments
    from ppinfer.studies.readers.tidy_variables import check_variables, read_variables

    source, mapping_path = Path(path), Path(mapping)
    faults = Faults()
    told = read_mapping(mapping_path, faults)
    if told is None:
        faults.raise_if_any(str(mapping_path))
    assert told is not None
    table = read_table(source, _wanted(told), told.file, faults)
    if table is None:
        faults.raise_if_any(str(source))
    assert table is not None

    samples = read_samples(table, told, faults)
    if samples is None:
        # without samples the cells can still be read, so that their faults are told with those of the times
        _read_numbers(table, told, faults)
        check_variables(table, told, faults)
        faults.raise_if_any(str(source))
    assert samples is not None
    moved, has = _motion(table, told, samples, faults)
    goals, goal_position = read_goals(table, told, samples, mapping_path.parent, faults)
    segments = read_segments(table, told, samples, goals, mapping_path.parent, faults)
    per_trial = _per_trial(table, told, samples, faults)
    others = read_variables(table, told, samples, faults)
    notes = others.pop("notes")
    faults.raise_if_any(str(source))
    return build_log(
        agents=samples.agents,
        space=told.space(),
        goals=goals or [],
        row_size=samples.row_size,
        trial_id=samples.trial_ids,
        time=samples.time,
        position=moved["position"],
        velocity=moved.get("velocity"),
        has_velocity=has.get("velocity"),
        control=moved.get("control"),
        has_control=has.get("control"),
        control_quantity=told.constants.control_quantity,
        goal_position=goal_position,
        **per_trial,
        **segments,
        title=told.title,
        source=source.name,
        position_units=told.units.label or "m",
        configuration={"reader": "tidy", "mapping": told.model_dump(exclude_defaults=True)},
        attrs={"source_sha256": file_sha256(source), "notes": notes},
        **others,
    )


def _wanted(mapping: Mapping) -> list[tuple[str, str]]:
    tables: dict[str, Any] = {"columns": mapping.columns}
    tables |= {f"agents.{label}": told for label, told in mapping.agents.items()}
    tables |= {f"goal_columns.{label}": told for label, told in mapping.goal_columns.items()}
    named = [
        (column, f"{where}.{name}")
        for where, told in tables.items()
        for name in type(told).model_fields
        if (column := getattr(told, name)) is not None
    ]
    return named + [
        (column, f"variables.{name}")
        for name, told in mapping.variables.items()
        for column in told.all_columns()
    ]


def _read_numbers(table: Table, mapping: Mapping, faults: Faults) -> None:
    for motion in mapping.motions().values():
        for name in type(motion).model_fields:
            column = getattr(motion, name)
            if column is not None and name != "true_goal":
                table.numbers(column, faults)


def _motion(
    table: Table, mapping: Mapping, samples: Samples, faults: Faults
) -> tuple[dict[str, Float[np.ndarray, "sample agent space"]], dict[str, list[bool]]]:
    from ppinfer.studies.readers.tidy_samples import scaled

    space = mapping.space()
    shape = (samples.time.size, len(samples.agents), len(space))
    motions = mapping.motions()
    velocity_unit: Any = mapping.units.velocity
    moved: dict[str, Float[np.ndarray, "sample agent space"]] = {}
    has: dict[str, list[bool]] = {}
    for kind, prefix in (("position", ""), ("velocity", "v"), ("control", "u")):
        named = {agent: [getattr(told, prefix + name) for name in space] for agent, told in motions.items()}
        if all(None in columns for columns in named.values()):
            continue
        values = np.full(shape, np.nan)
        for agent, columns in named.items():
            if None in columns:
                continue
            cells = np.stack([table.numbers(column, faults) for column in columns], axis=1)
            if kind == "velocity" and velocity_unit is not None:
                cells = scaled(cells, "velocity", velocity_unit)
            else:
                # velocities and controls count in the position's units unless the mapping says otherwise
                cells = scaled(cells, "position", mapping.units.position)
            _check_missing(table, mapping, cells, columns, kind, moved, samples, agent, faults)
            cells[np.isnan(cells).any(axis=1)] = np.nan
            index = samples.row_agent if not mapping.agents else samples.agents.index(agent)
            values[samples.row_sample, index] = cells
        moved[kind] = values
        if kind != "position":
            logged = {agent: None not in columns for agent, columns in named.items()}
            has[kind] = [logged.get(agent, logged.get("", False)) for agent in samples.agents]
    if mapping.missing == "fault" and not mapping.agents:
        _check_every_agent(samples, table, faults)
    return moved, has


def _check_missing(
    table: Table,
    mapping: Mapping,
    cells: Float[np.ndarray, "row space"],
    columns: list[str],
    kind: str,
    moved: dict[str, Float[np.ndarray, "sample agent space"]],
    samples: Samples,
    agent: str,
    faults: Faults,
) -> None:
    missing: Bool[np.ndarray, "row space"] = np.isnan(cells)
    if mapping.missing == "dropout":
        if kind == "position":
            return
        index = samples.row_agent if not mapping.agents else samples.agents.index(agent)
        seen = ~np.isnan(moved["position"][samples.row_sample, index]).any(axis=1)
        missing = missing & seen[:, None]
    remedy = 'fill it in, or set missing = "dropout" in the mapping if the agent was not seen'
    if mapping.missing == "dropout":
        remedy = f"a {kind} is missing only where the position is"
    for index_of, column in enumerate(columns):
        table.report(
            faults,
            "missing-value",
            np.flatnonzero(missing[:, index_of]),
            column,
            f"there is no {kind}",
            remedy,
        )


def _check_every_agent(samples: Samples, table: Table, faults: Faults) -> None:
    present = np.zeros((samples.time.size, len(samples.agents)), bool)
    present[samples.row_sample, samples.row_agent] = True
    absent = np.argwhere(~present)

    def describe(index: int) -> Any:
        sample, agent = absent[index].tolist()
        row = int(np.flatnonzero(samples.row_sample == sample)[0])
        trial = samples.trial_ids[samples.sample_trial[sample]]
        return table.fault(
            "missing-row",
            f"trial {trial!r} has no row of {samples.agents[agent]!r} at {samples.time[sample]:.12g} s",
            row,
            None,
            'add it, or set missing = "dropout" in the mapping if it was not seen',
        )

    faults.add_each("missing-row", range(len(absent)), describe)


def _per_trial(table: Table, mapping: Mapping, samples: Samples, faults: Faults) -> dict[str, Any]:
    told: dict[str, Any] = {}
    n_trials = len(samples.trial_ids)
    first = np.full(n_trials, table.n_rows)
    np.minimum.at(first, samples.row_trial, np.arange(table.n_rows))
    for name in ("participant", "condition", "outcome", "round", "seed"):
        column = getattr(mapping.columns, name)
        if column is None:
            constant = getattr(mapping.constants, name, None)
            if constant is not None:
                told[name] = [constant] * n_trials
            continue
        values = table.text(column)
        _check_constant(table, values, values.codes[first][samples.row_trial], name, column, samples, faults)
        if name in ("round", "seed"):
            numbers = table.numbers(column, faults)[first]
            whole = np.isfinite(numbers) & (numbers == np.trunc(numbers))
            table.report(faults, "not-a-number", first[~whole], column, "expected a whole number")
            told[name] = np.where(whole, numbers, -1).astype(np.int64)
        else:
            if name == "participant":
                rows = first[values.codes[first] < 0]
                table.report(faults, "missing-value", rows, column, "there is no value")
            told[name] = [_label(values, code) for code in values.codes[first].tolist()]
    return told


def _check_constant(
    table: Table,
    values: Labels,
    usual: Int[np.ndarray, " row"],
    name: str,
    column: str,
    samples: Samples,
    faults: Faults,
) -> None:
    faults.add_each(
        "not-constant",
        np.flatnonzero(values.codes != usual).tolist(),
        lambda row: table.fault(
            "not-constant",
            f"{name} is {_label(values, int(values.codes[row]))!r}, earlier in trial "
            f"{samples.trial_ids[samples.row_trial[row]]!r} it is {_label(values, int(usual[row]))!r}",
            row,
            column,
            "a trial has one: give its parts different trials",
        ),
    )


def _label(values: Labels, code: int) -> str:
    return str(values.labels[code]) if code >= 0 else ""
