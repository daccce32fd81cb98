"""Files from elsewhere are read first by a process of their own, which may not take too long or too much memory.

A damaged or hostile file can hang the library that reads it, crash it, or have it allocate all there is. Before this
process opens such a file, a helper process reads it end to end with the same code, under limits (`Limits`). What it
found wrong is raised here as the same error; only a file that was read to its end is then opened here.
See docs/untrusted-files.md.
"""

from ppinfer.guarding.admission import admitted, asked, start_early
from ppinfer.guarding.fingerprints import remember_written
from ppinfer.guarding.inputs import read_small_text, read_toml, refuse_special
from ppinfer.guarding.limits import Limits, limited, limits_for, trusting

__all__ = [
    "Limits",
    "admitted",
    "asked",
    "limited",
    "limits_for",
    "read_small_text",
    "read_toml",
    "refuse_special",
    "remember_written",
    "start_early",
    "trusting",
]
