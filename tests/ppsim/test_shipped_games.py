"""The log of reaching games in ``data/`` is what its data sheet says."""

import re
import shlex
from pathlib import Path

import numpy as np

from ppinfer.goals import infer_goals
from ppinfer.studies import file_sha256, open_log, read_log, validate_log
from ppinfer.studies.goal_evidence import goal_evidence
from ppsim.cli import main
from ppsim.reaching import Movement

DATA = Path(__file__).parents[2] / "data"
LOG = DATA / "reach-games-small.nc"
SHEET = (DATA / "README.md").read_text(encoding="utf-8").partition("## reach-games-small.nc")[2]


def test_the_shipped_log_is_sound_small_and_the_one_of_the_data_sheet():
    assert validate_log(LOG).ok
    assert LOG.stat().st_size < 400_000
    assert re.search(r"sha256 \| `(\w+)`", SHEET).group(1) == file_sha256(LOG)
    with open_log(LOG, verify=True) as log:
        assert set(log.data_vars) <= set(re.findall(r"`(\w+)`", SHEET))


def test_beliefs_inferred_from_the_shipped_log_are_those_held_live():
    log = read_log(LOG)
    for agent, name in (("human", "live_log_belief"), ("robot", "live_log_mental_model")):
        offline = infer_goals(Movement().model, goal_evidence(log, agent)).log_posterior
        np.testing.assert_allclose(np.exp(offline), np.exp(log[name].values), atol=1e-10)


def test_the_command_of_the_data_sheet_makes_the_shipped_log_anew(tmp_path, capsys):
    command = shlex.split(re.search(r"`(ppsim reach [^`]+)`", SHEET).group(1))
    target = tmp_path / "again.nc"
    assert command[-1] == "data/reach-games-small.nc"
    # in processes of their own, where nothing is checked besides
    assert main([*command[1:-1], str(target), "--workers", "2"]) == 0
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
