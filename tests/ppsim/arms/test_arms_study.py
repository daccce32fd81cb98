import json
import os
import signal
import subprocess
import sys
import textwrap
from contextlib import suppress
from dataclasses import dataclass
from importlib.resources import files

import jsonschema
import numpy as np
import pytest
import xarray as xr

from ppinfer.coordination import Policy
from ppinfer.studies import open_log, read_log, validate_log
from ppinfer.studies.personality_inference import infer_log_personality, live_difference
from ppinfer.studies.task_performance import task_performance
from ppsim.arms.execution import Execution
from ppsim.arms.study import ArmsStudy
from ppsim.cli import main
from ppsim.errors import SimulationError
from ppsim.study import log_of_study, record_study, recording_path


@dataclass(frozen=True)
class Breaks(Policy):
    """Fails when it is first asked."""

    def decide(self, situation, ego, memory=None):
        raise RuntimeError("it breaks")


SMALL = ArmsStudy(scenes=2, robots=("norm", "bayes"), humans=("selfish",), seed=11)


def assert_same_log(one, other):
    xr.testing.assert_identical(one.drop_attrs(), other.drop_attrs())


@pytest.fixture(scope="module")
def log():
    """Return the log of the small study, played in this process."""
    return log_of_study(SMALL, range(SMALL.trials))


def test_the_log_is_sound_and_says_all_that_happened(log):
    assert validate_log(log).ok
    assert log["trial_id"].values.tolist() == [
        "scene-0/shared/norm/selfish",
        "scene-0/shared/bayes/selfish",
        "scene-1/shared/norm/selfish",
        "scene-1/shared/bayes/selfish",
    ]
    assert log["controller"].values[1].tolist() == ["bayes", "selfish"]
    assert log["theta"].values.tolist() == ["robot", "human"]
    ends = np.cumsum(log["row_size"].values)
    for trial, (stop, size) in enumerate(zip(ends, log["row_size"].values, strict=True)):
        held = log["held"].values[stop - size : stop]
        assert log["stops"].values[trial] == held.sum()
        assert np.isclose(log["finish_time"].values[trial].max(), 0.1 * (size - 1))


def test_only_robots_that_believe_log_a_posterior(log):
    believes = np.repeat([False, True, False, True], log["replan_row_size"].values)
    known = np.isfinite(log["live_log_posterior"].values).all(axis=1)
    np.testing.assert_array_equal(known, believes)
    assert [bool(text) for text in log["live_model"].values] == [False, True, False, True]


def test_workers_play_the_same_trials(log, tmp_path):
    recorded = record_study(SMALL, SMALL.trials, tmp_path / "log.nc", workers=2)
    assert_same_log(recorded.log, log)


def test_a_cluster_plays_the_same_trials(log, tmp_path):
    distributed = pytest.importorskip("distributed")
    with distributed.LocalCluster(
        n_workers=1, threads_per_worker=2, processes=False, dashboard_address=None, protocol="inproc://"
    ) as cluster:
        recorded = record_study(SMALL, SMALL.trials, tmp_path / "log.nc", cluster=cluster.scheduler_address)
    assert_same_log(recorded.log, log)


def test_a_cluster_that_is_not_there_is_refused(tmp_path, monkeypatch):
    pytest.importorskip("distributed")
    monkeypatch.setattr("ppsim.cluster._CONNECT_WITHIN_S", 1)
    with pytest.raises(SimulationError, match=r"no Dask scheduler answers at tcp://127\.0\.0\.1:9"):
        record_study(SMALL, 1, tmp_path / "log.nc", cluster="tcp://127.0.0.1:9")
    # nothing is in the way of the next try, which need not resume
    assert list(tmp_path.iterdir()) == []


def test_a_cluster_that_is_lost_is_told_with_what_to_do(tmp_path, monkeypatch):
    distributed = pytest.importorskip("distributed")
    lost = distributed.client.FutureCancelledError("_play", "scheduler-connection-lost")
    monkeypatch.setattr(distributed.Future, "result", lambda self: (_ for _ in ()).throw(lost))
    with (
        distributed.LocalCluster(
            n_workers=1, threads_per_worker=1, processes=False, dashboard_address=None, protocol="inproc://"
        ) as cluster,
        pytest.raises(
            SimulationError, match=r"the Dask cluster at .* was lost: .*; trials .* go on with resume"
        ),
    ):
        record_study(SMALL, 1, tmp_path / "log.nc", cluster=cluster.scheduler_address)


def test_a_trial_that_fails_at_once_leaves_nothing_in_the_way(tmp_path):
    broken = ArmsStudy(scenes=1, robots=(f"{__name__}:Breaks",), humans=("norm",))
    with pytest.raises(SimulationError, match="breaks"):
        record_study(broken, 1, tmp_path / "log.nc", resume=False)
    assert list(tmp_path.iterdir()) == []


def test_a_recording_that_is_there_is_refused_with_what_to_do(tmp_path):
    recording_path(tmp_path / "log.nc").write_text("{}")
    with pytest.raises(
        SimulationError, match=r"an interrupted study left it; go on with it \(--resume\), or"
    ):
        record_study(SMALL, 1, tmp_path / "log.nc", resume=False)


@pytest.mark.parametrize("name", [".", "/"])
def test_a_folder_is_no_log(name, capsys):
    assert main(["study", "--scenes", "1", "-o", name]) == 1
    assert "give one of these suffixes" in capsys.readouterr().err


def test_workers_end_with_the_study_that_was_killed(tmp_path):
    (tmp_path / "sleeping.py").write_text(
        textwrap.dedent("""
        import os, sys, time
        from ppsim.study import simulate

        class Sleeping:
            def trial(self, index):
                print(os.getpid(), flush=True)
                time.sleep(300)

        if __name__ == "__main__":
            from sleeping import Sleeping
            list(simulate(Sleeping(), range(2), workers=2))
        """)
    )
    played = subprocess.Popen(
        [sys.executable, "sleeping.py"],
        cwd=tmp_path,
        stdout=subprocess.PIPE,
        text=True,
        start_new_session=True,
    )
    try:
        workers = [int(played.stdout.readline()) for _ in range(2)]
        played.kill()
        # a worker holds the pipe open for as long as it lives
        played.communicate(timeout=120)
    finally:
        with suppress(ProcessLookupError):
            os.killpg(played.pid, signal.SIGKILL)
        played.wait()
        played.stdout.close()
    assert len(set(workers)) == 2


def test_a_longer_study_begins_with_the_same_trials(log):
    longer = ArmsStudy(scenes=5, robots=SMALL.robots, humans=SMALL.humans, seed=SMALL.seed)
    np.testing.assert_array_equal(longer.trial(3).position, SMALL.trial(3).position)


def test_a_killed_study_goes_on_with_resume_to_the_same_bytes(tmp_path, log):
    target = tmp_path / "log.nc"
    whole = tmp_path / "whole.nc"
    record_study(SMALL, SMALL.trials, whole)
    script = textwrap.dedent("""
        import os, signal, sys
        from ppsim.arms.study import ArmsStudy
        from ppsim.study import record_study
        study = ArmsStudy(scenes=2, robots=("norm", "bayes"), humans=("selfish",), seed=11)
        def progress(done, total):
            if done == 2:
                os.kill(os.getpid(), signal.SIGKILL)
        record_study(study, study.trials, sys.argv[1], progress=progress)
    """)
    killed = subprocess.run([sys.executable, "-c", script, str(target)], check=False, capture_output=True)
    assert killed.returncode == -signal.SIGKILL
    assert recording_path(target).exists()
    assert not target.exists()
    # a line that was being written
    with recording_path(target).open("ab") as file:
        file.write(b'{"crc32": "0')
    arguments = ["study", "--scenes", "2", "--robots", "norm", "bayes", "--humans", "selfish", "--seed", "11"]
    assert main([*arguments, "-o", str(target)]) == 1
    assert main([*arguments, "-o", str(target), "--resume"]) == 0
    # nothing is left to resume
    assert main([*arguments, "-o", str(target), "--resume"]) == 1
    assert_same_log(read_log(target), read_log(whole))
    with open_log(target) as one, open_log(whole) as other:
        assert one.attrs["content_sha256"] == other.attrs["content_sha256"]


def test_the_json_fits_its_schema_and_the_log(tmp_path, capsys):
    target = tmp_path / "log.nc"
    arguments = ["study", "--scenes", "2", "--robots", "selfish", "norm", "--humans", "norm", "--seed", "3"]
    assert main([*arguments, "--plan-sets", "shared", "independent", "-o", str(target), "--json"]) == 0
    printed = capsys.readouterr()
    assert printed.err == ""
    told = json.loads(printed.out)
    schema = json.loads((files("ppsim") / "schemas" / "study.schema.json").read_text())
    jsonschema.Draft202012Validator.check_schema(schema)
    jsonschema.validate(told, schema, cls=jsonschema.Draft202012Validator)
    performance = task_performance(read_log(target))
    assert told["pooled"] == performance.pooled()
    assert {(row["robot"], row["plan_sets"]) for row in told["pooled"]} == {
        (robot, sets) for robot in ("selfish", "norm") for sets in ("shared", "independent")
    }


def test_the_tables_name_every_robot_and_the_next_command(tmp_path, capsys):
    target = tmp_path / "log.nc"
    assert (
        main(["study", "--scenes", "2", "--robots", "norm", "selfish", "--seed", "3", "-o", str(target)]) == 0
    )
    out = capsys.readouterr().out
    for text in (
        "shared plan sets, all humans",
        "by human",
        "paired differences",
        "total s",
        "episodes",
        "failures",
    ):
        assert text in out
    assert f"ppinfer infer {target} -o POST.nc --model personality" in out


OWN = """
from dataclasses import dataclass
from ppinfer.coordination import Selfish

@dataclass(frozen=True)
class Polite(Selfish):
    name = "polite"

not_a_policy = 3
"""


def test_a_policy_of_ones_own_can_sit_in_any_seat(tmp_path, monkeypatch, capsys):
    (tmp_path / "my_policies.py").write_text(OWN)
    monkeypatch.chdir(tmp_path)
    monkeypatch.syspath_prepend(tmp_path)
    own = "my_policies:Polite"
    command = ["study", "--scenes", "1", "--seed", "3", "-o", "log.nc", "--json", "--workers", "2"]
    assert main([*command, "--robots", "selfish", own, "--humans", "norm", own]) == 0
    told = json.loads(capsys.readouterr().out)
    rows = {row["robot"]: row for row in told["pooled"]}
    assert rows[own]["total_s"] == rows["selfish"]["total_s"]


OWN_MODELS = """
from dataclasses import dataclass, field
import numpy as np
from ppinfer.coordination import BayesNash, Personality

def fair():
    return BayesNash(personality=Personality(fair_within=2.0))

@dataclass(frozen=True)
class Weighted(Personality):
    weights: np.ndarray = field(default_factory=lambda: np.ones(2))

def weighted():
    return BayesNash(personality=Weighted())
"""


def test_a_robot_may_know_more_classes_of_theta_than_the_others(tmp_path, monkeypatch, capsys):
    (tmp_path / "my_beliefs.py").write_text(OWN_MODELS)
    monkeypatch.chdir(tmp_path)
    monkeypatch.syspath_prepend(tmp_path)
    command = ["study", "--scenes", "1", "--humans", "norm", "--seed", "3", "-o", "log.nc"]
    assert main([*command, "--robots", "bayes", "my_beliefs:fair"]) == 0
    with open_log("log.nc") as log:
        assert log["theta"].values.tolist() == ["robot", "human", "fair"]
        fair = np.repeat([False, True], log["replan_row_size"].values)
        np.testing.assert_array_equal(np.isneginf(log["live_log_posterior"].values[:, 2]), ~fair)
    posterior = infer_log_personality(read_log("log.nc"))
    assert live_difference(posterior)[1] < 1e-10


def test_a_model_that_a_log_cannot_hold_is_told_before_anything_is_played(tmp_path, monkeypatch, capsys):
    (tmp_path / "my_weights.py").write_text(OWN_MODELS)
    monkeypatch.chdir(tmp_path)
    monkeypatch.syspath_prepend(tmp_path)
    command = ["study", "--scenes", "1", "--seed", "3", "-o", "log.nc", "--robots", "my_weights:weighted"]
    assert main(command) == 1
    told = capsys.readouterr().err
    assert told.count("\n") == 1
    assert "parameters of 'personality' cannot be written as JSON" in told
    assert not (tmp_path / "log.recording.jsonl").exists()


def test_one_scene_has_no_spread_and_the_tables_show_none(tmp_path, capsys):
    command = ["study", "--scenes", "1", "--robots", "norm", "selfish", "--humans", "norm", "--seed", "3"]
    assert main([*command, "-o", str(tmp_path / "log.nc")]) == 0
    assert "nan" not in capsys.readouterr().out


@pytest.mark.parametrize(
    ("extra", "told"),
    [
        (["--robots", "nobody"], "there are no robots 'nobody'; there are defensive, selfish, norm"),
        (["--robots", "norm", "norm"], "robots: 'norm' is named twice"),
        (
            ["--humans", "bayes"],
            "there are no humans 'bayes'; there are defensive, selfish, norm, or module:attribute",
        ),
        (["--robots", "no_such_module:Policy"], "policy 'no_such_module:Policy' cannot be imported"),
        (["--robots", "json:dumps"], "policy 'json:dumps'"),
        (["--scenes", "0"], "scenes must be at least 1; got 0"),
        (["--seed", "-1"], "seed must be at least 0; got -1"),
        (["--cost-unit", "0"], "cost_unit must be a positive number of seconds"),
        (["--collision-stride", "0.25"], "collision_stride must be a positive multiple of 0.1 s"),
        (["--planner", "RRTX"], "there is no planner 'RRTX'"),
        (["--workers", "0"], "workers must be at least 1; got 0"),
        (["-o", "no/such/folder/log.nc"], "no/such/folder"),
        (["-o", "log.txt"], "log.txt"),
    ],
)
def test_what_cannot_be_played_is_one_line_and_leaves_nothing(tmp_path, monkeypatch, capsys, extra, told):
    monkeypatch.chdir(tmp_path)
    assert main(["study", "--scenes", "1", "--robots", "norm", "-o", "log.nc", *extra]) == 1
    printed = capsys.readouterr()
    assert printed.out == ""
    assert printed.err.count("\n") == 1
    assert told in printed.err
    assert os.listdir(tmp_path) == []


def test_a_study_out_of_range_is_refused():
    with pytest.raises(SimulationError, match="no robots are named"):
        ArmsStudy(robots=())
    with pytest.raises(SimulationError, match="there are no plan sets 'both'"):
        ArmsStudy(plan_sets=("both",))


def test_the_flags_of_the_sensitivity_arms_reach_the_trials():
    literal = ArmsStudy(
        scenes=1,
        robots=("bayes",),
        humans=("norm",),
        cost_unit=1.0,
        execution=Execution(collision_stride=0.8),
    )
    assert literal.policies("bayes", "norm")["robot"].norm.cost_unit == 1.0
    assert literal.configuration()["execution"]["collision_stride"] == 0.8


def test_offline_beliefs_are_those_held_live_whatever_the_robot(tmp_path):
    study = ArmsStudy(
        scenes=1,
        robots=("norm", "bayes", "bayes-literal", "bayes-risk", "oracle"),
        humans=("selfish",),
        plan_sets=("shared", "independent"),
        seed=21,
    )
    log = log_of_study(study, range(study.trials))
    posterior = infer_log_personality(log)
    replans, difference = live_difference(posterior)
    believes = [robot.startswith("bayes") for robot in log["controller"].values[:, 0]]
    assert replans == log["replan_row_size"].values[believes].sum()
    assert difference < 1e-10
