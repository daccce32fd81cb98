"""The log of two arms in ``data/`` is what its data sheet says."""

import re
import shlex
from importlib.metadata import version
from pathlib import Path

import numpy as np
import pytest

from ppinfer.studies import file_sha256, infer_log_personality, open_log, read_log, validate_log
from ppinfer.studies.personality_inference import live_difference
from ppsim.cli import main

DATA = Path(__file__).parents[3] / "data"
LOG = DATA / "arms-small.nc"
SHEET = (DATA / "README.md").read_text(encoding="utf-8").partition("## arms-small.nc")[2]


def test_the_shipped_log_is_sound_small_and_the_one_of_the_data_sheet():
    assert validate_log(LOG).ok
    assert LOG.stat().st_size < 1_500_000
    assert re.search(r"sha256 \| `(\w+)`", SHEET).group(1) == file_sha256(LOG)
    with open_log(LOG, verify=True) as log:
        assert set(log.data_vars) <= set(re.findall(r"`(\w+)`", SHEET))


def test_every_robot_met_every_human_in_every_scene():
    with open_log(LOG) as log:
        met = {
            (int(scene), *map(str, who))
            for scene, who in zip(log["scene"].values, log["controller"].values, strict=True)
        }
        assert log.sizes["trial"] == len(met) == 3 * 4 * 3
        assert (log["outcome"].values == "completed").all()


def test_beliefs_inferred_from_the_shipped_log_are_those_held_live():
    compared, difference = live_difference(infer_log_personality(read_log(LOG)))
    assert compared > 200
    assert difference < 1e-10


@pytest.mark.skipif(
    f"OMPL {version('ompl')}" not in SHEET, reason="another version of OMPL may draw other plans"
)
def test_the_command_of_the_data_sheet_makes_the_shipped_log_anew(tmp_path, capsys):
    command = shlex.split(re.search(r"`(ppsim study [^`]+)`", SHEET).group(1))
    target = tmp_path / "again.nc"
    assert command[-1] == "data/arms-small.nc"
    assert main([*command[1:-1], str(target)]) == 0
    again, shipped = read_log(target), read_log(LOG)
    assert set(again.variables) == set(shipped.variables)
    assert again.attrs["configuration"] == shipped.attrs["configuration"]
    for name, variable in shipped.variables.items():
        if variable.dtype.kind == "f":
            # other mathematical libraries round differently
            np.testing.assert_allclose(
                again[name].values, variable.values, rtol=1e-7, atol=1e-7, err_msg=name
            )
        else:
            np.testing.assert_array_equal(again[name].values, variable.values, err_msg=name)
