"""Writing a report: which page a file needs."""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path

from ppinfer.report.folder import refuse_foreign_folder
from ppinfer.report.goal_page import write_goal_page
from ppinfer.report.interaction_page import is_interaction_log, write_interaction_page
from ppinfer.report.log_page import write_log_page
from ppinfer.report.options import ReportOptions, pair_of
from ppinfer.report.play_page import is_play_log, write_play_page
from ppinfer.report.source import Source, open_source
from ppinfer.report.theta_page import write_theta_page
from ppinfer.report.unsound_page import write_unsound_page
from ppinfer.report.written import PageWriter, WrittenReport
from ppinfer.studies.scores import DEFAULT_SHARES
from ppinfer.studies.storage import open_log

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
    model: str | None = None,
    parameters: Mapping[str, str] | None = None,
    robot: str | None = None,
    human: str | None = None,
    progress: Callable[[int, int], None] | None = None,
) -> WrittenReport:
    """Write one self-contained page about a posterior or a log, and its figures as files.

    Every page has the same sections: the data, faults, posteriors, calibration, metrics, tests, how it was made.

    Parameters
    ----------
    path
        A posterior, over goals or over theta; a study log (``.nc``, ``.zarr``); or a recording (``.jsonl``).
    directory
        The folder of the report. A new one appears whole; in an existing one only an earlier report is
        replaced.
    trials
        Names of the trials to show. By default, of goals: a typical, the best and the worst scored one; of theta:
        those in which the belief came to either side most, in which it changed most, and with most safety stops; of a
        log of two agents among goals: those in which the robot makes the most of a difference; else the first, a middle
        and the last one.
    at, min_samples, min_distance
        Which segments are scored and after which shares of them, as in
        `ppinfer.studies.scores.score_posterior`; for goals only.
    participants, exclude
        Only these, and all but these.
    model, parameters
        Which model infers the goals of a log that comes without a posterior: a name (default ``goal-lqr``) or a
        MODEL.toml, and parameters on top. Of a log of two agents among goals it is scored beside the page's own
        beliefs.
    robot, human
        Which agents of a log these are; by default those of these names, where they are there. Of a log with other
        agents, ``human`` says whose goals to infer (by default of the agent with most segments).
    progress
        Called after every figure with how many are drawn and how many there are.

    Returns
    -------
    WrittenReport
        Where the page and figures are, and the numbers on it. Of a log that can be read but is not sound, the page has
        its data sheet and faults, and nothing is concluded from it.

    Raises
    ------
    LogError
        If the file cannot be read or is damaged, a trial, participant or agent is unknown, something is asked for that
        the file gives no use for, or the folder is a file or holds another page. Nothing is written then.
    ModelError
        If there is no such model.

    Examples
    --------
    >>> from ppinfer.studies import write_log
    >>> from ppinfer.testing import example_log
    >>> write_log(example_log(), "log.nc")
    >>> report = write_report("log.nc", "report")
    >>> report.page.name, report.scores.overall[0].segments
    ('index.html', 12)
    """
    target = Path(directory)
    refuse_foreign_folder(target)
    options = ReportOptions(
        trials=None if trials is None else tuple(trials),
        at=tuple(at),
        min_samples=min_samples,
        min_distance=min_distance,
        participants=None if participants is None else tuple(participants),
        exclude=None if exclude is None else tuple(exclude),
        model=model,
        parameters=dict(parameters or {}),
        robot=robot,
        human=human,
    )
    with open_source(Path(path)) as source:
        writer = PageWriter(source, target, progress)
        if source.kind == "theta posterior":
            return write_theta_page(source, options, writer)
        if source.kind == "goal posterior":
            return write_goal_page(source, options, writer)
        return _write_log(source, options, writer)


def _write_log(source: Source, options: ReportOptions, writer: PageWriter) -> WrittenReport:
    if not source.checked.ok:
        return write_unsound_page(source, options, writer)
    with open_log(source.path) as log:
        pair = pair_of(log, options)
        if pair is not None and is_play_log(log):
            return write_play_page(source, log, options, pair, writer)
        if pair is not None and is_interaction_log(log):
            return write_interaction_page(source, log, options, pair, writer)
        return write_log_page(source, log, options, writer)
