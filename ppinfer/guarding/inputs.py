"""What may be opened at all: a file or a folder, and of small files no more than a small file holds."""

from __future__ import annotations

import os
import stat
import tomllib
from pathlib import Path
from typing import Any

from ppinfer.errors import LogError, PPInferError
from ppinfer.guarding.limits import told_bytes

SMALL = 1 << 20
_SPECIAL = (
    (stat.S_ISFIFO, "a pipe"),
    (stat.S_ISSOCK, "a socket"),
    (stat.S_ISCHR, "a device"),
    (stat.S_ISBLK, "a device"),
)


def refuse_special(path: str | os.PathLike[str], error: type[PPInferError] = LogError) -> None:
    """Refuse what is there but is neither a file nor a folder: opening a pipe would wait for ever.

    Parameters
    ----------
    path
        What is to be opened; that it is not there is not told here.
    error
        The class of the refusal.

    Raises
    ------
    PPInferError
        Of the class ``error``, for a pipe, a socket or a device.

    Examples
    --------
    >>> refuse_special("/dev/null")
    Traceback (most recent call last):
        ...
    ppinfer.errors.LogError: /dev/null: is a device; give a file
    """
    try:
        mode = os.stat(path).st_mode
    except (OSError, ValueError):
        return
    for holds, name in _SPECIAL:
        if holds(mode):
            raise error(f"{os.fspath(path)}: is {name}; give a file")


def read_small_text(
    path: str | os.PathLike[str], error: type[PPInferError] = LogError, *, most: int = SMALL
) -> str:
    """Return the text of a file that is small by its nature, e.g. TOML, and refuse one that is not.

    Raises
    ------
    PPInferError
        Of the class ``error``, if it is larger than ``most`` bytes, or neither file nor folder.
    OSError, UnicodeDecodeError
        As when any file is read.

    Examples
    --------
    >>> _ = Path("small.toml").write_text("a = 1")
    >>> read_small_text("small.toml")
    'a = 1'
    >>> read_small_text("small.toml", most=3)
    Traceback (most recent call last):
        ...
    ppinfer.errors.LogError: small.toml: is larger than 3 bytes, the most that is read of such a file; ...
    """
    refuse_special(path, error)
    with Path(path).open("rb") as file:
        content = file.read(most + 1)
    if len(content) > most:
        raise error(
            f"{os.fspath(path)}: is larger than {told_bytes(most)}, the most that is read of such a file; is it the "
            "right one?"
        )
    # as text files are read: without a byte order mark's or Windows' ends of lines making a difference
    return content.decode("utf-8-sig").replace("\r\n", "\n")


def read_toml(
    path: str | os.PathLike[str], error: type[PPInferError] = LogError, *, most: int = SMALL
) -> dict[str, Any]:
    """Return what a TOML file says; it may not be large, nor nested without end.

    Raises
    ------
    PPInferError
        Of the class ``error``, if it is too large, nested too deeply, holds a number too long to be one, or is neither
        file nor folder.
    tomllib.TOMLDecodeError, OSError, UnicodeDecodeError
        If it is no TOML, or cannot be read.

    Examples
    --------
    >>> _ = Path("model.toml").write_text("a = " + "[" * 10_000)
    >>> read_toml("model.toml")
    Traceback (most recent call last):
        ...
    ppinfer.errors.LogError: model.toml: is nested too deeply to be read
    """
    text = read_small_text(path, error, most=most)
    try:
        return tomllib.loads(text)
    except RecursionError:
        raise error(f"{os.fspath(path)}: is nested too deeply to be read") from None
    except tomllib.TOMLDecodeError:
        raise
    except ValueError as failure:
        # e.g. a number of thousands of digits
        raise error(f"{os.fspath(path)}: cannot be read: {failure}") from failure
