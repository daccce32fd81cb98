"""Writing a report: which page a file needs."""

from __future__ import annotations

import os
from collections.abc import Callable, Sequence
from pathlib import Path

from ppinfer.errors import LogError
from ppinfer.report.folder import refuse_foreign_folder
from ppinfer.report.goal_page import write_goal_page
from ppinfer.report.interaction_page import is_interaction_log, write_interaction_page
from ppinfer.report.play_page import is_play_log, write_play_page
from ppinfer.report.theta_page import is_theta_posterior, write_theta_page
from ppinfer.report.written import WrittenReport
from ppinfer.studies.scores import DEFAULT_SHARES
from ppinfer.studies.segment_selection import SegmentOptions

__all__ = ["WrittenReport", "write_report"]


def write_report(
    path: str | os.PathLike[str],
    directory: str | os.PathLike[str],
    *,
    trials: Sequence[str] | None = None,
    at: Sequence[float] = DEFAULT_SHARES,
    min_samples: int | None = None,
    min_distance: float | None = None,
    participants: Sequence[str] | None = None,
    exclude: Sequence[str] | None = None,
    progress: Callable[[int, int], None] | None = None,
) -> WrittenReport:
    """Write one self-contained page about a posterior or a log, and its figures as files.

    Parameters
    ----------
    path
        A posterior, over goals or over theta; the log of a study in which a robot and a human each had a task (it says
        when both had finished, who controlled them and how often they were stopped); or a log of two agents among
        goals in the plane.
    directory
        The folder of the report. A new one appears whole; in an existing one only an earlier report is
        replaced.
    trials
        Names of the trials to show. By default, of goals: a typical, the best and the worst scored one; of theta:
        those in which the belief came to either side most, in which it changed most, and with most safety stops; of a
        log with goals: those in which the robot makes the most of a difference.
    at, min_samples, min_distance
        Which segments are scored and after which shares of them, as in
        `ppinfer.studies.scores.score_posterior`; for goals only.
    participants, exclude
        Only these, and all but these.
    progress
        Called after every figure with how many are drawn and how many there are.

    Returns
    -------
    WrittenReport
        Where the page and figures are, and the numbers on it.

    Raises
    ------
    LogError
        If the file cannot be read, a trial or participant is unknown, segments are chosen in a file that has none,
        or the folder is a file or holds another page. Nothing is written then.

    Examples
    --------
    >>> from ppinfer.goals import GoalLQR
    >>> from ppinfer.studies import infer_log, write_posterior
    >>> from ppinfer.testing import example_log
    >>> write_posterior(infer_log(example_log(), GoalLQR()), "post.nc")
    >>> write_report("post.nc", "report").page.name
    'index.html'
    """
    source, target = Path(path), Path(directory)
    refuse_foreign_folder(target)
    for told, write in ((is_play_log, write_play_page), (is_theta_posterior, write_theta_page)):
        if told(source):
            _refuse_segments(source, at=at, min_samples=min_samples, min_distance=min_distance)
            return write(
                source, target, trials=trials, participants=participants, exclude=exclude, progress=progress
            )
    selection: SegmentOptions = {
        "min_samples": min_samples,
        "min_distance": min_distance,
        "participants": participants,
        "exclude": exclude,
    }
    write_with_goals = write_interaction_page if is_interaction_log(source) else write_goal_page
    return write_with_goals(source, target, trials=trials, at=at, selection=selection, progress=progress)


def _refuse_segments(
    source: Path, *, at: Sequence[float], min_samples: int | None, min_distance: float | None
) -> None:
    given = [
        name
        for name, is_given in (
            ("at", tuple(at) != tuple(DEFAULT_SHARES)),
            ("min_samples", min_samples is not None),
            ("min_distance", min_distance is not None),
        )
        if is_given
    ]
    if given:
        raise LogError(
            f"{source}: {', '.join(given)} choose{'s' * (len(given) == 1)} segments with a goal, of which this file "
            "has none; leave it out"
        )
