"""A trial of two arms as a moving picture, from its log alone."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import xarray as xr

from ppinfer.errors import LogError
from ppinfer.studies import select_trials
from ppinfer.studies.progress import ProgressCallback, silent


def one_trial(log: xr.Dataset, trial: str | None = None, *, where: str = "the log") -> xr.Dataset:
    """Return one trial of a log, by its id; the first one where none is named.

    Parameters
    ----------
    log : xarray.Dataset
        A study log.
    trial : str, optional
        The trial's id.
    where : str
        What an error calls the log.

    Raises
    ------
    LogError
        If there is no such trial.

    Examples
    --------
    >>> from ppinfer.testing import example_log
    >>> one_trial(example_log(participants=1, trials=3)).sizes["trial"]
    1
    """
    names = [str(name) for name in log["trial_id"].values]
    if not names:
        raise LogError(f"{where} holds no trial")
    if trial is not None and trial not in names:
        raise LogError(
            f"{where} has no trial {trial!r}; it holds {len(names)}: {', '.join(map(repr, names[:10]))}"
            f"{', ...' * (len(names) > 10)}"
        )
    return select_trials(log, [0 if trial is None else names.index(trial)])


def draw_trial(
    log: xr.Dataset, path: Path | str, *, fps: int = 10, progress: ProgressCallback = silent
) -> None:
    """Draw the log of one trial as a GIF or an MP4, a frame a sample.

    Parameters
    ----------
    log : xarray.Dataset
        Of one trial of two arms; see `one_trial`.
    path : path
        Ends in ``.gif``, or in ``.mp4`` (extra ``video``).
    fps : int
        Frames a second; 10 is as fast as it happened.
    progress : callable
        Is told how many frames are drawn.

    Raises
    ------
    LogError
        If the log is not of one trial of two arms.
    SimulationError
        If the name ends otherwise, or MP4 cannot be written.
    """
    from ppsim.arms.recorded import read_recorded
    from ppsim.arms.trial_picture import STOP_SHADES, TrialPicture
    from ppsim.arms.video import Frame, check_video_path, write_video

    target = Path(path)
    check_video_path(target)
    trial = read_recorded(log)
    picture = TrialPicture(trial)
    samples = len(trial.time)

    def frames() -> Iterator[Frame]:
        for sample in range(samples):
            picture.show(sample)
            yield picture.pixels()
            progress(sample + 1, samples)

    write_video(target, frames(), fps=fps, colours=STOP_SHADES)
