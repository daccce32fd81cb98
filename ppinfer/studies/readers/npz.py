"""NumPy archives without pickle: every array of an ``.npz``, or faults that say why not."""

from __future__ import annotations

import zipfile
from pathlib import Path

import numpy as np
from jaxtyping import Shaped

from ppinfer.studies.faults import Fault, Faults


def read_npz(path: Path, file: str, faults: Faults) -> dict[str, Shaped[np.ndarray, "*_"]] | None:
    """Return the arrays of an archive; what cannot be read is reported under the name ``file``.

    An array of Python objects would have to be unpickled, which can run any code: it is refused by name.
    """
    again = "the file is truncated or damaged: get it again from its source"
    arrays: dict[str, Shaped[np.ndarray, "*_"]] = {}
    try:
        with path.open("rb") as opened, zipfile.ZipFile(opened) as archive:
            damaged = archive.testzip()
            if damaged is not None:
                faults.add(
                    Fault("unreadable", "its checksum does not match", again, file=file, column=damaged)
                )
                return None
            for member in archive.namelist():
                with archive.open(member) as stream:
                    name = member.removesuffix(".npy")
                    if _is_pickled(stream):
                        told = "holds pickled Python objects, which are never loaded"
                        faults.add(
                            Fault("pickled", told, "save it as plain numbers or text", file=file, column=name)
                        )
                        continue
                with archive.open(member) as stream:
                    arrays[name] = np.lib.format.read_array(stream, allow_pickle=False)
    except Exception as error:
        # a damaged archive fails in as many ways as it has bytes
        faults.add(
            Fault("unreadable", f"cannot be read: {' '.join(str(error).split())[:120]}", again, file=file)
        )
        return None
    return arrays


def _is_pickled(stream: object) -> bool:
    version = np.lib.format.read_magic(stream)  # type: ignore[arg-type]
    read = np.lib.format.read_array_header_1_0 if version == (1, 0) else np.lib.format.read_array_header_2_0
    return bool(read(stream)[2].hasobject)  # type: ignore[arg-type]
