"""Do replans make sense? Their row sizes, times, plans, costs, decisions and beliefs."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import xarray as xr
from jaxtyping import Bool, Float, Int, Shaped

from ppinfer.studies.faults import Fault, Faults
from ppinfer.studies.planned_rows import PlannedRows, cells
from ppinfer.studies.schema import PLAN_SETS, REPLAN_VARIABLES

_NORMALISATION_TOLERANCE = 1e-9
_TIME_TOLERANCE = 1e-6
DEEP = ("waypoint", "profile")
"""Dimensions so long that they are read in blocks of trials."""


@dataclass(frozen=True)
class ReplanPlaces:
    """Which trial and replan each row of a ragged dimension of replans is."""

    rows: PlannedRows
    names: list[str]

    def report(
        self,
        faults: Faults,
        kind: str,
        column: str,
        replans: Int[np.ndarray, " fault"],
        say: str | Callable[[int], str],
        remedy: str,
    ) -> None:
        """Count a fault at each of some replans; ``say`` is a text, or a function from the fault's number to one."""

        def describe(number: int) -> Fault:
            replan = int(replans[number])
            trial = int(np.searchsorted(self.rows.replan, replan, side="right")) - 1
            message = say(number) if callable(say) else say
            within = replan - int(self.rows.replan[trial])
            return Fault(kind, message, remedy, trial=self.names[trial], replan=within, column=column)

        faults.add_each(kind, range(replans.size), describe)

    def replan_of(self, dim: str, row: Int[np.ndarray, " row"]) -> Int[np.ndarray, " row"]:
        """Return the replan of some waypoints or profiles."""
        edges = self.rows.profile
        if dim == "waypoint":
            row = np.searchsorted(self.rows.waypoint, row, side="right") - 1
            edges = self.rows.plan
        return np.asarray(np.searchsorted(edges, row, side="right") - 1)


def planned_rows(log: xr.Dataset, usable: set[str], names: list[str], faults: Faults) -> PlannedRows | None:
    """Report row sizes that do not add up; return where replans lie, or None where that cannot be said."""
    if not set(REPLAN_VARIABLES) <= usable or "agent" not in usable:
        return None
    before = sum(faults.counts.values())
    sizes = {dim: int(log.sizes[dim]) for dim in ("replan", "plan", "waypoint", "profile")}
    replans, plans, waypoints = (
        log.variables[name].values for name in ("replan_row_size", "plan_row_size", "waypoint_row_size")
    )
    faults.add_each(
        "wrong-length",
        np.flatnonzero(replans < 0).tolist(),
        lambda trial: Fault(
            "wrong-length",
            f"is {replans[trial]}; a trial has no fewer than 0 replans",
            "restore its replans",
            trial=names[trial],
            column="replan_row_size",
        ),
    )
    for column, least, counts, dim in (
        ("replan_row_size", 0, replans, "replan"),
        ("plan_row_size", 0, plans, "plan"),
        ("waypoint_row_size", 1, waypoints, "waypoint"),
    ):
        wrong = int((counts < least).sum()) if column != "replan_row_size" else 0
        if wrong:
            faults.add(
                Fault(
                    "wrong-length",
                    f"is below {least} in {wrong} places",
                    "plans were lost: get the log again from its source",
                    column=column,
                )
            )
        # counts as large as the dimension itself cannot overflow
        if (counts > sizes[dim]).any() or int(counts.sum()) != sizes[dim]:
            faults.add(
                Fault(
                    "wrong-length",
                    f"does not add up to the {sizes[dim]} of dimension {dim}",
                    "replans or plans were lost: get the log again from its source",
                    column=column,
                )
            )
    if sum(faults.counts.values()) > before:
        return None
    with np.errstate(over="ignore"):
        profiles = np.maximum(plans, 1).astype(np.float64).prod(axis=1)
    if (profiles > sizes["profile"]).any() or int(cells(plans).sum()) != sizes["profile"]:
        message = f"there are {sizes['profile']} profiles, not the {profiles.sum():.0f} of all grids of plans"
        faults.add(
            Fault(
                "wrong-length", message, "costs were lost: get the log again from its source", column="cost"
            )
        )
        return None
    return PlannedRows.of(replans, plans, waypoints)


def check_replans(log: xr.Dataset, usable: set[str], places: ReplanPlaces, faults: Faults) -> None:
    """Report replans whose agent, place in time, marked plans, decision or belief is wrong."""
    rows = places.rows
    agents = log.variables["agent"].values.astype(str)
    agent = log.variables["replan_agent"].values.astype(str)
    plans = log.variables["plan_row_size"].values
    viewer = np.argmax(agent[:, None] == agents, axis=1) if agents.size else np.zeros(agent.size, np.int64)
    known = np.isin(agent, agents)

    def report(
        kind: str, column: str, wrong: Shaped[np.ndarray, "replan ..."], say: str, remedy: str = ""
    ) -> None:
        at = np.flatnonzero(wrong.any(axis=tuple(range(1, wrong.ndim))))
        values = log.variables[column].values
        places.report(
            faults, kind, column, at, lambda number: say.format(value=values[at[number]].tolist()), remedy
        )

    listed = ", ".join(map(repr, agents.tolist()))
    at = np.flatnonzero(~known)
    places.report(
        faults,
        "unknown-agent",
        "replan_agent",
        at,
        lambda number: f"agent {str(agent[at[number]])!r} is not among {listed}",
        "",
    )
    own = np.take_along_axis(plans, viewer[:, None], axis=1)[:, 0] if agents.size else np.zeros(agent.size)
    report("wrong-length", "plan_row_size", known & (own < 1), "is {value}, none of who replanned")
    row_size = np.repeat(log.variables["row_size"].values, np.diff(rows.replan))
    sample, time = log.variables["replan_sample"].values, log.variables["replan_time"].values
    inside = (sample >= 0) & (sample < row_size)
    report("replan-range", "replan_sample", ~inside, "is {value}, no sample of its trial")
    report(
        "not-finite", "replan_time", ~np.isfinite(time), "is {value}", "every replan has a time in seconds"
    )
    report(
        "replan-order",
        "replan_sample",
        _late(sample, agent, rows),
        "is {value}, which is not after the replan before",
        "replans are in the order of their samples; an agent replans once at a sample",
    )
    for column in ("static_plan", "committed_plan"):
        marked = log.variables[column].values
        report(
            "plan-range",
            column,
            (marked < -1) | (marked >= plans),
            "is {value}, no such plans",
            "-1 where there is none",
        )
    decision = log.variables["decision"].values
    wrong = (decision < -1) | (decision >= plans)
    if agents.size:
        wrong |= (np.take_along_axis(decision, viewer[:, None], axis=1) < 0) & known[:, None]
    report(
        "plan-range",
        "decision",
        wrong,
        "is {value}, no such plans",
        "who replans decides on a plan of its own",
    )
    if {"theta", "live_log_posterior"} <= usable:
        held = log.variables["live_log_posterior"].values
        report(
            "not-normalised",
            "live_log_posterior",
            ~(np.isnan(held).all(axis=1) | normalised(held)),
            "is {value}; probabilities that sum to one are expected",
            "NaN throughout where no belief was held",
        )


def normalised(log_posterior: Float[np.ndarray, "replan theta"]) -> Bool[np.ndarray, " replan"]:
    """Return whether each row holds the logarithms of probabilities that sum to one.

    Examples
    --------
    >>> normalised(np.log([[0.5, 0.5], [0.5, 0.4]])).tolist()
    [True, False]
    """
    # +inf, NaN and whatever would overflow are no logarithms of probabilities
    sound = np.asarray((log_posterior <= _NORMALISATION_TOLERANCE).all(axis=1))
    total = np.exp(np.where(sound[:, None], log_posterior, 0.0)).sum(axis=1)
    return np.asarray(sound & (np.abs(total - 1.0) < _NORMALISATION_TOLERANCE))


def _late(
    sample: Int[np.ndarray, " replan"], agent: Shaped[np.ndarray, " replan"], rows: PlannedRows
) -> Bool[np.ndarray, " replan"]:
    late: np.ndarray = np.zeros(sample.size, bool)
    trial = np.repeat(np.arange(rows.replan.size - 1), np.diff(rows.replan))
    late[1:] = (trial[1:] == trial[:-1]) & (sample[1:] < sample[:-1])
    # one agent's replans follow each other strictly
    order = np.lexsort((np.arange(sample.size), agent, trial))
    same = (trial[order][1:] == trial[order][:-1]) & (agent[order][1:] == agent[order][:-1])
    late[order[1:]] |= same & (sample[order][1:] <= sample[order][:-1])
    return late


def check_replan_times(
    time: Float[np.ndarray, " sample"],
    start: int,
    log: xr.Dataset,
    places: ReplanPlaces,
    offsets: Int[np.ndarray, " edge"],
    faults: Faults,
) -> None:
    """Report replans whose time is not that of their sample, in a block of samples that begins at ``start``."""
    begin = np.repeat(offsets[:-1], np.diff(places.rows.replan))
    # samples that leave their trial are told elsewhere; here they only must not overflow
    at = begin + np.clip(
        log.variables["replan_sample"].values, 0, np.repeat(np.diff(offsets), np.diff(places.rows.replan)) - 1
    )
    inside = np.flatnonzero((at >= start) & (at < start + time.size))
    told, there = log.variables["replan_time"].values[inside], time[at[inside] - start]
    wrong = np.flatnonzero(np.abs(told - there) > _TIME_TOLERANCE)
    places.report(
        faults,
        "replan-time",
        "replan_time",
        inside[wrong],
        lambda number: f"is {told[wrong[number]]}, but that of its sample is {there[wrong[number]]}",
        "a replan is made at a sample",
    )


def check_waypoints(
    time: Float[np.ndarray, " waypoint"],
    position: Float[np.ndarray, "waypoint space"],
    start: int,
    places: ReplanPlaces,
    faults: Faults,
) -> None:
    """Report waypoints of a block of whole plans that are not finite, or whose times do not begin at 0 and increase."""
    edges = places.rows.waypoint
    first = np.zeros(time.size, bool)
    inside = edges[np.searchsorted(edges, start) : np.searchsorted(edges, start + time.size)] - start
    first[inside] = True
    finite = np.isfinite(time)
    wrong = finite & np.where(first, time != 0.0, np.diff(time, prepend=0.0) <= 0.0)
    for kind, column, found, say, remedy in (
        ("not-finite", "waypoint_time", ~finite, "is not finite", ""),
        (
            "time-not-increasing",
            "waypoint_time",
            wrong,
            "does not begin at 0 and increase within its plan",
            "times of a plan are seconds from its replan",
        ),
        ("not-finite", "waypoint_position", ~np.isfinite(position).all(axis=1), "is not finite", ""),
    ):
        if found.any():
            at = np.flatnonzero(found) + start
            places.report(faults, kind, column, places.replan_of("waypoint", at), say, remedy)


def check_costs(
    cost: Float[np.ndarray, "profile agent"],
    contact_time: Float[np.ndarray, " profile"],
    start: int,
    plan_row_size: Int[np.ndarray, "replan agent"],
    places: ReplanPlaces,
    faults: Faults,
) -> None:
    """Report costs and times of contact below 0 or NaN, and costs of agents that have left."""
    edges = places.rows.profile
    begin, end = np.searchsorted(edges, [start, start + contact_time.size])
    there = np.repeat(plan_row_size[begin:end] > 0, np.diff(edges[begin : end + 1]), axis=0)
    sound = np.where(there, cost >= 0.0, np.isnan(cost)).all(axis=1)
    for column, found, remedy in (
        ("cost", ~sound, "inf = collision; NaN only for an agent that has left and so has no plans"),
        ("contact_time", ~(contact_time >= 0.0), "inf where agents never touch"),
    ):
        if found.any():
            at = np.flatnonzero(found)
            values = cost if column == "cost" else contact_time
            places.report(
                faults,
                "wrong-value",
                column,
                places.replan_of("profile", at + start),
                lambda number, values=values, at=at: (  # type: ignore[misc]
                    f"is {values[at[number]].tolist()}; seconds from 0 to inf are expected"
                ),
                remedy,
            )


def check_planned_trials(log: xr.Dataset, usable: set[str], names: list[str], faults: Faults) -> None:
    """Report ends, counts of stops, kinds of plan sets and descriptions of models that cannot be."""

    def report(column: str, wrong: Shaped[np.ndarray, "trial ..."], remedy: str) -> None:
        values = log.variables[column].values
        faults.add_each(
            "wrong-value",
            np.flatnonzero(wrong.any(axis=tuple(range(1, wrong.ndim)))).tolist(),
            lambda trial: Fault(
                "wrong-value", f"is {values[trial].tolist() if wrong.ndim > 1 else values[trial]!r}",
                remedy, trial=names[trial], column=column,
            ),
        )  # fmt: skip

    if "finish_time" in usable:
        end = log.variables["finish_time"].values
        report("finish_time", (end < 0.0) | np.isinf(end), "seconds, or NaN for who did not finish")
    if "stops" in usable:
        report("stops", log.variables["stops"].values < 0, "a count is at least 0")
    if "stop_episodes" in usable:
        wrong = log.variables["stop_episodes"].values < 0
        if "stops" in usable:
            wrong = wrong | (log.variables["stop_episodes"].values > log.variables["stops"].values)
        report("stop_episodes", wrong, "from 0 to the number of stops")
    if "plan_sets" in usable:
        report(
            "plan_sets",
            ~np.isin(log.variables["plan_sets"].values.astype(str), PLAN_SETS),
            "shared or independent; empty = unknown",
        )
    if "live_model" in usable:
        texts = log.variables["live_model"].values.tolist()
        sound = {text: _describes_model(text) for text in set(texts)}
        report(
            "live_model",
            np.array([not sound[text] for text in texts], bool),
            "JSON of an object with 'model' and 'parameters'; empty where no belief was held",
        )


def _describes_model(text: str) -> bool:
    if not text:
        return True
    try:
        told = json.loads(text)
    except ValueError:
        return False
    return (
        isinstance(told, dict)
        and isinstance(told.get("model"), str)
        and isinstance(told.get("parameters", {}), dict)
    )
