"""Frames to moving pictures: GIF by Pillow, MP4 by ffmpeg where the extra is installed."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from jaxtyping import UInt8

from ppsim.errors import SimulationError

Frame = UInt8[np.ndarray, "row column 3"]
SUFFIXES = (".gif", ".mp4")
# colours of a GIF, and how long its last frame stays, s
_COLOURS, _LINGER = 96, 2.0


def check_video_path(path: Path) -> None:
    """Raise a SimulationError unless a moving picture can be written there, before anything is drawn.

    Examples
    --------
    >>> check_video_path(Path("trial.gif"))
    >>> check_video_path(Path("trial.avi"))
    Traceback (most recent call last):
    ppsim.errors.SimulationError: ...
    """
    if path.suffix.lower() not in SUFFIXES:
        raise SimulationError(f"{path}: the name must end in {' or '.join(SUFFIXES)}")
    if not path.parent.is_dir():
        raise SimulationError(f"{path}: there is no folder {path.parent}")
    if path.suffix.lower() == ".mp4":
        _ffmpeg()


def write_video(
    path: Path, frames: Iterable[Frame], *, fps: int, colours: Sequence[tuple[int, int, int]] = ()
) -> None:
    """Write frames of the same size as GIF or MP4, by the ending of the name.

    Parameters
    ----------
    path : Path
        Where to.
    frames : iterable of (row, column, 3) uint8
        Red, green and blue.
    fps : int
        Frames a second.
    colours : sequence of (red, green, blue)
        A GIF has few colours, and takes them from its first frame; these it has besides.

    Raises
    ------
    SimulationError
        If the ending is another, or an MP4 is asked for and ffmpeg is not there.
    """
    check_video_path(path)
    if path.suffix.lower() == ".mp4":
        _write_mp4(path, frames, fps)
    else:
        _write_gif(path, frames, fps, colours)


def _write_gif(
    path: Path, frames: Iterable[Frame], fps: int, colours: Sequence[tuple[int, int, int]]
) -> None:
    from PIL import Image

    images: list[Any] = []
    few: Any
    palette: Any = None
    for frame in frames:
        image = Image.fromarray(frame)
        if palette is None:
            # all frames have the same colours, so that what stands still does not flicker
            few = image.quantize(_COLOURS, method=Image.Quantize.MEDIANCUT, dither=Image.Dither.NONE)
            palette = Image.new("P", (1, 1))
            palette.putpalette(
                [*few.getpalette()[: 3 * _COLOURS], *(part for rgb in colours for part in rgb)]
            )
        images.append(image.quantize(palette=palette, dither=Image.Dither.NONE))
    if not images:
        raise SimulationError(f"{path}: there are no frames to write")
    duration = [round(1000 / fps)] * (len(images) - 1) + [round(1000 * _LINGER)]
    images[0].save(path, save_all=True, append_images=images[1:], duration=duration, loop=0, optimize=False)


def _write_mp4(path: Path, frames: Iterable[Frame], fps: int) -> None:
    writer = None
    last = None
    for frame in frames:
        if writer is None:
            writer = _ffmpeg().write_frames(
                str(path),
                (frame.shape[1], frame.shape[0]),
                fps=fps,
                macro_block_size=2,
                quality=8,
                ffmpeg_log_level="error",
            )
            writer.send(None)
        last = np.ascontiguousarray(frame)
        writer.send(last)
    if writer is None:
        raise SimulationError(f"{path}: there are no frames to write")
    for _ in range(round(fps * _LINGER)):
        writer.send(last)
    writer.close()


def _ffmpeg() -> Any:
    try:
        import imageio_ffmpeg
    except ImportError:
        raise SimulationError(
            "writing MP4 needs ffmpeg: install ppinfer[video], or give a name that ends in .gif"
        ) from None
    return imageio_ffmpeg
