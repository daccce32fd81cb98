"""One trial of two arms as a study log holds it, in memory and ready to be drawn."""

from __future__ import annotations

import json
from dataclasses import dataclass
from typing import Any

import numpy as np
import xarray as xr
from jaxtyping import Bool, Float, Int

from ppinfer.coordination.plans import PlanSet
from ppinfer.distributions import row_starts
from ppinfer.errors import LogError
from ppsim.arms.geometry import ARMS, Arm

# an object is picked up within this, m, and a plan's path is drawn in steps of so many seconds
_NEAR, _PATH_STEP = 0.0101, 0.2
_NEEDED = (
    "position", "held", "finish_time", "task_position", "replan_sample", "plan_row_size", "waypoint_row_size",
    "waypoint_time", "waypoint_position", "decision", "live_log_posterior",
)  # fmt: skip


@dataclass(frozen=True, eq=False)
class RecordedTrial:
    """What a log says of a trial.

    Attributes
    ----------
    agents
        Their names; the first is the robot.
    arms
        In the order of the agents.
    title
        Who met whom.
    time, joints, held
        The samples: seconds, joint angles (rad; NaN once an agent has left), and whether a safety stop led to them.
    task
        Where each agent picks up and puts down, m.
    finish_time
        Seconds; NaN for who did not finish.
    picked
        The sample at which each agent grasped its object; the number of samples if it never did.
    replan_sample
        The sample of each replan.
    paths
        For each replan and agent, the end effector's path along every plan, m.
    chosen
        The plan of each agent in the profile that was decided on; -1 where none was.
    theta, belief
        Whom the other agent's equilibria may favour, and p(theta) at each replan; NaN where none was held.
    """

    agents: tuple[str, ...]
    arms: tuple[Arm, ...]
    title: str
    outcome: str
    time: Float[np.ndarray, " sample"]
    joints: Float[np.ndarray, "sample agent 2"]
    held: Bool[np.ndarray, " sample"]
    task: Float[np.ndarray, "agent 2 2"]
    finish_time: Float[np.ndarray, " agent"]
    picked: Int[np.ndarray, " agent"]
    replan_sample: Int[np.ndarray, " replan"]
    paths: tuple[tuple[tuple[Float[np.ndarray, "point 2"], ...], ...], ...]
    chosen: Int[np.ndarray, "replan agent"]
    theta: tuple[str, ...]
    belief: Float[np.ndarray, "replan theta"]

    @property
    def stops(self) -> Int[np.ndarray, " sample"]:
        """How many safety stops there have been by each sample."""
        stops: np.ndarray = np.cumsum(self.held)
        return stops

    def replan_at(self, sample: int) -> int:
        """Return the replan that holds at a sample: the last one by then; -1 before the first."""
        return int(np.searchsorted(self.replan_sample, sample, side="right")) - 1

    def object_at(self, agent: int, sample: int) -> Float[np.ndarray, " 2"]:
        """Return where an agent's object is at a sample, m."""
        if sample < self.picked[agent]:
            return np.asarray(self.task[agent, 0])
        here = self.joints[sample, agent]
        if np.isnan(here).any():
            return np.asarray(self.task[agent, 1])
        return self.arms[agent].end_effector(here)


def read_recorded(log: xr.Dataset) -> RecordedTrial:
    """Read a log of one trial of two arms.

    Raises
    ------
    LogError
        If the log holds another number of trials, or is not one of two arms.
    """
    trials = log.sizes.get("trial", 0)
    missing = [name for name in _NEEDED if name not in log]
    if missing:
        raise LogError(f"this is no log of two arms: it has no {', '.join(missing)}; ppsim study records one")
    if trials != 1:
        raise LogError(
            f"expected the log of one trial; this one holds {trials} (take one with select_trials)"
        )
    agents = tuple(str(agent) for agent in log["agent"].values)
    arms = _arms_of(log, agents)
    task = log["task_position"].values[0]
    joints = log["position"].values
    controller = log["controller"].values[0] if "controller" in log else ("",) * len(agents)
    kind = f" · {log['plan_sets'].values[0]} plan sets" if "plan_sets" in log else ""
    met = " · ".join(
        f"{agent}: {name}" if name else agent for agent, name in zip(agents, controller, strict=True)
    )
    return RecordedTrial(
        agents=agents,
        arms=arms,
        title=met + kind,
        outcome=str(log["outcome"].values[0]) if "outcome" in log else "",
        time=log["time"].values,
        joints=joints,
        held=log["held"].values.astype(bool),
        task=task,
        finish_time=log["finish_time"].values[0],
        picked=np.array([_picked(arm, joints[:, at], task[at, 0]) for at, arm in enumerate(arms)]),
        replan_sample=log["replan_sample"].values,
        paths=_paths(log, arms),
        chosen=log["decision"].values,
        theta=tuple(str(name) for name in log["theta"].values) if "theta" in log.coords else (),
        belief=np.exp(log["live_log_posterior"].values),
    )


def _arms_of(log: xr.Dataset, agents: tuple[str, ...]) -> tuple[Arm, ...]:
    """Return the arms of the study's configuration; those of the study's usual table where it names none."""
    try:
        given: dict[str, Any] = json.loads(log.attrs.get("configuration", "{}")).get("arms", {})
        made = {}
        for agent, one in given.items():
            values: dict[str, Any] = {key: _as_tuple(value) for key, value in one.items()}
            made[agent] = Arm(**values)
        known = made or ARMS
        return tuple(known[agent] for agent in agents)
    except (ValueError, TypeError, AttributeError, KeyError) as error:
        raise LogError(
            f"the log's configuration does not say what the arms of {', '.join(agents)} are: {error}"
        ) from error


def _as_tuple(value: Any) -> Any:
    return tuple(value) if isinstance(value, list) else value


def _picked(arm: Arm, joints: Float[np.ndarray, "sample 2"], pick: Float[np.ndarray, " 2"]) -> int:
    """Return the first sample at which an end effector was at its pick."""
    near = np.linalg.norm(arm.end_effector(joints) - pick, axis=-1) <= _NEAR
    return int(near.argmax()) if near.any() else len(near)


def _paths(
    log: xr.Dataset, arms: tuple[Arm, ...]
) -> tuple[tuple[tuple[Float[np.ndarray, "point 2"], ...], ...], ...]:
    counts = log["plan_row_size"].values
    sizes = log["waypoint_row_size"].values
    time, position = log["waypoint_time"].values, log["waypoint_position"].values
    first = row_starts(sizes)
    found = []
    plan = 0
    for row in counts:
        of_agents = []
        for arm, count in zip(arms, row, strict=True):
            paths = []
            for one in range(plan, plan + int(count)):
                rows = slice(first[one], first[one] + sizes[one])
                plans = PlanSet("", sizes[one : one + 1], time[rows], position[rows])
                when = np.append(np.arange(0.0, plans.duration[0], _PATH_STEP), plans.duration[0])
                paths.append(arm.end_effector(plans.positions(when)[0]))
            of_agents.append(tuple(paths))
            plan += int(count)
        found.append(tuple(of_agents))
    return tuple(found)
