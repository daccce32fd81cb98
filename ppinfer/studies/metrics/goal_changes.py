"""How often an agent changed its mind: another goal while the goals stayed where they were."""

from __future__ import annotations

import numpy as np
from jaxtyping import Bool, Float, Int, Shaped

from ppinfer.studies.metrics.context import TrialContext
from ppinfer.studies.metrics.metric import metric_of_each_role
from ppinfer.studies.metrics.roles import Role


def goal_changes(trials: TrialContext, role: Role) -> Float[np.ndarray, " trial"]:
    """Return how often an agent changed its goal, as logged, or counted where its goal is logged at each sample.

    1. A sample without a goal (-1) is a wait, and a wait is no goal: who waits and goes on has not changed.
    2. A change counts unless goals moved, came or went since the last sample with a goal.
    """
    if trials.has(f"{{{role}}}_goal_changes"):
        return trials.values(f"{{{role}}}_goal_changes").astype(np.float64)
    if trials.has("pursued"):
        goal = trials.values("pursued")[:, trials.agent(role)]
    else:
        goal = trials.values(f"{{{role}}}_goal_index")
    going = goal >= 0
    draw = np.cumsum(_goals_moved(trials))[going]
    changed = np.zeros(goal.shape, bool)
    # draws are counted through all trials, and each trial is a draw of its own
    changed[going] = np.concatenate([[False], (np.diff(goal[going]) != 0) & (np.diff(draw) == 0)])[
        : np.count_nonzero(going)
    ]
    return trials.total(changed).astype(np.float64)


def _goals_moved(trials: TrialContext) -> Bool[np.ndarray, " sample"]:
    moved = trials.is_first.copy()
    for name in ("goal_position", "goal_present"):
        if trials.has(name) and trials.log[name].dims[0] == "sample":
            moved[1:] |= _differs(trials.values(name))
    return moved


def _differs(values: Shaped[np.ndarray, "sample ..."]) -> Bool[np.ndarray, " step"]:
    later, earlier = values[1:], values[:-1]
    # NaN stands for an absent goal, and is the same as itself
    same = (later == earlier) | ((later != later) & (earlier != earlier))
    axes: Int[np.ndarray, " axis"] = np.arange(1, values.ndim)
    return ~np.asarray(same.all(axis=tuple(axes.tolist())))


GOAL_CHANGES = metric_of_each_role(
    "{role}_goal_changes",
    "",
    "how often the {role} changed its goal while the goals stayed",
    goal_changes,
    needs=("{{role}}_goal_changes or pursued or {{role}}_goal_index",),
    reads=("goal_position", "goal_present"),
)
