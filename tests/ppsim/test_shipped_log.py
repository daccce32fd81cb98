"""The log in ``data/`` is what its data sheet says."""

import re
import shlex
from pathlib import Path

import numpy as np
import pytest

from ppinfer.studies import file_sha256, open_log, read_log, validate_log
from ppsim.cli import main

DATA = Path(__file__).parents[2] / "data"
SHEET = (DATA / "README.md").read_text(encoding="utf-8")
LOG = DATA / "reaching-small.nc"


def test_the_shipped_log_is_sound_small_and_the_one_of_the_data_sheet():
    assert validate_log(LOG).ok
    assert LOG.stat().st_size < 300_000
    assert re.search(r"sha256 \| `(\w+)`", SHEET).group(1) == file_sha256(LOG)
    with open_log(LOG, verify=True) as log:
        named = set(re.findall(r"`(\w+)`", SHEET))
        assert set(log.data_vars) <= named


def test_the_command_of_the_data_sheet_makes_the_shipped_log_anew(tmp_path, capsys):
    command = shlex.split(re.search(r"`(ppsim record [^`]+)`", SHEET).group(1))
    target = tmp_path / "again.nc"
    assert command[-1] == "data/reaching-small.nc"
    assert main([*command[1:-1], str(target)]) == 0
    again, shipped = read_log(target), read_log(LOG)
    assert set(again.variables) == set(shipped.variables)
    assert again.attrs["configuration"] == shipped.attrs["configuration"]
    for name, variable in shipped.variables.items():
        if variable.dtype.kind == "f":
            # other linear algebra libraries round differently
            np.testing.assert_allclose(
                again[name].values, variable.values, rtol=1e-9, atol=1e-9, err_msg=name
            )
        else:
            np.testing.assert_array_equal(again[name].values, variable.values, err_msg=name)


@pytest.mark.parametrize("agent", ["human", "robot"])
def test_every_agent_of_the_shipped_log_has_segments_with_a_goal(agent):
    with open_log(LOG) as log:
        mine = log["segment_agent"].values == agent
        assert mine.sum() > 50
        assert (log["true_goal"].values[mine] != "").all()
