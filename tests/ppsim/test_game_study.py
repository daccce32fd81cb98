"""`ppsim reach`: paired games of every robot with every human, logged, resumed and summed up."""

import json
import os
import signal
import subprocess
import sys
import textwrap
from importlib.resources import files

import jsonschema
import numpy as np
import pytest
import xarray as xr

from ppinfer.goals import infer_goals
from ppinfer.goals.conditional import SoftmaxConditional
from ppinfer.studies import open_log, read_log, validate_log, write_log
from ppinfer.studies.game_performance import GAME_METRICS, game_performance
from ppinfer.studies.goal_evidence import goal_evidence
from ppsim.cli import main
from ppsim.errors import SimulationError
from ppsim.reaching import GameStudy, Movement
from ppsim.reaching.game_study import changes_of_goal
from ppsim.study import log_of_study, record_study, recording_path

SMALL = GameStudy(
    games=2,
    robots=("naive", "reactive", "influence"),
    humans=("moving",),
    goals=(3, 4),
    seed=11,
    duration=7.0,
)
COMMAND = [
    "reach", "--games", "2", "--robots", "naive", "reactive", "influence", "--humans", "moving",
    "--goals", "3", "4", "--seed", "11", "--duration", "7",
]  # fmt: skip


@pytest.fixture(scope="module")
def log():
    """Return the log of the small study, played in this process."""
    return log_of_study(SMALL, range(SMALL.trials))


def rows(log):
    """Yield the slice of samples of each trial."""
    stop = np.cumsum(log["row_size"].values)
    for first, last in zip(stop - log["row_size"].values, stop, strict=True):
        yield slice(int(first), int(last))


def assert_same_log(one, other):
    xr.testing.assert_identical(one.drop_attrs(), other.drop_attrs())


def test_the_log_is_sound_and_says_all_that_happened(log):
    assert validate_log(log).ok
    assert log["trial_id"].values[:3].tolist() == [
        "game-0/3-goals/naive/moving",
        "game-0/3-goals/reactive/moving",
        "game-0/3-goals/influence/moving",
    ]
    assert log["controller"].values[1].tolist() == ["moving", "reactive"]
    time = log["time"].values
    for trial, here in enumerate(rows(log)):
        scored, pursued = log["scored"].values[here], log["pursued"].values[here]
        drawn = np.cumsum(scored)
        assert log["team_score"].values[trial] == 2 * scored.sum()
        assert log["collisions"].values[trial] == log["collision"].values[here].sum()
        first = log["first_score_s"].values[trial]
        if scored.any():
            assert first == pytest.approx(time[here][np.argmax(scored)])
        else:
            assert np.isnan(first)
        for agent, name in enumerate(("human", "robot")):
            assert log[f"{name}_goal_changes"].values[trial] == changes_of_goal(pursued[:, agent], drawn)
        count = log["goal_count"].values[trial]
        present = log["goal_present"].values[here]
        assert (present[:, :count] == 1).all()
        assert (present[:, count:] == 0).all()
        assert pursued.max() < count
    reactive = log["controller"].values[:, 1] == "reactive"
    waits = [(log["pursued"].values[here, 1] == -1).any() for here in rows(log)]
    assert np.array(waits)[reactive].all()


def test_exactly_the_picked_goals_are_drawn_anew(log):
    seen = 0
    for here in rows(log):
        goals, scored = log["goal_position"].values[here], log["scored"].values[here]
        position = log["position"].values[here]
        changed = (goals[1:] != goals[:-1]).any(axis=2) & ~np.isnan(goals[1:, :, 0])
        for sample in range(len(changed)):
            if not scored[sample + 1]:
                assert not changed[sample].any()
                continue
            seen += 1
            reached = np.linalg.norm(position[sample + 1][:, None] - goals[sample], axis=2).argsort(axis=1)
            np.testing.assert_array_equal(np.flatnonzero(changed[sample]), np.sort(reached[:, 0]))
    assert seen > 5


def test_beliefs_inferred_from_the_log_are_those_held_live(log):
    model = Movement().model
    for agent, name in (("human", "live_log_belief"), ("robot", "live_log_mental_model")):
        offline = infer_goals(model, goal_evidence(log, agent)).log_posterior
        np.testing.assert_allclose(np.exp(offline), np.exp(log[name].values), atol=1e-10)


def test_post_goals_are_those_of_the_paper_unless_the_human_knows_the_robots_goal(log):
    checked = 0
    for trial, here in enumerate(rows(log)):
        if log["controller"].values[trial, 1] != "influence":
            continue
        count = int(log["goal_count"].values[trial])
        for sample in range(here.start, here.stop, 17):
            goals, human = log["goal_position"].values[sample, :count], log["position"].values[sample, 0]
            own = log["pursued"].values[sample, 1]
            belief, mind, post = (
                np.exp(log[f"live_log_{name}"].values[sample, :count])
                for name in ("belief", "mental_model", "post")
            )
            between = np.linalg.norm(goals[:, None] - goals, axis=-1)
            expected = mind[own] * belief
            for prior in range(count):
                cost = 2 * np.linalg.norm(goals - human, axis=1) - 3 * between[own] + between[prior]
                weight = np.exp(-0.5 * (cost - cost.min()))
                expected += (1 - mind[own]) * belief[prior] * weight / weight.sum()
            np.testing.assert_allclose(post, expected, atol=1e-10)
            checked += 1
    assert checked > 5


def test_games_of_one_number_share_starts_and_goals_and_the_chance_of_later_draws(log):
    first = {}
    drawn_again = {}
    for trial, here in enumerate(rows(log)):
        scene, count = int(log["scene"].values[trial]), int(log["goal_count"].values[trial])
        start, goals = log["position"].values[here.start], log["goal_position"].values[here]
        known = first.setdefault((scene, count), (start, goals[0]))
        np.testing.assert_array_equal(known[0], start)
        np.testing.assert_array_equal(known[1], goals[0])
        np.testing.assert_array_equal(first[scene, SMALL.goals[0]][0], start)
        scored = np.flatnonzero(log["scored"].values[here])
        if len(scored):
            new = goals[scored[0]][(goals[scored[0]] != goals[0]).any(axis=1)]
            drawn_again.setdefault((scene, count), []).extend(new[~np.isnan(new[:, 0])].tolist())
    # the same draw, unless an agent or a goal that stays was in its way
    assert any(len({tuple(one) for one in new}) < len(new) for new in drawn_again.values())
    assert len({tuple(start.ravel()) for start, _ in first.values()}) == 2


def test_workers_play_the_same_games_and_a_longer_study_begins_with_them(log, tmp_path):
    recorded = record_study(SMALL, SMALL.trials, tmp_path / "log.nc", workers=2)
    assert_same_log(recorded.log, log)
    longer = GameStudy(
        games=5, **{name: getattr(SMALL, name) for name in ("robots", "humans", "goals", "seed", "duration")}
    )
    np.testing.assert_array_equal(longer.trial(11).position, log["position"].values[-70:])


def test_a_killed_study_goes_on_with_resume_to_the_same_bytes(tmp_path, log):
    target, whole = tmp_path / "log.nc", tmp_path / "whole.nc"
    write_log(log, whole)
    script = textwrap.dedent("""
        import os, signal, sys
        from ppsim.reaching import GameStudy
        from ppsim.study import record_study
        study = GameStudy(games=2, robots=("naive", "reactive", "influence"), humans=("moving",),
                          goals=(3, 4), seed=11, duration=7.0)
        def progress(done, total):
            if done == 8:
                os.kill(os.getpid(), signal.SIGKILL)
        record_study(study, study.trials, sys.argv[1], progress=progress)
    """)
    killed = subprocess.run([sys.executable, "-c", script, str(target)], check=False, capture_output=True)
    assert killed.returncode == -signal.SIGKILL, killed.stderr
    assert recording_path(target).exists()
    with recording_path(target).open("ab") as file:
        file.write(b'{"crc32": "0')
    assert main([*COMMAND, "-o", str(target)]) == 1
    assert main([*COMMAND, "-o", str(target), "--resume"]) == 0
    assert main([*COMMAND, "-o", str(target), "--resume"]) == 1
    with open_log(target) as one, open_log(whole) as other:
        assert one.attrs["content_sha256"] == other.attrs["content_sha256"]


def test_the_json_fits_its_schema_and_the_log(tmp_path, capsys):
    schema = json.loads((files("ppsim") / "schemas" / "reach.schema.json").read_text())
    jsonschema.Draft202012Validator.check_schema(schema)
    target = tmp_path / "log.nc"
    for goals, humans in ((["3"], ["waiting"]), (["3", "4"], ["moving", "stubborn"])):
        command = [
            "reach",
            "--games",
            "2",
            "--robots",
            "naive",
            "influence",
            "--duration",
            "5",
            "--seed",
            "3",
        ]
        assert main([*command, "--goals", *goals, "--humans", *humans, "-o", str(target), "--json"]) == 0
        printed = capsys.readouterr()
        assert printed.err == ""
        told = json.loads(printed.out)
        jsonschema.validate(told, schema, cls=jsonschema.Draft202012Validator)
        performance = game_performance(read_log(target))
        assert told["pooled"] == performance.pooled()
        assert [row["robot"] for row in told["pooled"]] == ["naive", "influence"] * len(goals)
        assert all(("goals" in row) == (len(goals) > 1) for row in told["pooled"])
        assert {row["human"] for row in told["cells"]} == set(humans)
        row = told["pooled"][0]
        assert set(row) - {"robot", "goals"} == {
            f"{name}{end}" for name in GAME_METRICS for end in ("", "_sem")
        }


def test_the_tables_name_every_robot_and_the_next_command(tmp_path, capsys):
    target = tmp_path / "log.nc"
    command = ["reach", "--games", "1", "--robots", "naive", "influence", "--duration", "1"]
    assert main([*command, "-o", str(target)]) == 0
    out = capsys.readouterr().out
    for text in ("3 goals, all humans", "by human", "paired differences", "collisions", "first score s"):
        assert text in out
    assert "nan" not in out
    assert f"next: ppinfer infer {target}" in out


OWN = """
from dataclasses import dataclass
from ppinfer.goals.choice import NearestGoal

@dataclass(frozen=True)
class Mine(NearestGoal):
    name = "mine"

not_a_chooser = 3
"""


def test_a_chooser_of_ones_own_can_be_the_robot(tmp_path, monkeypatch, capsys):
    (tmp_path / "my_choosers.py").write_text(OWN)
    monkeypatch.chdir(tmp_path)
    monkeypatch.syspath_prepend(tmp_path)
    own = "my_choosers:Mine"
    command = ["reach", "--games", "1", "--duration", "2", "--keep-clear", "none", "-o", "log.nc", "--json"]
    assert main([*command, "--robots", "naive", own, "--workers", "2"]) == 0
    rows = {row["robot"]: row for row in json.loads(capsys.readouterr().out)["pooled"]}
    assert {**rows[own], "robot": ""} == {**rows["naive"], "robot": ""}
    assert main([*command[:-1], "--robots", "my_choosers:not_a_chooser"]) == 1
    assert "is a int; expected a ppinfer.goals.GoalChooser, or what makes one" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("extra", "told"),
    [
        (["--robots", "nobody"], "there are no robots 'nobody'; there are naive, reactive"),
        (["--robots", "naive", "naive"], "robots: 'naive' is named twice"),
        (["--humans", "shy"], "there are no humans 'shy'; there are waiting, moving, stubborn"),
        (["--robots", "no_such_module:Chooser"], "robot 'no_such_module:Chooser' cannot be imported"),
        (["--games", "0"], "games must be at least 1; got 0"),
        (["--goals", "1"], "1 goals are too few for 2 agents"),
        (["--goals", "3", "3"], "goals must be one number or several different ones"),
        (["--goals", "300"], "300 goals 3 m apart do not fit"),
        (["--seed", "-1"], "seed must be at least 0; got -1"),
        (["--duration", "0.1"], "has 1 samples"),
        (["--reactive-threshold", "2"], "threshold must lie in [0, 1]"),
        (["--human-noise", "-1"], "the human's noise must be finite and not negative"),
        (["--control-weight", "0"], "control_weight must lie in"),
        (["--rationality", "nan"], "rationality must lie in"),
        (["--workers", "0"], "workers must be at least 1; got 0"),
        (["-o", "no/such/folder/log.nc"], "no/such/folder"),
        (["-o", "log.txt"], "log.txt"),
    ],
)
def test_what_cannot_be_played_is_one_line_and_leaves_nothing(tmp_path, monkeypatch, capsys, extra, told):
    monkeypatch.chdir(tmp_path)
    command = ["reach", "--games", "1", "--robots", "reactive", "--duration", "2", "-o", "log.nc"]
    assert main([*command, *extra]) == 1
    printed = capsys.readouterr()
    assert printed.out == ""
    assert printed.err.count("\n") == 1
    assert told in printed.err
    assert os.listdir(tmp_path) == []


def test_a_study_out_of_range_is_refused():
    for bad, told in (
        ({"robots": ()}, "no robots are named"),
        ({"goals": ()}, "goals must be one number or several"),
        ({"duration": float("inf")}, "duration must be positive and finite"),
        ({"reaction": "none"}, "reaction must be one of reacted, softmax"),
        ({"redraw": "some"}, "redraw must be one of all, picked"),
    ):
        with pytest.raises(SimulationError, match=told):
            GameStudy(**bad)


def test_options_reach_the_seats_and_the_log_says_them():
    study = GameStudy(reactive_threshold=0.5, human_noise=0.2, control_weight=30.0, keep_clear="all")
    assert study.robot("reactive").chooser.threshold == 0.5
    assert study.robot("naive").keep_clear is not None
    assert study.human("moving").noise == 0.2
    assert study.robot("courtesy").chooser.conditional == SoftmaxConditional()
    assert study.robot("expected-cost").chooser.conditional.reaction == SoftmaxConditional()
    assert GameStudy(reaction="softmax").robot("switching").chooser.unsure.conditional == SoftmaxConditional()
    joint = study.robot("joint").chooser
    np.testing.assert_allclose(joint.robot.gain, study.movement.agent.K)
    told = study.configuration()
    assert told["world"] == "reaching-game"
    assert (told["control_weight"], told["rules"]["pick_radius"]) == (30.0, 0.5)
    assert json.loads(json.dumps(told)) == told
