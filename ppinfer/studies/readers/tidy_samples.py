"""The rows of a tidy table become samples of trials: one for each time that any of a trial's agents has."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float, Int

from ppinfer.distributions.ragged import row_starts
from ppinfer.studies.faults import Faults
from ppinfer.studies.readers.mapping import Mapping, scale
from ppinfer.studies.readers.tables import Table


@dataclass(frozen=True)
class Samples:
    """How the rows of a table became samples of trials.

    Parameters
    ----------
    trial_ids, row_size, time
        As in the log.
    sample_trial
        The index of each sample's trial.
    agents
        Labels of the agents.
    row_trial, row_agent, row_sample
        For each row of the table its trial, its agent (in a wide table 0) and its sample in the whole log.
    """

    trial_ids: list[str]
    row_size: Int[np.ndarray, " trial"]
    time: Float[np.ndarray, " sample"]
    sample_trial: Int[np.ndarray, " sample"]
    agents: list[str]
    row_trial: Int[np.ndarray, " row"]
    row_agent: Int[np.ndarray, " row"]
    row_sample: Int[np.ndarray, " row"]

    @property
    def offsets(self) -> Int[np.ndarray, " trial"]:
        """Where each trial begins."""
        return row_starts(self.row_size)


def scaled(values: Float[np.ndarray, ...], quantity: str, unit: str | float) -> Float[np.ndarray, ...]:
    """Return values in SI units."""
    factors = scale(quantity, unit)
    assert factors is not None, "the mapping was checked"
    in_si: Float[np.ndarray, "*_"] = values * factors[0] / factors[1]
    return in_si


def read_samples(table: Table, mapping: Mapping, faults: Faults) -> Samples | None:
    """Cut the table's rows into trials and samples; None if times, trials or agents are faulty."""
    columns = mapping.columns
    assert columns.time is not None
    time = scaled(table.numbers(columns.time, faults), "time", mapping.units.time)
    table.report(faults, "missing-value", np.flatnonzero(np.isnan(time)), columns.time, "there is no time")
    trial, trial_ids = _codes(table, columns.trial, mapping.constants.trial, faults)
    agents = list(mapping.agents)
    if agents:
        agent = np.zeros(table.n_rows, np.int64)
    else:
        agent, agents = _codes(table, columns.agent, mapping.constants.agent, faults)
    if faults:
        return None

    # by trial and agent, in the file's order: there times must increase
    order = np.lexsort((agent, trial))
    late = np.zeros(table.n_rows, bool)
    same = (np.diff(trial[order]) == 0) & (np.diff(agent[order]) == 0)
    late[1:] = same & (np.diff(time[order]) <= 0)
    before = np.empty(table.n_rows, np.int64)
    before[order[1:]] = order[:-1]
    faults.add_each(
        "time-not-increasing",
        np.sort(order[late]).tolist(),
        lambda row: table.fault(
            "time-not-increasing",
            f"of trial {trial_ids[trial[row]]!r}: is {time[row]:.12g} s after {time[before[row]]:.12g} s (line "
            f"{table.lines[before[row]]})",
            row,
            columns.time,
            "sort the rows by time, or remove repeated ones",
        ),
    )
    if faults:
        return None

    # agents of a trial share its samples: one for each time that any of them has
    order = np.lexsort((time, trial))
    fresh = np.ones(table.n_rows, bool)
    fresh[1:] = (np.diff(trial[order]) != 0) | (np.diff(time[order]) != 0)
    row_sample = np.empty(table.n_rows, np.int64)
    row_sample[order] = np.cumsum(fresh) - 1
    first = order[fresh]
    return Samples(
        trial_ids=trial_ids,
        row_size=np.bincount(trial[first], minlength=len(trial_ids)),
        time=time[first],
        sample_trial=trial[first],
        agents=agents,
        row_trial=trial,
        row_agent=agent,
        row_sample=row_sample,
    )


def _codes(
    table: Table, column: str | None, constant: str | None, faults: Faults
) -> tuple[Int[np.ndarray, " row"], list[str]]:
    if column is None:
        return np.zeros(table.n_rows, np.int64), [constant or ""]
    told = table.text(column)
    table.report(faults, "missing-value", np.flatnonzero(told.codes < 0), column, "there is no value")
    return told.codes, told.labels
