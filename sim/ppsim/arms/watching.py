"""A trial of two arms as a moving picture, from its log alone."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import xarray as xr

from ppinfer.studies.progress import ProgressCallback, silent


def draw_trial(
    log: xr.Dataset, path: Path | str, *, fps: int = 10, progress: ProgressCallback = silent
) -> None:
    """Draw the log of one trial as a GIF or an MP4, a frame a sample.

    Parameters
    ----------
    log : xarray.Dataset
        Of one trial of two arms; see `ppsim.one_trial.one_trial`.
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
    from ppsim.video import Frame, check_video_path, write_video

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
