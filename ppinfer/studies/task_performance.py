"""How well a robot and a human did their tasks side by side: times, safety stops, and what differs between robots."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import xarray as xr
from jaxtyping import Float, Int, Shaped

from ppinfer.errors import LogError
from ppinfer.studies.performance import PairedPerformance

METRICS = ("total_s", "robot_s", "human_s", "stops", "stop_episodes", "failures")


@dataclass(frozen=True, eq=False)
class TaskPerformance(PairedPerformance):
    """The metrics of every trial of a study in which a robot and a human each have a task.

    Parameters
    ----------
    values : (trial, metric) float64
        In the order of `METRICS`: seconds until both, the robot and the human had finished (the trial's length for
        whoever did not), safety stops, episodes of stops, and 1 for a trial that somebody did not finish.
    robot, human, plan_sets : (trial,) str
        Controllers and which plans they shared.
    scene : (trial,) int64
        Trials of one scene are compared with one another, and depend on one another.

    Examples
    --------
    >>> performance = TaskPerformance(
    ...     np.array([[9.0, 9, 7, 0, 0, 0], [8.0, 8, 7, 1, 1, 0], [6.0, 6, 5, 0, 0, 0], [5.0, 5, 5, 0, 0, 0]]),
    ...     robot=np.array(["norm", "bayes"] * 2),
    ...     human=np.array(["selfish"] * 4),
    ...     plan_sets=np.array(["shared"] * 4),
    ...     scene=np.array([0, 0, 1, 1]),
    ... )
    >>> [(row["robot"], row["total_s"], row["total_s_sem"]) for row in performance.pooled()]
    [('norm', 7.5, 1.5), ('bayes', 6.5, 1.5)]
    >>> performance.differences()[0]["mean"]
    1.0
    """

    metrics = METRICS
    apart = "plan_sets"

    values: Float[np.ndarray, "trial metric"]
    robot: Shaped[np.ndarray, " trial"]
    human: Shaped[np.ndarray, " trial"]
    plan_sets: Shaped[np.ndarray, " trial"]
    scene: Int[np.ndarray, " trial"]


def task_performance(log: xr.Dataset, *, robot: str = "robot", human: str = "human") -> TaskPerformance:
    """Return the metrics of every trial of a log.

    Parameters
    ----------
    log : xarray.Dataset
        A study log that says when agents finished (``finish_time``) and who controlled them.
    robot, human : str
        Which agents these are.

    Raises
    ------
    LogError
        If the log lacks a variable or an agent that this needs, naming all of them.

    Examples
    --------
    >>> from ppinfer.testing import example_planned_log
    >>> task_performance(example_planned_log(trials=2)).values.shape
    (2, 6)
    """
    needed = ("finish_time", "stops", "stop_episodes", "controller")
    missing = [name for name in needed if name not in log.variables]
    agents = [str(agent) for agent in log["agent"].values]
    if missing:
        raise LogError(
            f"task performance needs {', '.join(needed)}; the log has no {', '.join(missing)} ('ppsim study' logs them)"
        )
    absent = [agent for agent in (robot, human) if agent not in agents]
    if absent:
        raise LogError(f"there is no agent {absent[0]!r} in the log; there are {', '.join(agents)}")
    who = [agents.index(robot), agents.index(human)]
    row_size = log["row_size"].values
    ends = np.cumsum(row_size) - 1
    length = log["time"].values[ends] - log["time"].values[ends - row_size + 1]
    finish = log["finish_time"].values[:, who]
    failed = np.isnan(finish)
    finish = np.where(failed, length[:, None], finish)
    values = np.column_stack(
        [
            finish.max(axis=1),
            finish,
            log["stops"].values.astype(np.float64),
            log["stop_episodes"].values.astype(np.float64),
            failed.any(axis=1).astype(np.float64),
        ]
    )
    trials = log.sizes["trial"]
    controller = log["controller"].values.astype(str)
    return TaskPerformance(
        values,
        robot=controller[:, who[0]],
        human=controller[:, who[1]],
        plan_sets=log["plan_sets"].values.astype(str) if "plan_sets" in log else np.full(trials, "shared"),
        scene=log["scene"].values.astype(np.int64) if "scene" in log else np.arange(trials),
    )
