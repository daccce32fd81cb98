"""`import ppinfer` is cheap: it loads little beyond NumPy, SciPy and xarray, and compiles nothing."""

from __future__ import annotations

import json
import os
import subprocess
import sys

import pytest

from .pages import ROOT

HEAVY = {
    "beartype", "filterpy", "h5netcdf", "h5py", "hypothesis", "jinja2", "matplotlib", "numba", "pydantic", "rich",
    "tomli_w", "zarr",
}  # fmt: skip
# pandas and pyarrow come with xarray itself, so they are no cost of ours
ALLOWED = {"ppinfer", "numpy", "scipy", "xarray", "jaxtyping", "wadler_lindig", "typing_extensions"}

PROBE = """
import json, sys
import numpy, scipy, xarray
before = set(sys.modules)
{statement}
print(json.dumps(sorted({{name.partition(".")[0] for name in set(sys.modules) - before}})))
"""


def packages_loaded_by(statement):
    """Return the packages that a statement loads in a new interpreter, after NumPy, SciPy and xarray."""
    path = os.pathsep.join([str(ROOT), str(ROOT / "sim"), os.environ.get("PYTHONPATH", "")])
    ran = subprocess.run(
        [sys.executable, "-W", "error", "-c", PROBE.format(statement=statement)],
        capture_output=True,
        text=True,
        check=False,
        env=os.environ | {"PYTHONPATH": path},
    )
    assert ran.returncode == 0, ran.stderr
    return set(json.loads(ran.stdout))


def test_importing_ppinfer_loads_nothing_heavy():
    loaded = packages_loaded_by("import ppinfer")
    assert not loaded & HEAVY
    assert loaded - set(sys.stdlib_module_names) <= ALLOWED


def test_goals_and_safety_load_no_more_of_scipy_than_xarray_does():
    ran = subprocess.run(
        [
            sys.executable,
            "-c",
            "import sys, ppinfer.goals, ppinfer.safety; print('scipy.special' in sys.modules)",
        ],
        capture_output=True,
        text=True,
        check=True,
    )
    assert ran.stdout == "False\n"


@pytest.mark.parametrize(
    "statement",
    [
        "import ppinfer.distributions",
        "import ppinfer.goals",
        "import ppinfer.studies",
        "import ppinfer.plots",
        "import ppinfer.testing",
        "from ppinfer.cli import build_parser; build_parser()",
        "import ppsim",
    ],
)
def test_what_is_heavy_is_loaded_only_where_it_is_used(statement):
    assert not packages_loaded_by(statement) & HEAVY
