"""Segments of a tidy table: runs of one true goal in a column, or a table of their own."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from jaxtyping import Bool, Float, Int

from ppinfer.studies.faults import Faults
from ppinfer.studies.readers.mapping import Mapping, SegmentsFile, closest
from ppinfer.studies.readers.tables import Labels, Table, read_table
from ppinfer.studies.readers.tidy_samples import Samples, scaled


def read_segments(
    table: Table, mapping: Mapping, samples: Samples, goals: list[str] | None, folder: Path, faults: Faults
) -> dict[str, Any]:
    """Return ``segment_trial``, ``segment_agent``, ``segment_start``, ``segment_stop`` and ``true_goal``."""
    found: list[tuple[Any, ...]] = []
    if mapping.segments_file is not None:
        found.append(_from_file(mapping.segments_file, mapping, samples, goals, folder, faults))
    else:
        for agent, told in mapping.motions().items():
            if told.true_goal is not None:
                found.append(
                    _from_column(table, told.true_goal, agent, bool(mapping.agents), samples, goals, faults)
                )
    trial = np.concatenate([part[0] for part in found]) if found else np.zeros(0, np.int64)
    start = np.concatenate([part[2] for part in found]) if found else np.zeros(0, np.int64)
    stop = np.concatenate([part[3] for part in found]) if found else np.zeros(0, np.int64)
    agents = [agent for part in found for agent in part[1]]
    true_goal = [goal for part in found for goal in part[4]]
    order = np.lexsort((start, trial)).tolist()
    return {
        "segment_trial": trial[order],
        "segment_agent": [agents[index] for index in order],
        "segment_start": start[order],
        "segment_stop": stop[order],
        "true_goal": [true_goal[index] for index in order],
    }


def _from_column(
    table: Table,
    column: str,
    agent: str,
    wide: bool,
    samples: Samples,
    goals: list[str] | None,
    faults: Faults,
) -> tuple[Any, ...]:
    told = table.text(column)
    _check_goals(table, told, column, goals, faults)
    # by agent and sample, so that a run is a stretch of neighbouring rows
    order = np.lexsort((samples.row_sample, samples.row_agent))
    code, trial, row_agent = told.codes[order], samples.row_trial[order], samples.row_agent[order]
    begins = np.ones(order.size, bool)
    begins[1:] = (np.diff(code) != 0) | (np.diff(trial) != 0) | (np.diff(row_agent) != 0)
    first = np.flatnonzero(begins)
    last = np.append(first[1:], order.size) - 1
    kept = code[first] >= 0
    first, last = first[kept], last[kept]
    offset = samples.offsets[trial[first]]
    start = samples.row_sample[order[first]] - offset
    stop = samples.row_sample[order[last]] - offset + 1
    agents = [agent] * first.size if wide else [samples.agents[index] for index in row_agent[first].tolist()]
    return trial[first], agents, start, stop, [told.labels[index] for index in code[first].tolist()]


def _check_goals(table: Table, told: Labels, column: str, goals: list[str] | None, faults: Faults) -> None:
    if goals is None:
        # the goals' own table is faulty, and that is told
        return
    known = np.array([label in goals for label in told.labels] + [True])
    faults.add_each(
        "unknown-goal",
        np.flatnonzero(~known[told.codes]).tolist(),
        lambda row: table.fault(
            "unknown-goal",
            f"there is no goal {told.labels[told.codes[row]]!r}",
            row,
            column,
            closest(told.labels[told.codes[row]], goals),
        ),
    )


def _from_file(
    told: SegmentsFile,
    mapping: Mapping,
    samples: Samples,
    goals: list[str] | None,
    folder: Path,
    faults: Faults,
) -> tuple[Any, ...]:
    none: tuple[Any, ...] = (np.zeros(0, np.int64), [], np.zeros(0, np.int64), np.zeros(0, np.int64), [])
    names = ["trial", "start", "stop"] + [
        name for name in ("true_goal", "agent") if getattr(told, name) is not None
    ]
    wanted = [(getattr(told, name), f"segments_file.{name}") for name in names]
    table = read_table(folder / told.path, wanted, mapping.file, faults)
    if table is None:
        return none
    before = faults.total
    trial = _indices(table, told.trial, samples.trial_ids, "trial", faults)
    agent = np.zeros(table.n_rows, np.int64)
    if told.agent is not None:
        agent = _indices(table, told.agent, samples.agents, "agent", faults)
    elif len(samples.agents) > 1:
        table.report(
            faults,
            "unknown-agent",
            np.array([0]),
            told.trial,
            "whose segment is it?",
            "name agent in [segments_file]",
        )
    true_goal = [""] * table.n_rows
    if told.true_goal is not None:
        labels = table.text(told.true_goal)
        _check_goals(table, labels, told.true_goal, goals, faults)
        true_goal = [labels.labels[code] if code >= 0 else "" for code in labels.codes.tolist()]
    edges = []
    for name in (told.start, told.stop):
        values = table.numbers(name, faults)
        table.report(faults, "missing-value", np.flatnonzero(np.isnan(values)), name, "there is no value")
        if told.by == "sample":
            whole = np.isnan(values) | (values == np.trunc(values))
            table.report(faults, "not-a-number", np.flatnonzero(~whole), name, "expected a whole number")
        edges.append(values)
    backwards = edges[0] >= edges[1]
    table.report(
        faults,
        "segment-range",
        np.flatnonzero(backwards),
        told.stop,
        "a segment must stop after it starts",
        "segments are half-open, [start, stop)",
    )
    if faults.total > before:
        return none
    if told.by == "time":
        times = [scaled(edge, "time", mapping.units.time) for edge in edges]
        start, stop = (_samples_at(edge, trial, samples) for edge in times)
        wrong = _leaves_trial(times[0], times[1], trial, samples) | (start >= stop)
    else:
        start, stop = (edge.astype(np.int64) for edge in edges)
        wrong = (start < 0) | (stop > samples.row_size[trial]) | (start >= stop)
    table.report(
        faults,
        "segment-range",
        np.flatnonzero(wrong),
        told.start,
        "holds no sample of its trial, or leaves it",
        "segments are half-open, [start, stop), and lie within their trial",
    )
    return trial, [samples.agents[index] for index in agent.tolist()], start, stop, true_goal


def _indices(
    table: Table, column: str, known: list[str], what: str, faults: Faults
) -> Int[np.ndarray, " row"]:
    told = table.text(column)
    index_of = {name: index for index, name in enumerate(known)}
    found: Int[np.ndarray, " row"] = np.array([index_of.get(name, -1) for name in told.labels] + [-1])[
        told.codes
    ]
    table.report(
        faults, f"unknown-{what}", np.flatnonzero(found < 0), column, f"there is no such {what} in the table"
    )
    return found


def _leaves_trial(
    start: Float[np.ndarray, " row"],
    stop: Float[np.ndarray, " row"],
    trial: Int[np.ndarray, " row"],
    samples: Samples,
) -> Bool[np.ndarray, " row"]:
    """Return which segments begin before their trial or end more than one time step after its last sample."""
    size = samples.row_size[trial]
    first = samples.time[samples.offsets[trial]]
    last = samples.time[samples.offsets[trial] + size - 1]
    # of a trial of one sample the step is not known: anything goes that holds it
    step = np.where(size > 1, (last - first) / np.maximum(size - 1, 1), np.inf)
    slack = 1.001 * step
    leaves: Bool[np.ndarray, " row"] = (start < first - slack) | (stop > last + slack)
    return leaves


def _samples_at(
    time: np.ndarray, trial: Int[np.ndarray, " row"], samples: Samples
) -> Int[np.ndarray, " row"]:
    """Return the first sample of each row's trial at or after a time."""
    ordered = samples.sample_trial + 1j * samples.time
    found: Int[np.ndarray, " row"] = np.searchsorted(ordered, trial + 1j * time) - samples.offsets[trial]
    return found
