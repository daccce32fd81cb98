"""How well robots did with humans in paired trials: means, standard errors, and what differs between robots."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, ClassVar

import numpy as np
from jaxtyping import Float, Int, Shaped

from ppinfer.errors import LogError
from ppinfer.studies.resampling import cluster_sums, mean_and_cluster_se, resampled_sums

RESAMPLES = 10_000


class PairedPerformance:
    """Some metrics of every trial of a study in which robots met the same humans in the same scenes.

    Subclasses are dataclasses with the fields below. They name their metrics (`metrics`), and what is held apart
    besides robots and humans (`apart`, a field of theirs with one value a trial).

    Attributes
    ----------
    values : (trial, metric) float64
        In the order of `metrics`.
    robot, human : (trial,) str
        Controllers.
    scene : (trial,) int64
        Trials of one scene are compared with one another, and depend on one another.
    """

    metrics: ClassVar[tuple[str, ...]]
    apart: ClassVar[str]
    scenes_are: ClassVar[str] = "scenes"

    values: Float[np.ndarray, "trial metric"]
    robot: Shaped[np.ndarray, " trial"]
    human: Shaped[np.ndarray, " trial"]
    scene: Int[np.ndarray, " trial"]

    def pooled(self) -> list[dict[str, Any]]:
        """Return mean and standard error of every metric for each robot, over all humans."""
        return self._rows(("robot", self.apart))

    def cells(self) -> list[dict[str, Any]]:
        """Return the same for each human apart."""
        return self._rows(("robot", "human", self.apart))

    def differences(
        self,
        against: Sequence[str] | None = None,
        *,
        resamples: int = RESAMPLES,
        seed: int = 0,
        level: float = 0.95,
    ) -> list[dict[str, Any]]:
        """Return paired differences between robots with bootstrap intervals.

        Each trial is paired with the other robot's of the same scene, human and what is held apart; scenes are drawn
        with replacement, and with each all its trials.

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
            robot, against, what is held apart, metric, mean, low, high, pairs.

        Raises
        ------
        LogError
            If a robot met the same human in the same scene more than once.
        """
        told = []
        groups = self._groups()
        for group in _distinct(groups):
            robots = _distinct(self.robot[groups == group])
            for robot in robots:
                for other in robots if against is None else against:
                    if other in robots and other != robot:
                        told += self._difference(robot, other, group, resamples, seed, level)
        return told

    def _groups(self) -> Shaped[np.ndarray, " trial"]:
        groups: np.ndarray = getattr(self, self.apart)
        return groups

    def _count(self, trials: int) -> dict[str, Any]:
        """Return how a row says how many trials it is made of."""
        return {"trials": trials}

    def _rows(self, by: tuple[str, ...]) -> list[dict[str, Any]]:
        keys = list(zip(*(getattr(self, name).tolist() for name in by), strict=True))
        told = []
        for key in dict.fromkeys(keys):
            here = np.array([one == key for one in keys])
            scenes, cluster = np.unique(self.scene[here], return_inverse=True)
            row: dict[str, Any] = {**dict(zip(by, key, strict=True)), **self._count(int(here.sum()))}
            for metric, values in zip(self.metrics, self.values[here].T, strict=True):
                mean, sem = mean_and_cluster_se(values, cluster, len(scenes))
                row[metric], row[f"{metric}_sem"] = mean, sem
            told.append(row)
        return told

    def _difference(
        self, robot: str, other: str, group: object, resamples: int, seed: int, level: float
    ) -> list[dict[str, Any]]:
        pairs = self._pairs(robot, other, group)
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
                self.apart: group,
                "metric": metric,
                "mean": float(difference[at].mean()),
                # one scene says nothing of how scenes differ
                "low": float(low[at]) if len(scenes) > 1 else float("nan"),
                "high": float(high[at]) if len(scenes) > 1 else float("nan"),
                "pairs": len(pairs),
            }
            for at, metric in enumerate(self.metrics)
        ]

    def _pairs(self, robot: str, other: str, group: object) -> Int[np.ndarray, "pair 2"]:
        def trials_of(name: str) -> dict[tuple[int, str], int]:
            chosen = np.flatnonzero((self.robot == name) & (self._groups() == group))
            found = {(int(self.scene[at]), str(self.human[at])): int(at) for at in chosen}
            if len(found) < len(chosen):
                raise LogError(
                    f"robot {name!r} met the same human in the same scene more than once ({group} "
                    f"{self.apart.replace('_', ' ')}), so that trials cannot be paired; number the "
                    f"{self.scenes_are} of joined studies apart"
                )
            return found

        mine, theirs = trials_of(robot), trials_of(other)
        both = [(mine[key], theirs[key]) for key in mine if key in theirs]
        return np.array(both, np.int64).reshape(-1, 2)


def _distinct(values: Shaped[np.ndarray, " trial"]) -> list[Any]:
    return list(dict.fromkeys(values.tolist()))
