"""The one constructor of study logs: flat arrays in, a checked `xarray.Dataset` out."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import xarray as xr
from jaxtyping import Float, Shaped

from ppinfer.errors import LogError
from ppinfer.studies.replans import ReplanTable
from ppinfer.studies.schema import (
    CONTROL_QUANTITIES,
    COORDINATES,
    FORMAT,
    FORMAT_VERSION,
    REPLAN_VARIABLES,
    VARIABLES,
)

Attr = str | int | float
Values = Sequence[Any] | Shaped[np.ndarray, "*_"]
"""Numbers or text of any shape; what shape is wanted is said, and checked, where they are taken."""


def build_log(
    *,
    agents: Sequence[str],
    row_size: Values,
    time: Values,
    position: Values,
    trial_id: Values | None = None,
    participant: Values | None = None,
    space: Sequence[str] = ("x", "y"),
    goals: Sequence[str] = (),
    observed: Values | None = None,
    velocity: Values | None = None,
    has_velocity: Values | None = None,
    control: Values | None = None,
    has_control: Values | None = None,
    control_quantity: str = "acceleration",
    goal_position: Values | None = None,
    goal_present: Values | None = None,
    condition: Values | None = None,
    round: Values | None = None,
    seed: Values | None = None,
    outcome: Values | None = None,
    controller: Values | Mapping[str, str] | None = None,
    instruction: Values | Mapping[str, str] | None = None,
    segment_trial: Values = (),
    segment_agent: Values = (),
    segment_start: Values = (),
    segment_stop: Values = (),
    true_goal: Values = (),
    replan_row_size: Values | None = None,
    replans: ReplanTable | None = None,
    theta: Sequence[str] = (),
    variables: Mapping[str, tuple[Any, ...]] | None = None,
    position_units: str = "m",
    title: str = "",
    source: str = "",
    configuration: Mapping[str, Any] | None = None,
    attrs: Mapping[str, Attr] | None = None,
) -> xr.Dataset:
    """Assemble a study log from flat arrays, refusing those whose shapes do not fit together.

    Shapes are checked here; what the numbers say (times that increase, positions without NaN, goals that are
    there) is checked by `ppinfer.studies.validate_log`, which `ppinfer.studies.write_log` runs.

    Parameters
    ----------
    agents, space, goals
        Labels of the agents, of the coordinates and of the goals.
    row_size
        Samples of each trial; trials lie end to end along ``sample``.
    time
        Shape (sample): seconds, strictly increasing within a trial.
    position
        Shape (sample, agent, space): where each agent is, in ``position_units``; NaN where it was not seen.
    trial_id, participant
        Names; by default trials are numbered, and each trial is a participant of its own.
    observed
        Shape (sample, agent): 1 = seen, 0 = dropout; by default an agent is unseen where its whole position
        is NaN.
    velocity, has_velocity, control, has_control
        Shapes (sample, agent, space) and (agent): what was logged, in ``position_units`` a second (control:
        as the study defines it), and for which agents; by default those with any number in them.
    goal_position
        Shape (goal, space) for goals common to the study, (trial, goal, space), or (sample, goal, space).
    goal_present
        The leading dimensions of ``goal_position``; by default a goal is absent where its position is NaN.
    condition, round, seed, outcome
        One value a trial.
    control_quantity
        What the control is: ``velocity``, ``acceleration``, or ``other``. Models use a logged control only
        where it is the control of their own dynamics.
    controller, instruction
        Shape (trial, agent), or a mapping from agent to the one value of the study.
    segment_trial, segment_agent, segment_start, segment_stop, true_goal
        Stretches of one agent's motion in trial ``segment_trial``, half-open sample indices within the trial,
        and the goal that each led to (empty = unknown).
    replan_row_size, replans
        Replans of each trial, and all of them end to end: the log of a world where agents plan.
    theta
        Labels of whom an agent's equilibria favour; with them goes ``live_log_posterior``.
    variables
        Further variables by name: (dimensions, values) or (dimensions, values, attributes); among them those that
        the format knows but has no argument for (``held``, ``end_effector``, ``finish_time``, ``stops``,
        ``stop_episodes``, ``scene``, ``plan_sets``, ``live_model``). Text along ``sample`` is better coded as small
        integers with CF's ``flag_values`` and ``flag_meanings``.
    position_units, title, source, configuration, attrs
        Attributes of the log; ``configuration`` becomes JSON text.

    Returns
    -------
    xarray.Dataset
        The log; see ``docs/log-format.md``. Arrays of the right type are not copied.

    Raises
    ------
    LogError
        Naming the first array whose shape or type does not fit, and what was expected.

    Examples
    --------
    >>> log = build_log(agents=["human"], row_size=[2, 1], time=[0.0, 0.1, 0.0], goals=["cup", "pan"],
    ...                 position=np.zeros((3, 1, 2)), goal_position=np.array([[0.0, 1.0], [1.0, 0.0]]),
    ...                 segment_trial=[0], segment_agent=["human"], segment_start=[0], segment_stop=[2],
    ...                 true_goal=["cup"])
    >>> dict(log.sizes)["sample"], log.goal_position.dims
    (3, ('trial', 'goal', 'space'))
    """
    rows = _array("row_size", row_size, "int64", (None,))
    n_trials, n_samples = rows.size, int(rows.sum())
    sizes = {
        "trial": n_trials,
        "sample": n_samples,
        "agent": len(agents),
        "space": len(space),
        "goal": len(goals),
    }
    sizes["segment"] = np.size(segment_trial)
    positions = np.asarray(position, np.float64)

    values: dict[str, Any] = {
        "agent": agents,
        "space": space,
        "trial_id": [str(index) for index in range(n_trials)] if trial_id is None else trial_id,
        "row_size": rows,
        "participant": [f"participant-{index}" for index in range(n_trials)]
        if participant is None
        else participant,
        "condition": condition,
        "round": round,
        "seed": seed,
        "outcome": outcome,
        "controller": _per_agent("controller", controller, agents, n_trials),
        "instruction": _per_agent("instruction", instruction, agents, n_trials),
        "time": time,
        "position": positions,
        "observed": observed if observed is not None else ~np.isnan(positions).all(axis=-1),
        "segment_trial": segment_trial,
        "segment_agent": segment_agent,
        "segment_start": segment_start,
        "segment_stop": segment_stop,
        "true_goal": true_goal,
    }
    for name, moved, has in (("velocity", velocity, has_velocity), ("control", control, has_control)):
        if moved is None:
            if has is not None and any(has):
                raise LogError(f"has_{name} says that {name} was logged, but no {name} is given")
            continue
        values[name] = np.asarray(moved, np.float64)
        # an axis of another length is named below; here it must only not crash
        logged = ~np.isnan(values[name]).all(axis=(0, 2)) if values[name].ndim == 3 else ()
        values[f"has_{name}"] = logged if has is None else has

    goal_dims: dict[str, tuple[str, ...]] = {}
    if goals or goal_position is not None:
        if goal_position is None:
            raise LogError(f"goals {list(goals)} are named but goal_position is not given")
        where, placed = _goal_positions(np.asarray(goal_position, np.float64), sizes)
        present = ~np.isnan(placed).any(axis=-1) if goal_present is None else np.asarray(goal_present)
        if present.ndim == 1:
            present = np.broadcast_to(present, (n_trials, present.size))
        values |= {"goal": goals, "goal_position": placed, "goal_present": present}
        goal_dims = {"goal_position": (where, "goal", "space"), "goal_present": (where, "goal")}

    _add_replans(values, sizes, replan_row_size, replans, theta)
    data: dict[str, tuple[Any, ...]] = {}
    for name, value in values.items():
        if value is None:
            continue
        dims = goal_dims.get(name, VARIABLES[name].dims[0])
        data[name] = (dims, _array(name, value, VARIABLES[name].kind, tuple(sizes[dim] for dim in dims)))
    for name, (extra_dims, value, *described) in (variables or {}).items():
        data[name] = (tuple(extra_dims), _study_variable(name, tuple(extra_dims), value, sizes), *described)
    if "end_effector" in data:
        data["table"] = (("table",), _array("table", list("xyz")[: sizes["table"]], "str", (None,)))

    if control_quantity not in CONTROL_QUANTITIES:
        raise LogError(
            f"control_quantity is {control_quantity!r}; expected one of {', '.join(CONTROL_QUANTITIES)}"
        )
    log = xr.Dataset(data)
    log = log.set_coords([name for name in COORDINATES if name in log])
    _describe(log, position_units)
    if "control" in log:
        log["control"].attrs["quantity"] = control_quantity
    log.attrs = _attributes(title, source, configuration, attrs)
    return log


def _attributes(
    title: str, source: str, configuration: Mapping[str, Any] | None, attrs: Mapping[str, Attr] | None
) -> dict[str, Attr]:
    from ppinfer import __version__

    told: dict[str, Attr] = {
        "Conventions": "CF-1.11",
        "featureType": "trajectory",
        "ppinfer_format": FORMAT,
        "ppinfer_format_version": FORMAT_VERSION,
        "ppinfer_version": __version__,
        "configuration": json.dumps(dict(configuration or {}), sort_keys=True),
    }
    told |= {name: text for name, text in (("title", title), ("source", source)) if text}
    return told | dict(attrs or {})


def _describe(log: xr.Dataset, position_units: str) -> None:
    # variables themselves: wrapping each in a DataArray would take longer than all the rest
    variables = log.variables
    for name, spec in VARIABLES.items():
        if name in variables:
            variables[name].attrs["long_name"] = spec.meaning
            if spec.units:
                variables[name].attrs["units"] = spec.units
    variables["row_size"].attrs["sample_dimension"] = "sample"
    for counts, counted in (
        ("replan_row_size", "replan"),
        ("plan_row_size", "plan"),
        ("waypoint_row_size", "waypoint"),
    ):
        if counts in variables:
            variables[counts].attrs["sample_dimension"] = counted
    variables["trial_id"].attrs["cf_role"] = "trajectory_id"
    for name in ("position", "goal_position", "waypoint_position"):
        if name in variables:
            variables[name].attrs["units"] = position_units
    if "velocity" in variables:
        variables["velocity"].attrs["units"] = f"{position_units} s-1"


def _array(name: str, value: Values, kind: str, shape: tuple[int | None, ...]) -> Shaped[np.ndarray, "*_"]:
    try:
        array = _text(name, value) if kind == "str" else _number(name, value, kind)
    except (TypeError, ValueError, OverflowError) as error:
        raise LogError(f"{name}: expected {kind} values: {error}") from error
    expected = tuple("any" if size is None else size for size in shape)
    if array.ndim != len(shape) or any(
        want is not None and want != got for want, got in zip(shape, array.shape, strict=True)
    ):
        raise LogError(f"{name}: expected shape {expected}, got {array.shape}")
    return array


def _text(name: str, value: Values) -> Shaped[np.ndarray, "*_"]:
    array = np.asarray(value, dtype=object)
    wrong = [item for item in array.ravel().tolist() if not isinstance(item, str)]
    if wrong:
        raise LogError(f"{name}: expected text, got {wrong[0]!r}")
    return array


def _number(name: str, value: Values, kind: str) -> Shaped[np.ndarray, "*_"]:
    array = np.asarray(value)
    if array.size and array.dtype.kind not in "biuf":
        raise LogError(f"{name}: expected {kind} values, got values of type {array.dtype}")
    if kind != "float64" and array.dtype.kind == "f" and not np.array_equal(array, np.trunc(array)):
        raise LogError(f"{name}: expected whole numbers, got fractions")
    if (
        kind == "int64"
        and array.dtype.kind in "fu"
        and array.size
        and not (np.abs(array.astype(float)) < 2.0**63).all()
    ):
        raise LogError(f"{name}: expected whole numbers, got {array.ravel()[np.abs(array.ravel()).argmax()]}")
    if array.size and kind == "int8" and (array.min() < 0 or array.max() > 1):
        raise LogError(f"{name}: expected 0 or 1, got values from {array.min()} to {array.max()}")
    return array.astype(kind, copy=False)


def _goal_positions(
    placed: Float[np.ndarray, "*_"], sizes: Mapping[str, int]
) -> tuple[str, Float[np.ndarray, "*_"]]:
    if placed.ndim == 2:
        return "trial", np.broadcast_to(placed, (sizes["trial"], *placed.shape)).copy()
    if placed.ndim == 3:
        # with as many samples as trials the two mean the same
        return ("trial" if placed.shape[0] == sizes["trial"] else "sample"), placed
    raise LogError(
        "goal_position: expected shape (goal, space), (trial, goal, space) or (sample, goal, space), "
        f"got {placed.shape}"
    )


def _add_replans(
    values: dict[str, Any],
    sizes: dict[str, int],
    row_size: Values | None,
    replans: ReplanTable | None,
    theta: Sequence[str],
) -> None:
    if replans is None or row_size is None:
        if replans is not None or row_size is not None:
            raise LogError("replan_row_size and replans come together or not at all")
        return
    sizes |= replans.sizes | {"theta": len(theta)}
    if int(np.sum(np.asarray(row_size, np.int64))) != sizes["replan"]:
        raise LogError(
            f"replan_row_size adds up to {np.sum(row_size)}, but there are {sizes['replan']} replans"
        )
    values |= {"replan_row_size": row_size}
    values |= {name: getattr(replans, name) for name in REPLAN_VARIABLES if name != "replan_row_size"}
    if theta:
        values |= {"theta": theta, "live_log_posterior": replans.live_log_posterior}


def _per_agent(
    name: str, value: Values | Mapping[str, str] | None, agents: Sequence[str], n_trials: int
) -> object:
    if not isinstance(value, Mapping):
        return value
    unknown = sorted(set(value) - set(agents))
    if unknown:
        raise LogError(f"{name}: unknown agents {unknown}; the agents are {list(agents)}")
    return np.tile(np.array([value.get(agent, "") for agent in agents], dtype=object), (n_trials, 1))


def _study_variable(
    name: str, dims: tuple[str, ...], value: Any, sizes: dict[str, int]
) -> Shaped[np.ndarray, "*_"]:
    spec = VARIABLES.get(name)
    if spec is not None and not spec.as_variable:
        raise LogError(f"variables: {name!r} is a variable of the log's own; give it as {name}=")
    array = np.asarray(value)
    if spec is not None:
        if dims not in spec.dims:
            expected_dims = " or ".join(f"({', '.join(some)})" for some in spec.dims)
            raise LogError(f"variables: {name!r} is on {dims}; {expected_dims} is expected")
        known = _array(name, array, spec.kind, tuple(sizes.get(dim) for dim in dims))
        sizes |= {dim: size for dim, size in zip(dims, known.shape, strict=True) if dim not in sizes}
        return known
    if array.dtype.kind in "OUT":
        array = _text(name, array)
    elif array.dtype.kind == "b":
        array = array.astype(np.int8)
    elif array.dtype.kind not in "iuf":
        raise LogError(
            f"variables: {name!r} holds values of type {array.dtype}; numbers or text are expected"
        )
    expected = tuple(sizes.get(dim, size) for dim, size in zip(dims, array.shape, strict=False))
    if array.ndim != len(dims) or array.shape != expected:
        raise LogError(f"variables: {name!r} on {dims}: expected shape {expected}, got {array.shape}")
    return array
