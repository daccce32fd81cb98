"""How a robot and a human did as a team in the reaching game: scores, collisions, changes of goal, first scores."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import xarray as xr
from jaxtyping import Float, Int, Shaped

from ppinfer.errors import LogError
from ppinfer.studies.performance import RESAMPLES, PairedPerformance

GAME_METRICS = (
    "score", "collisions", "human_goal_changes", "robot_goal_changes", "first_score_s", "scoreless",
)  # fmt: skip


@dataclass(frozen=True, eq=False)
class GamePerformance(PairedPerformance):
    """The metrics of every game of a study in which a robot and a human score as a team.

    Parameters
    ----------
    values : (trial, metric) float64
        In the order of `GAME_METRICS`: points, collisions, changes of the human's and the robot's goal, seconds until
        the first score (the game's length where there was none), and 1 for a game without a score.
    robot, human : (trial,) str
        Controllers.
    scene : (trial,) int64
        Which game: those of one number are compared with one another, and depend on one another.
    goals : (trial,) int64
        Goals at a time. Rows name them where there is more than one number of them.

    Examples
    --------
    >>> performance = GamePerformance(
    ...     np.array([[8.0, 1, 0, 0, 3, 0], [12.0, 0, 1, 2, 4, 0], [4.0, 0, 0, 0, 30, 1], [10.0, 0, 0, 2, 5, 0]]),
    ...     robot=np.array(["naive", "influence"] * 2),
    ...     human=np.array(["stubborn"] * 4),
    ...     scene=np.array([0, 0, 1, 1]),
    ...     goals=np.full(4, 3),
    ... )
    >>> [(row["robot"], row["score"], row["score_sem"]) for row in performance.pooled()]
    [('naive', 6.0, 2.0), ('influence', 11.0, 1.0)]
    >>> performance.differences(["naive"])[0]["mean"]
    5.0
    """

    metrics = GAME_METRICS
    apart = "goals"
    scenes_are = "games"

    values: Float[np.ndarray, "trial metric"]
    robot: Shaped[np.ndarray, " trial"]
    human: Shaped[np.ndarray, " trial"]
    scene: Int[np.ndarray, " trial"]
    goals: Int[np.ndarray, " trial"]

    def differences(
        self,
        against: Sequence[str] | None = None,
        *,
        resamples: int = RESAMPLES,
        seed: int = 0,
        level: float = 0.95,
    ) -> list[dict[str, Any]]:
        """Return paired differences between robots with bootstrap intervals over games; see `PairedPerformance`."""
        told = super().differences(against, resamples=resamples, seed=seed, level=level)
        return [self._without_one_number(row) for row in told]

    def _rows(self, by: tuple[str, ...]) -> list[dict[str, Any]]:
        return [self._without_one_number(row) for row in super()._rows(by)]

    def _count(self, trials: int) -> dict[str, Any]:
        return {}

    def _without_one_number(self, row: dict[str, Any]) -> dict[str, Any]:
        if len(np.unique(self.goals)) > 1:
            return row
        return {key: value for key, value in row.items() if key != "goals"}


def game_performance(log: xr.Dataset, *, robot: str = "robot", human: str = "human") -> GamePerformance:
    """Return the metrics of every game of a log.

    Parameters
    ----------
    log : xarray.Dataset
        A study log of the reaching game, as ``ppsim reach`` writes it.
    robot, human : str
        Which agents these are.

    Raises
    ------
    LogError
        If the log lacks a variable or an agent that this needs, naming it.

    Examples
    --------
    >>> from ppsim.reaching import GameStudy
    >>> from ppsim.study import log_of_study
    >>> study = GameStudy(games=2, robots=("naive",), humans=("moving",), duration=5.0)
    >>> game_performance(log_of_study(study, range(study.trials))).values.shape
    (2, 6)
    """
    needed = ("team_score", *GAME_METRICS[1:-1], "controller")
    missing = [name for name in needed if name not in log.variables]
    if missing:
        raise LogError(
            f"performance in the reaching game needs {', '.join(needed)}; the log has no {', '.join(missing)} "
            "('ppsim reach' logs them)"
        )
    agents = log["agent"].values.astype(str).tolist()
    absent = [agent for agent in (robot, human) if agent not in agents]
    if absent:
        raise LogError(f"there is no agent {absent[0]!r} in the log; there are {', '.join(agents)}")
    row_size = log["row_size"].values
    ends = np.cumsum(row_size) - 1
    time = log["time"].values
    length = time[ends] - time[ends - row_size + 1]
    first = log["first_score_s"].values
    scoreless = np.isnan(first)
    columns = [log[name].values for name in needed[:4]]
    trials = log.sizes["trial"]
    controller = log["controller"].values.astype(str)
    return GamePerformance(
        np.column_stack([*columns, np.where(scoreless, length, first), scoreless]).astype(np.float64),
        robot=controller[:, agents.index(robot)],
        human=controller[:, agents.index(human)],
        scene=log["scene"].values.astype(np.int64) if "scene" in log else np.arange(trials),
        goals=log["goal_count"].values.astype(np.int64)
        if "goal_count" in log
        else np.full(trials, log.sizes["goal"]),
    )
