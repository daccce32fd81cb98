"""NumPy archives without pickle: every array of an ``.npz``, or faults that say why not."""

from __future__ import annotations

import math
import zipfile
from pathlib import Path
from typing import Any

import numpy as np
from jaxtyping import Shaped

from ppinfer.errors import LogError
from ppinfer.guarding.limits import limits_for, told_bytes
from ppinfer.studies.faults import Fault, Faults

MOST_ARRAYS = 1024
_AGAIN = "the file is truncated or damaged: get it again from its source"
_ENCRYPTED = 0x1
_METHODS = (zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED)


def read_npz(path: Path, file: str, faults: Faults) -> dict[str, Shaped[np.ndarray, "*_"]] | None:
    """Return the arrays of an archive; what cannot be read is reported under the name ``file``.

    An array of Python objects would have to be unpickled, which can run any code: it is refused by name. So is an
    archive that unpacks to more than a file of its size may, or whose members are not what NumPy writes.
    """
    arrays: dict[str, Shaped[np.ndarray, "*_"]] = {}
    before = faults.total
    try:
        with path.open("rb") as opened, zipfile.ZipFile(opened) as archive:
            _check_members(archive.infolist(), path.stat().st_size, file, faults)
            if faults.total > before:
                return None
            damaged = archive.testzip()
            if damaged is not None:
                faults.add(
                    Fault("unreadable", "its checksum does not match", _AGAIN, file=file, column=damaged)
                )
                return None
            for member in archive.infolist():
                name = member.filename.removesuffix(".npy")
                with archive.open(member) as stream:
                    fits = _check_header(stream, member.file_size, file, name, faults)
                if fits:
                    with archive.open(member) as stream:
                        arrays[name] = np.lib.format.read_array(stream, allow_pickle=False)
    except MemoryError:
        raise
    except Exception as error:
        # a damaged archive fails in as many ways as it has bytes
        faults.add(
            Fault("unreadable", f"cannot be read: {' '.join(str(error).split())[:120]}", _AGAIN, file=file)
        )
        return None
    return arrays


def _check_members(members: list[zipfile.ZipInfo], size: int, file: str, faults: Faults) -> None:
    """Report an archive that is not one that NumPy wrote, from its table of contents alone."""
    if len(members) > MOST_ARRAYS:
        told = f"holds {len(members)} arrays, more than the {MOST_ARRAYS} that are read"
        faults.add(Fault("unreadable", told, file=file))
        return
    names = [member.filename for member in members]
    # the last of each name: that there are others is what is wrong then
    for name, member in {member.filename: member for member in members}.items():
        problem = None
        if names.count(name) > 1:
            problem = f"is there {names.count(name)} times"
        elif name.startswith(("/", "\\")) or ".." in name.replace("\\", "/").split("/") or ":" in name:
            problem = "is a name that leads out of the archive"
        elif member.flag_bits & _ENCRYPTED:
            problem = "is encrypted"
        elif member.compress_type not in _METHODS:
            problem = "is packed in another way than NumPy packs"
        if problem is not None:
            faults.add(Fault("unreadable", problem, "save it anew with numpy.savez", file=file, column=name))
    claimed, most = sum(member.file_size for member in members), limits_for(size).memory
    if claimed > most:
        told = (
            f"unpacks to {told_bytes(claimed)}, more than the {told_bytes(most)} that a file of its size may"
        )
        remedy = "it is damaged, or made to do harm; if you trust it, allow more with PPINFER_GUARD_MEMORY"
        faults.add(Fault("unreadable", told, remedy, file=file))


def _check_header(stream: Any, size: int, file: str, name: str, faults: Faults) -> bool:
    """Return whether an array is plain and as large as it says; otherwise say so."""
    version = np.lib.format.read_magic(stream)
    read = np.lib.format.read_array_header_1_0 if version == (1, 0) else np.lib.format.read_array_header_2_0
    shape, _, kind = read(stream)
    if kind.hasobject:
        told = "holds pickled Python objects, which are never loaded"
        faults.add(Fault("pickled", told, "save it as plain numbers or text", file=file, column=name))
        return False
    if any(length < 0 for length in shape) or math.prod(shape) * kind.itemsize != size - stream.tell():
        told = f"says that its shape is {shape} of {kind}, which does not fit its {size} bytes"
        raise LogError(f"{name}: {told}")
    return True
