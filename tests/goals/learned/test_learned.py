"""Learned conditional prediction: what holds whatever the weights, what training does, and what is kept of it."""

import dataclasses
import json
import pickle
import struct

import jsonschema
import numpy as np
import pytest

from ppinfer import Axis, Distribution
from ppinfer.cli import main
from ppinfer.errors import ModelError
from ppinfer.goals.choice import ExpectedCost, GoalSituation
from ppinfer.goals.conditional import post_goals
from ppinfer.goals.learned import (
    GoalPredictor,
    LearnedConditional,
    NetworkConfiguration,
    PredictionExamples,
    Training,
    read_predictor,
    train,
    write_predictor,
)
from ppinfer.goals.learned.examples import ExampleRange
from ppinfer.testing.choice import check_goal_chooser, check_goal_conditional
from ppinfer.testing.prediction_examples import example_predictions, example_store

torch = pytest.importorskip("torch", reason="needs the extra: pip install 'ppinfer[learned]'")
pytest.importorskip("safetensors", reason="needs the extra: pip install 'ppinfer[learned]'")

from ppinfer.goals.learned.network import build_network, weights_of  # noqa: E402

SMALL = NetworkConfiguration(past=4, horizon=8, hidden=8)


@pytest.fixture(scope="module")
def predictor():
    """A network whose weights are anything."""
    return GoalPredictor(SMALL, build_network(SMALL, seed=3))


@pytest.fixture(scope="module")
def trained():
    return train(example_predictions(64), SMALL, Training(epochs=2, seed=5))


@pytest.mark.parametrize("goals", [1, 2, 3, 7])
def test_probabilities_of_any_number_of_goals_sum_to_one(predictor, goals):
    found = np.exp(predictor.log_probabilities(example_predictions(6, goals=goals)))
    assert found.shape == (6, goals)
    np.testing.assert_allclose(found.sum(axis=1), 1.0, atol=1e-12)


def test_permuting_the_goals_permutes_the_answer(predictor):
    examples = example_predictions(6, goals=4)
    order = [2, 0, 3, 1]
    found = predictor.log_probabilities(examples.relabelled(order))
    np.testing.assert_allclose(found, predictor.log_probabilities(examples)[:, order], atol=1e-9)


def test_goals_that_are_absent_might_as_well_not_be_listed(predictor):
    examples = example_predictions(6, goals=3)
    present = np.concatenate([examples.present, np.zeros((6, 2), bool)], axis=1)
    padded = dataclasses.replace(
        examples,
        present=present,
        goals=np.concatenate([examples.goals, np.full((6, 2, 2), 1e3, np.float32)], axis=1),
        frequency=np.concatenate([examples.frequency, np.zeros((6, 2), np.float32)], axis=1),
    )
    found = predictor.log_probabilities(padded)
    np.testing.assert_allclose(found[:, :3], predictor.log_probabilities(examples), atol=1e-9)
    assert np.isneginf(found[:, 3:]).all()


def test_it_does_not_matter_where_in_the_workspace_all_this_happens(predictor):
    examples = example_predictions(6)
    along = np.array([3.0, 0.0, -2.0, 0.0], np.float32)
    moved = dataclasses.replace(
        examples,
        human=examples.human + along,
        robot=examples.robot + along,
        plan=examples.plan + along,
        goals=examples.goals + along[[0, 2]],
    )
    np.testing.assert_allclose(
        predictor.log_probabilities(moved), predictor.log_probabilities(examples), atol=1e-5
    )


def test_examples_of_another_shape_are_refused(predictor):
    with pytest.raises(ModelError, match="takes 4 steps of the past and 8 of a plan"):
        predictor.log_probabilities(example_predictions(2, past=5))


def test_a_few_examples_are_learned_by_heart():
    few = example_predictions(12)
    training = Training(epochs=100, patience=100, learning_rate=2e-2, turned=False)
    found = train(few, dataclasses.replace(SMALL, hidden=24), training, validation=few)
    assert found.validation_loss[found.best_epoch] < 5e-3
    scored = np.exp(found.predictor.log_probabilities(few))
    assert np.abs(scored - few.frequency).max() < 0.3


def test_what_the_plan_gives_away_is_learned():
    # by construction this human leaves the goal that the robot heads for, and nothing but the plan tells which that is
    training = Training(epochs=12, seed=1, learning_rate=5e-3)
    learned = train(example_predictions(960), dataclasses.replace(SMALL, hidden=16), training)
    fresh = example_predictions(300, seed=9)
    p = np.exp(learned.predictor.log_probabilities(fresh))
    index = np.arange(300)
    assert p[index, fresh.robot_goal].mean() < 0.25
    assert ((p - fresh.frequency) ** 2).mean() < 0.75 * ((1 / 3 - fresh.frequency) ** 2).mean()


def test_training_stops_when_the_validation_loss_no_longer_falls_and_keeps_the_best_weights():
    told = []
    noise = np.random.default_rng(0).dirichlet(np.ones(3), 40).astype(np.float32)
    untold = dataclasses.replace(example_predictions(40), frequency=noise)
    training = Training(epochs=100, patience=3, learning_rate=1e-2)
    found = train(untold, SMALL, training, progress=lambda done, total: told.append((done, total)))
    assert len(found.validation_loss) < 100
    assert len(found.validation_loss) - 1 - found.best_epoch == 3
    assert found.best_epoch == int(np.argmin(found.validation_loss))
    assert told == [(epoch + 1, 100) for epoch in range(len(found.validation_loss))]


@pytest.mark.parametrize(
    ("examples", "game", "cut"), [(64, 1, 58), (64, 10, 50), (60, 10, 50), (15, 10, 10), (8, 10, 7)]
)
def test_no_game_is_both_trained_on_and_decides_when_to_stop(examples, game, cut):
    made, asked = example_predictions(examples), []

    class Told:
        def __len__(self):
            return examples

        def read(self, start, stop):
            asked.append((start, stop))
            return made.read(start, stop)

    train(Told(), SMALL, Training(epochs=1), game=game)
    assert set(asked) == {(0, cut), (cut, examples)}


def test_the_same_seed_gives_the_same_weights_and_another_one_others(trained, tmp_path):
    again = train(example_predictions(64), SMALL, Training(epochs=2, seed=5))
    for name, found in (("a", trained), ("b", again)):
        write_predictor(found.predictor, tmp_path / f"{name}.safetensors")
    assert (tmp_path / "a.safetensors").read_bytes() == (tmp_path / "b.safetensors").read_bytes()
    assert again.training_loss == trained.training_loss
    other = train(example_predictions(64), SMALL, Training(epochs=2, seed=6))
    assert other.training_loss != trained.training_loss


def test_training_leaves_pytorch_as_it_was():
    before, threads = torch.random.get_rng_state(), torch.get_num_threads()
    train(example_predictions(16), SMALL, Training(epochs=1))
    assert torch.equal(torch.random.get_rng_state(), before)
    assert torch.get_num_threads() == threads


def test_examples_on_disk_teach_the_same_as_examples_in_memory(tmp_path, trained):
    store = example_store(tmp_path / "examples.zarr", 64)
    assert train(store, SMALL, Training(epochs=2, seed=5)).validation_loss == trained.validation_loss


def test_weights_are_read_back_as_they_were_written(trained, tmp_path):
    write_predictor(trained.predictor, tmp_path / "m.safetensors")
    back = read_predictor(tmp_path / "m.safetensors")
    assert back.configuration == trained.predictor.configuration
    examples = example_predictions(10, seed=4)
    np.testing.assert_array_equal(
        back.log_probabilities(examples), trained.predictor.log_probabilities(examples)
    )
    assert [path.name for path in tmp_path.iterdir()] == ["m.safetensors"]


def test_nothing_is_ever_pickled_or_unpickled(trained, tmp_path, monkeypatch):
    def refuse(*_, **__):
        raise AssertionError("pickle")

    for name in ("dump", "dumps", "load", "loads", "Pickler", "Unpickler"):
        monkeypatch.setattr(pickle, name, refuse)
    for name in ("save", "load"):
        monkeypatch.setattr(torch, name, refuse)
    write_predictor(trained.predictor, tmp_path / "m.safetensors")
    read_predictor(tmp_path / "m.safetensors")


def rewritten(path, change):
    """Rewrite the header of a safetensors file."""
    raw = path.read_bytes()
    (size,) = struct.unpack("<Q", raw[:8])
    header = json.loads(raw[8 : 8 + size])
    change(header)
    text = json.dumps(header).encode()
    path.write_bytes(struct.pack("<Q", len(text)) + text + raw[8 + size :])


def change_configuration(**values):
    def change(header):
        told = json.loads(header["__metadata__"]["ppinfer"])
        told["configuration"] |= values
        header["__metadata__"]["ppinfer"] = json.dumps(told)

    return change


@pytest.mark.parametrize(
    ("damage", "message"),
    [
        (lambda path: path.write_bytes(path.read_bytes()[:-40]), "no safetensors file, or a damaged one"),
        (lambda path: path.write_bytes(b"PK\x03\x04 a pickle in a zip"), "no safetensors file"),
        (lambda path: path.write_bytes(b""), "no safetensors file"),
        (
            lambda path: rewritten(path, lambda header: header.pop("__metadata__")),
            "not one that 'ppinfer learn'",
        ),
        (lambda path: rewritten(path, change_configuration(hidden=9)), "expected float32 of shape"),
        (lambda path: rewritten(path, change_configuration(hidden=10**9)), "hidden must be a whole number"),
        (lambda path: rewritten(path, change_configuration(dt="0.1")), "dt must be of type float"),
        (lambda path: rewritten(path, change_configuration(more=1)), "the configuration must name"),
        (lambda path: rewritten(path, change_configuration(length_scale=2.0)), "its digest differs"),
    ],
)
def test_a_file_that_is_damaged_or_none_of_ours_is_refused_in_one_line(trained, tmp_path, damage, message):
    path = tmp_path / "m.safetensors"
    write_predictor(trained.predictor, path)
    damage(path)
    with pytest.raises(ModelError, match=message) as refused:
        read_predictor(path)
    assert "\n" not in str(refused.value)
    assert str(refused.value).startswith(str(path))


def test_a_flipped_bit_in_a_weight_is_found(trained, tmp_path):
    path = tmp_path / "m.safetensors"
    write_predictor(trained.predictor, path)
    raw = bytearray(path.read_bytes())
    raw[-3] ^= 1
    path.write_bytes(bytes(raw))
    with pytest.raises(ModelError, match="its digest differs"):
        read_predictor(path)


def test_the_learned_conditional_obeys_the_laws_of_conditionals(predictor):
    check_goal_conditional(LearnedConditional(predictor), examples=8)


def test_choosers_use_it_in_the_place_of_the_softmax(predictor):
    check_goal_chooser(ExpectedCost(conditional=LearnedConditional(predictor)), examples=3)


def situation_of(examples, example, robot_goal, history):
    goal = Axis("goal", [str(each) for each in range(examples.goals.shape[1])])
    human, robot = examples.human[example].astype(float), examples.robot[example].astype(float)
    return GoalSituation(
        goals=examples.goals[example].astype(float),
        human=human[-1],
        robot=robot[-1],
        human_position=human[-1, [0, 2]],
        robot_position=robot[-1, [0, 2]],
        belief=Distribution.uniform(goal),
        mental_model=Distribution.uniform(goal.rename("robot_goal")),
        previous=robot_goal,
        human_history=human if history else None,
        robot_history=robot if history else None,
    )


@pytest.mark.parametrize("history", [True, False])
def test_the_conditional_says_of_a_robot_goal_what_the_network_says_of_the_plan_to_it(predictor, history):
    # of agents that stood; then the history tells nothing that the state does not
    examples = example_predictions(5)
    wanted = np.exp(predictor.log_probabilities(examples))
    for example, robot_goal in enumerate(examples.robot_goal.tolist()):
        situation = situation_of(examples, example, robot_goal, history)
        conditional = LearnedConditional(predictor).conditional(situation)
        assert (conditional.random, conditional.conditions) == (("post_goal",), ("robot_goal",))
        post = post_goals(conditional, situation.belief)
        np.testing.assert_allclose(post.values[robot_goal], wanted[example], atol=1e-6)


def test_a_situation_with_other_states_is_refused(predictor):
    goal = Axis("goal", ["cup", "bowl"])
    flat = GoalSituation(
        goals=np.eye(2),
        human=np.zeros(2),
        robot=np.ones(2),
        human_position=np.zeros(2),
        robot_position=np.ones(2),
        belief=Distribution.uniform(goal),
        mental_model=Distribution.uniform(goal.rename("robot_goal")),
    )
    with pytest.raises(ModelError, match="double-integrator states of 4 entries"):
        LearnedConditional(predictor).conditional(flat)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"frequency": np.full((3, 3), 0.5, np.float32)}, "frequencies of example 0"),
        ({"present": np.zeros((3, 3), bool)}, "example 0 has no goal"),
        ({"human": np.full((3, 4, 4), np.nan, np.float32)}, "human holds values that are not finite"),
        ({"robot_goal": np.array([0, 3, 0])}, "robot_goal names goals that are not there"),
    ],
)
def test_examples_that_cannot_be_are_refused(change, message):
    with pytest.raises(ModelError, match=message):
        dataclasses.replace(example_predictions(3), **change)


def test_a_range_of_examples_reads_nothing_beyond_its_end():
    examples = example_predictions(10)
    part = ExampleRange(examples, 2, 5)
    np.testing.assert_array_equal(part.read(1, 100).goals, examples.goals[3:5])
    joined = PredictionExamples.concatenate([part.read(0, 1), part.read(1, 3)])
    np.testing.assert_array_equal(joined.goals, examples.goals[2:5])


def test_the_command_scores_growing_amounts_of_data_beside_the_model_and_draws_them(tmp_path, capsys):
    from importlib.resources import files

    example_store(tmp_path / "d.zarr", 400)
    line = ["learn", tmp_path / "d.zarr", "-o", tmp_path / "m.safetensors", "--sizes", 20, 200, "--epochs", 4]
    line += ["--hidden", 8, "--figure", tmp_path / "curve.png"]
    assert main([*map(str, line), "--json"]) == 0
    printed = json.loads(capsys.readouterr().out)
    schema = json.loads((files("ppinfer.cli") / "schemas" / "learn.schema.json").read_text())
    jsonschema.validate(printed, schema)
    rows = printed["rows"]
    assert [(row["prediction"], row["trained_on"]) for row in rows] == [
        ("even", 0), ("model", 0), ("model fitted", 20), ("model fitted", 200), ("learned", 20), ("learned", 200),
    ]  # fmt: skip
    assert rows[5]["loss"] < rows[4]["loss"]
    assert rows[4]["interaction_hours"] == pytest.approx(20 * 4 / 3600)
    assert (tmp_path / "curve.png").stat().st_size > 5000
    assert read_predictor(tmp_path / "m.safetensors").configuration.hidden == 8
    short = ["learn", tmp_path / "d.zarr", "-o", tmp_path / "s.safetensors", "--sizes", 16, "--epochs", 1]
    assert main([*map(str, short)]) == 0
    assert "80 examples held out" in capsys.readouterr().out


@pytest.mark.parametrize("figure", ["curve.foo", "nowhere/curve.png"])
def test_a_figure_that_cannot_be_written_is_refused_before_anything_is_trained(tmp_path, capsys, figure):
    example_store(tmp_path / "d.zarr", 20)
    line = ["learn", tmp_path / "d.zarr", "-o", tmp_path / "m.safetensors", "--figure", tmp_path / figure]
    assert main([*map(str, line)]) == 1
    assert capsys.readouterr().err.count("\n") == 1
    assert not (tmp_path / "m.safetensors").exists()


def test_weights_of_a_network_are_all_that_it_has(predictor):
    assert set(weights_of(predictor.network)) == set(predictor.network.state_dict())
