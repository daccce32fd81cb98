"""Examples on disk, and scores of predictions on them; none of this needs the extra."""

from dataclasses import replace

import numpy as np
import pytest

from ppinfer import Axis, Distribution
from ppinfer.errors import LogError
from ppinfer.goals import GoalEvidence, GoalLQR, infer_goals
from ppinfer.goals.choice import GoalSituation
from ppinfer.goals.conditional import post_goals
from ppinfer.studies.learning import split_of
from ppinfer.studies.model_prediction import ModelPrediction, fit_model_prediction
from ppinfer.studies.prediction_examples import ExampleStore, ExampleWriter, StoredExamples
from ppinfer.studies.prediction_scores import score_predictions
from ppinfer.testing.prediction_examples import example_header, example_predictions, example_store


def test_the_scores_are_what_their_definitions_say_counted_one_by_one():
    rng = np.random.default_rng(2)
    p = rng.dirichlet(np.ones(3), 50)
    counts = np.stack([rng.multinomial(8, each) for each in p])
    frequency = (counts / 8).astype(np.float32)
    score = score_predictions(np.log(p), frequency, np.ones((50, 3), bool))
    brier, surprise = [], []
    for example in range(50):
        for goal in range(3):
            outcome = np.arange(3) == goal
            brier += [((p[example] - outcome) ** 2).sum()] * counts[example, goal]
            surprise += [np.log(p[example, goal])] * counts[example, goal]
    assert score.brier == pytest.approx(np.mean(brier), abs=1e-12)
    assert score.mean_log_probability == pytest.approx(np.mean(surprise), abs=1e-12)
    assert score.loss == pytest.approx(np.mean((p - frequency) ** 2), abs=1e-12)


def test_probabilities_that_come_true_as_often_as_they_say_are_calibrated():
    rng = np.random.default_rng(3)
    p = rng.dirichlet(np.ones(2), 20_000)
    came = rng.random(20_000) < p[:, 0]
    outcome = np.stack([came, ~came], axis=1).astype(np.float32)
    present = np.ones((20_000, 2), bool)
    assert score_predictions(np.log(p), outcome, present).expected_calibration_error < 0.01
    bold = p**3 / (p**3).sum(axis=1, keepdims=True)
    assert score_predictions(np.log(bold), outcome, present).expected_calibration_error > 0.05


def test_a_goal_held_impossible_that_was_reached_costs_everything():
    with np.errstate(divide="ignore"):
        sure = np.log(np.array([[1.0, 0.0]]))
    score = score_predictions(sure, np.array([[0.5, 0.5]]), np.ones((1, 2), bool))
    assert score.mean_log_probability == -np.inf


@pytest.mark.parametrize(("examples", "bound"), [(60, 40), (65, 40), (10, 8), (21, 10)])
def test_no_game_is_both_trained_on_and_held_out(tmp_path, examples, bound):
    made = example_predictions(examples)
    header = replace(example_header(made), batch=1000, configuration={"instants": 10})
    ExampleWriter(tmp_path / "d.zarr", header).append(
        StoredExamples(made, np.zeros(examples, dtype=int), np.ones(examples, np.float32))
    )
    assert split_of(ExampleStore(tmp_path / "d.zarr"), 0.25) == bound


def test_the_model_predicts_what_beliefs_and_the_softmax_conditional_of_the_library_do():
    model = ModelPrediction(rationality=2e-3)
    examples = example_predictions(3, past=6)
    rng = np.random.default_rng(0)
    velocity = rng.normal(0, 1, (3, 6, 2)).cumsum(axis=1)
    examples.human[..., [1, 3]] = velocity
    found = np.exp(model.log_probabilities(examples))
    lqr = GoalLQR("double-integrator", control_weight=1.0, state_weight=10.0, rationality=2e-3)
    for example in range(3):
        states = examples.human[example].astype(float)
        evidence = GoalEvidence(
            time=0.1 * np.arange(6),
            position=states[:, [0, 2]],
            velocity=states[:, [1, 3]],
            goals=examples.goals[example : example + 1].astype(float),
            row_size=np.array([6]),
            goal_labels=("0", "1", "2"),
        )
        goal = Axis("goal", ["0", "1", "2"])
        belief = Distribution([goal], infer_goals(lqr, evidence).log_posterior[-1])
        situation = GoalSituation(
            goals=examples.goals[example].astype(float),
            human=states[-1],
            robot=np.zeros(4),
            human_position=states[-1, [0, 2]],
            robot_position=np.zeros(2),
            belief=belief,
            mental_model=Distribution.uniform(goal.rename("robot_goal")),
        )
        post = post_goals(model.conditional.conditional(situation), belief)
        np.testing.assert_allclose(post.values[examples.robot_goal[example]], found[example], atol=1e-9)


def test_fitting_the_model_lowers_its_error():
    examples = example_predictions(60)

    def loss(model):
        return ((np.exp(model.log_probabilities(examples)) - examples.frequency) ** 2).mean()

    assert loss(fit_model_prediction(ModelPrediction(), examples)) < loss(ModelPrediction())


def stored(examples):
    return StoredExamples(examples, np.zeros(len(examples), int), np.ones(len(examples), np.float32))


def test_what_was_half_appended_is_dropped_when_a_store_is_continued(tmp_path):
    examples = example_predictions(30)
    path, header = tmp_path / "d.zarr", example_header(examples)
    writer = ExampleWriter(path, header)
    writer.append(stored(examples.read(0, 10)))
    writer._group["human"].resize((25, *writer._group["human"].shape[1:]))
    assert len(ExampleStore(path)) == 10
    writer = ExampleWriter(path, header)
    writer.append(stored(examples.read(10, 30)))
    np.testing.assert_array_equal(ExampleStore(path).read(0, 30).human, examples.human)


def test_a_chunk_that_is_damaged_or_lost_is_named_and_never_read_as_values(tmp_path):
    for number, damage in enumerate((lambda chunk: chunk.unlink(), lambda chunk: flip(chunk))):
        store = example_store(tmp_path / f"{number}.zarr", 20)
        damage(next(path for path in (store.path / "human" / "c").rglob("*") if path.is_file()))
        with pytest.raises(LogError, match=rf"{number}.zarr: .*generate it again"):
            store.read(0, 20)


def flip(chunk):
    raw = bytearray(chunk.read_bytes())
    raw[len(raw) // 2] ^= 4
    chunk.write_bytes(bytes(raw))


def test_what_is_no_store_of_examples_is_refused(tmp_path):
    with pytest.raises(LogError, match="there is no such folder"):
        ExampleStore(tmp_path / "none.zarr")
    (tmp_path / "empty.zarr").mkdir()
    with pytest.raises(LogError, match="no Zarr store of examples"):
        ExampleStore(tmp_path / "empty.zarr")
    with pytest.raises(LogError, match=r"written as a \.zarr folder"):
        ExampleWriter(tmp_path / "d.pickle", example_header(example_predictions(2)))
