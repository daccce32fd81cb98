"""Is this a study log at all? Its variables, dimensions and types, its trials and segments."""

from __future__ import annotations

import numpy as np
import xarray as xr
from jaxtyping import Bool, Int

from ppinfer.studies.checksums import type_name
from ppinfer.studies.faults import Fault, Faults
from ppinfer.studies.schema import CONTROL_QUANTITIES, FORMAT, FORMAT_VERSION, GROUPS, VARIABLES, VariableSpec


def check_structure(log: xr.Dataset, faults: Faults) -> set[str]:
    """Report missing variables, wrong dimensions and wrong types; return the usable names."""
    if log.attrs.get("ppinfer_format") != FORMAT:
        found = log.attrs.get("ppinfer_format")
        faults.add(
            Fault(
                "format",
                f"attribute ppinfer_format is {found!r}, expected {FORMAT!r}",
                "write it with ppinfer",
            )
        )
    version = log.attrs.get("ppinfer_format_version")
    if not isinstance(version, int | np.integer) or version != FORMAT_VERSION:
        faults.add(
            Fault(
                "format",
                f"attribute ppinfer_format_version is {version!r}, this ppinfer reads {FORMAT_VERSION}",
                "use the ppinfer that wrote it, or convert the study again",
            )
        )
    present = set(map(str, log.variables))
    for spec in VARIABLES.values():
        if spec.required and spec.name not in present:
            faults.add(_missing(spec, "it is required"))
    for group in GROUPS:
        if any(name in present for name in group):
            for name in group:
                if name not in present:
                    others = ", ".join(other for other in group if other in present)
                    faults.add(_missing(VARIABLES[name], f"it belongs with {others}"))
    usable = set()
    for name in sorted(present):
        if _is_well_formed(name, log.variables[name], faults):
            usable.add(name)
    if {"goal_position", "goal_present"} <= usable and log["goal_position"].dims[0] != log[
        "goal_present"
    ].dims[0]:
        message = f"is on {log['goal_present'].dims}, goal_position on {log['goal_position'].dims}"
        faults.add(
            Fault(
                "wrong-dimensions", message, "give both per trial or both per sample", column="goal_present"
            )
        )
        usable -= {"goal_position", "goal_present"}
    if "control" in usable and log["control"].attrs.get("quantity") not in CONTROL_QUANTITIES:
        found = log["control"].attrs.get("quantity")
        message = f"its attribute quantity is {found!r}; expected one of {', '.join(CONTROL_QUANTITIES)}"
        faults.add(Fault("control-quantity", message, "say what the control is", column="control"))
    for name in ("agent", "space", "goal", "theta", "table", "trial_id"):
        if name in usable:
            _check_unique(name, log[name].values, faults)
    return usable


def _missing(spec: VariableSpec, why: str) -> Fault:
    dims = " or ".join(f"({', '.join(dims)})" for dims in spec.dims)
    return Fault(
        "missing-variable", f"there is none; {why}", f"add {spec.name}{dims}, {spec.kind}", column=spec.name
    )


def _is_well_formed(name: str, variable: xr.Variable, faults: Faults) -> bool:
    spec = VARIABLES.get(name)
    if spec is not None and tuple(map(str, variable.dims)) not in spec.dims:
        expected = " or ".join(f"({', '.join(dims)})" for dims in spec.dims)
        faults.add(Fault("wrong-dimensions", f"is on {variable.dims}, expected {expected}", column=name))
        return False
    kind = type_name(variable.dtype)
    if kind == "str":
        wrong = [item for item in variable.values.ravel().tolist() if not isinstance(item, str)]
        if wrong:
            kind = f"object (e.g. {type(wrong[0]).__name__})"
    if spec is not None:
        expected = "str" if spec.kind == "str" else np.dtype(spec.kind).newbyteorder("<").str
        if kind != expected:
            found = kind if kind.startswith(("str", "object")) else variable.dtype.name
            faults.add(Fault("wrong-type", f"holds {found}, expected {spec.kind}", "convert it", column=name))
            return False
    elif kind != "str" and variable.dtype.kind not in "biuf":
        faults.add(
            Fault("wrong-type", f"holds {kind}", "a study's own variables are numbers or text", column=name)
        )
        return False
    return True


def _check_unique(name: str, labels: np.ndarray, faults: Faults) -> None:
    if labels.size == 0 and name in ("agent", "space", "theta", "trial_id"):
        faults.add(Fault("empty", "there is none", "a log has at least one", column=name))
    _, first, counts = np.unique(labels.astype(str), return_index=True, return_counts=True)
    repeated = np.sort(first[counts > 1])
    kind = "duplicate-trial" if name == "trial_id" else "duplicate-label"
    faults.add_each(
        kind,
        repeated.tolist(),
        lambda index: Fault(
            kind,
            f"{labels[index]!r} occurs {int((labels == labels[index]).sum())} times",
            "names are unique: rename or remove the copies",
            trial=str(labels[index]) if name == "trial_id" else None,
            column=name,
        ),
    )


def check_row_sizes(log: xr.Dataset, faults: Faults) -> bool:
    """Report trials and samples that do not add up; return whether samples can be cut into trials."""
    row_size = log["row_size"].values
    names = trial_names(log)
    empty = np.flatnonzero(row_size < 1)
    faults.add_each(
        "wrong-length",
        empty.tolist(),
        lambda trial: Fault(
            "wrong-length",
            f"is {row_size[trial]}; a trial has at least one sample",
            "remove the trial or restore its samples",
            trial=names[trial],
            column="row_size",
        ),
    )
    total = int(row_size.sum())
    if total != log.sizes.get("sample", 0):
        faults.add(
            Fault(
                "wrong-length",
                f"adds up to {total}, but there are {log.sizes.get('sample', 0)} samples",
                "samples or trials were lost: get the log again from its source",
                column="row_size",
            )
        )
    return empty.size == 0 and total == log.sizes.get("sample", 0)


def trial_names(log: xr.Dataset) -> list[str]:
    """Return the trials' ids, or their numbers where ids are missing."""
    if "trial_id" in log and log["trial_id"].ndim == 1:
        return [str(name) for name in log["trial_id"].values.tolist()]
    return [f"#{index}" for index in range(log.sizes.get("trial", 0))]


def check_segments(log: xr.Dataset, faults: Faults) -> Bool[np.ndarray, " segment"]:
    """Report segments that do not fit their trial, the agents or the goals; return the sound ones."""
    trial, start, stop = (log[f"segment_{name}"].values for name in ("trial", "start", "stop"))
    agent, goal = log["segment_agent"].values.astype(str), log["true_goal"].values.astype(str)
    names, row_size = trial_names(log), log["row_size"].values
    known_trial = (trial >= 0) & (trial < row_size.size)

    def report(
        kind: str, column: str, wrong: Bool[np.ndarray, " segment"], say: str, remedy: str, known: str = ""
    ) -> None:
        def describe(index: int) -> Fault:
            # labels are filled in, never part of the pattern: one may hold a brace
            told = say.format(
                trial=trial[index],
                agent=str(agent[index]),
                goal=str(goal[index]),
                start=start[index],
                stop=stop[index],
                known=known,
            )
            where = names[trial[index]] if known_trial[index] else None
            sample = int(start[index]) if known_trial[index] else None
            return Fault(kind, f"segment {index}: {told}", remedy, trial=where, sample=sample, column=column)

        faults.add_each(kind, np.flatnonzero(wrong).tolist(), describe)

    report(
        "segment-trial",
        "segment_trial",
        ~known_trial,
        f"is of trial {{trial}}, but there are {row_size.size} trials",
        "",
    )
    agents = log["agent"].values.astype(str)
    listed = ", ".join(map(repr, agents.tolist()))
    known_agent = np.isin(agent, agents)
    report("unknown-agent", "segment_agent", ~known_agent, "agent {agent!r} is not among {known}", "", listed)
    goals = log["goal"].values.astype(str) if "goal" in log.variables else np.array([], str)
    listed = ", ".join(map(repr, goals.tolist())) or "no goals"
    report(
        "unknown-goal",
        "true_goal",
        (goal != "") & ~np.isin(goal, goals),
        "goal {goal!r} is not among {known}",
        "correct the label, or leave it empty where it is not known",
        listed,
    )
    length = np.zeros(trial.size, np.int64)
    length[known_trial] = row_size[trial[known_trial]]
    inside = known_trial & (start >= 0) & (start < stop) & (stop <= length)
    report(
        "segment-range",
        "segment_start",
        known_trial & ~inside,
        "[{start}, {stop}) is empty or leaves its trial",
        "segments are half-open and lie within their trial",
    )
    order = np.lexsort((start, agent, trial))
    same = (trial[order][1:] == trial[order][:-1]) & (agent[order][1:] == agent[order][:-1])
    overlapping = np.zeros(trial.size, bool)
    overlapping[order[1:]] = (
        same & (start[order][1:] < stop[order][:-1]) & inside[order][1:] & inside[order][:-1]
    )
    report(
        "segment-overlap",
        "segment_start",
        overlapping,
        "[{start}, {stop}) of {agent!r} begins before the one before it ends",
        "an agent heads for one goal at a time: separate them",
    )
    return inside & known_agent


def sample_offsets(row_size: Int[np.ndarray, " trial"]) -> Int[np.ndarray, " edge"]:
    """Return where each trial's samples begin, and where the last one's end."""
    return np.concatenate([[0], np.cumsum(row_size)])
