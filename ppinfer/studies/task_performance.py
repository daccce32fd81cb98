"""How well a robot and a human did their tasks side by side: times, safety stops, and what differs between robots."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import xarray as xr
from jaxtyping import Float, Int, Shaped

from ppinfer.errors import LogError
from ppinfer.studies.resampling import cluster_sums, mean_and_cluster_se, resampled_sums

METRICS = ("total_s", "robot_s", "human_s", "stops", "stop_episodes", "failures")
RESAMPLES = 10_000


@dataclass(frozen=True, eq=False)
class TaskPerformance:
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

    values: Float[np.ndarray, "trial metric"]
    robot: Shaped[np.ndarray, " trial"]
    human: Shaped[np.ndarray, " trial"]
    plan_sets: Shaped[np.ndarray, " trial"]
    scene: Int[np.ndarray, " trial"]

    def pooled(self) -> list[dict[str, Any]]:
        """Return mean and standard error of every metric, for each robot and plan sets, over all humans."""
        return self._rows(("robot", "plan_sets"))

    def cells(self) -> list[dict[str, Any]]:
        """Return the same for each human apart."""
        return self._rows(("robot", "human", "plan_sets"))

    def differences(
        self,
        against: Sequence[str] | None = None,
        *,
        resamples: int = RESAMPLES,
        seed: int = 0,
        level: float = 0.95,
    ) -> list[dict[str, Any]]:
        """Return paired differences between robots with bootstrap intervals.

        Each trial is paired with the other robot's of the same scene, human and plan sets; scenes are drawn with
        replacement, and with each all its trials.

        Parameters
        ----------
        against : sequence of str, optional
            Robots to compare the others with; by default all.
        resamples, seed : int
            Of the bootstrap.
        level : float
            Probability of the (percentile) interval.

        Returns
        -------
        list of dict
            robot, against, plan_sets, metric, mean, low, high, pairs.

        Raises
        ------
        LogError
            If a robot met the same human in the same scene more than once.
        """
        told = []
        for plan_sets in _distinct(self.plan_sets):
            robots = _distinct(self.robot[self.plan_sets == plan_sets])
            for robot in robots:
                for other in robots if against is None else against:
                    if other in robots and other != robot:
                        told += self._difference(robot, other, plan_sets, resamples, seed, level)
        return told

    def _rows(self, by: tuple[str, ...]) -> list[dict[str, Any]]:
        keys = list(zip(*(getattr(self, name).tolist() for name in by), strict=True))
        told = []
        for key in dict.fromkeys(keys):
            here = np.array([one == key for one in keys])
            scenes, cluster = np.unique(self.scene[here], return_inverse=True)
            row: dict[str, Any] = {**dict(zip(by, key, strict=True)), "trials": int(here.sum())}
            for metric, values in zip(METRICS, self.values[here].T, strict=True):
                mean, sem = mean_and_cluster_se(values, cluster, len(scenes))
                row[metric], row[f"{metric}_sem"] = mean, sem
            told.append(row)
        return told

    def _difference(
        self, robot: str, other: str, plan_sets: str, resamples: int, seed: int, level: float
    ) -> list[dict[str, Any]]:
        pairs = self._pairs(robot, other, plan_sets)
        if not len(pairs):
            return []
        difference = (self.values[pairs[:, 0]] - self.values[pairs[:, 1]]).T
        scenes, cluster = np.unique(self.scene[pairs[:, 0]], return_inverse=True)
        sums = cluster_sums(np.vstack([difference, np.ones(len(pairs))]), cluster, len(scenes))
        # the same scenes are drawn for every comparison
        draws = resampled_sums(sums, resamples=resamples, rng=np.random.default_rng(seed))
        means = draws[:, :-1] / draws[:, -1:]
        tail = (1.0 - level) / 2.0
        low, high = np.quantile(means, [tail, 1.0 - tail], axis=0)
        return [
            {
                "robot": robot,
                "against": other,
                "plan_sets": plan_sets,
                "metric": metric,
                "mean": float(difference[at].mean()),
                # one scene says nothing of how scenes differ
                "low": float(low[at]) if len(scenes) > 1 else float("nan"),
                "high": float(high[at]) if len(scenes) > 1 else float("nan"),
                "pairs": len(pairs),
            }
            for at, metric in enumerate(METRICS)
        ]

    def _pairs(self, robot: str, other: str, plan_sets: str) -> Int[np.ndarray, "pair 2"]:
        def trials_of(name: str) -> dict[tuple[int, str], int]:
            chosen = np.flatnonzero((self.robot == name) & (self.plan_sets == plan_sets))
            found = {(int(self.scene[at]), str(self.human[at])): int(at) for at in chosen}
            if len(found) < len(chosen):
                raise LogError(
                    f"robot {name!r} met the same human in the same scene more than once ({plan_sets} plan sets), so "
                    "that trials cannot be paired; number the scenes of joined studies apart"
                )
            return found

        mine, theirs = trials_of(robot), trials_of(other)
        both = [(mine[key], theirs[key]) for key in mine if key in theirs]
        return np.array(both, np.int64).reshape(-1, 2)


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


def _distinct(values: Shaped[np.ndarray, " trial"]) -> list[str]:
    return list(dict.fromkeys(values.tolist()))
