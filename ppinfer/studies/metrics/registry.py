"""Every metric that ppinfer knows. A new one is a small file with a `Metric`, and a line here."""

from __future__ import annotations

from ppinfer.studies.metrics import fluency, game, goal_changes, motion, pace, tasks
from ppinfer.studies.metrics.metric import Metric

METRICS: dict[str, Metric] = {
    metric.name: metric
    for metric in (
        pace.DURATION,
        *tasks.TASK_TIMES,
        tasks.STOPS,
        tasks.STOP_EPISODES,
        tasks.FAILURES,
        game.SCORE,
        game.COLLISIONS,
        game.FIRST_SCORE,
        game.SCORELESS,
        *goal_changes.GOAL_CHANGES,
        *pace.PICKS_PER_MINUTE,
        *pace.SEGMENTS_PER_MINUTE,
        *motion.PATH_LENGTH,
        *motion.MEAN_SPEED,
        *motion.HAND_PATH,
        *fluency.IDLE_SHARE,
        *fluency.ACTIVE_SHARE,
        *fluency.UNSEEN_SHARE,
        fluency.CONCURRENT_SHARE,
        fluency.FUNCTIONAL_DELAY,
    )
}


def metrics_table() -> str:
    """Return the metrics as Markdown; ``docs/metrics.md`` holds exactly this.

    Examples
    --------
    >>> print(metrics_table().splitlines()[2])
    | `duration_s` | s | from the trial's first sample to its last | `time` |
    """
    rows = ["| metric | units | meaning | made of |", "| --- | --- | --- | --- |"]
    for metric in METRICS.values():
        needs = ", ".join(
            " or ".join(f"`{_shown(name)}`" for name in need.split(" or "))
            for need in metric.needs or ("time",)
        )
        units = metric.units.replace("{position}", "position")
        rows.append(f"| `{metric.name}` | {units} | {metric.meaning} | {needs} |")
    return "\n".join(rows)


def _shown(name: str) -> str:
    return name.replace("{robot}", "robot").replace("{human}", "human")
