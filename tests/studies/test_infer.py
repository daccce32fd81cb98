"""From a log to a posterior: the numbers of the models, whatever the blocks."""

import json
import shutil
from dataclasses import replace

import numpy as np
import pytest
import xarray as xr
from numpy.testing import assert_allclose

from ppinfer.errors import ImpossibleEvidenceError, LogError
from ppinfer.goals import GoalKalman, GoalLQR, GoalModel, NearestGoal, infer_goals
from ppinfer.studies import (
    build_log,
    file_sha256,
    infer_log,
    read_log,
    score_posterior,
    write_log,
    write_posterior,
)
from ppinfer.studies.goal_evidence import goal_evidence
from ppinfer.studies.infer import infer_posterior
from ppinfer.studies.posterior import open_posterior
from ppinfer.testing import example_log


@pytest.fixture
def log_path(tmp_path):
    write_log(example_log(participants=4, trials=5), tmp_path / "log.nc")
    return tmp_path / "log.nc"


def changing_goals():
    """One trial of eight samples whose second goal vanishes at sample 3 and whose goals move at sample 5."""
    goals = np.zeros((8, 2, 2))
    goals[:, 0], goals[:, 1] = [1.0, 0.0], [0.0, 1.0]
    goals[3:5, 1] = np.nan
    goals[5:] = [[-1.0, 0.0], [0.0, -1.0]]
    position = np.cumsum(np.full((8, 2), 0.05), axis=0)
    return build_log(
        agents=["robot", "human"],
        goals=["cup", "pan"],
        row_size=[8],
        trial_id=["t1"],
        time=np.arange(8) * 0.1,
        position=np.stack([position[::-1], position], axis=1),
        goal_position=goals,
        segment_trial=[0, 0, 0],
        segment_agent=["human", "robot", "human"],
        segment_start=[0, 1, 5],
        segment_stop=[3, 7, 8],
        true_goal=["cup", "cup", "pan"],
    )


def test_the_file_holds_what_the_model_says(log_path, tmp_path):
    model = GoalLQR(control_weight=5.0, rationality=0.02)
    done = infer_posterior(log_path, tmp_path / "post.nc", model, seed=11)
    log = xr.load_dataset(log_path)
    expected = infer_goals(model, goal_evidence(log, "human")).log_posterior
    with open_posterior(tmp_path / "post.nc", load=True, verify=True) as posterior:
        assert (posterior["log_posterior"].values == expected).all()
        assert posterior.attrs["hypothesis"] == "goal"
        assert posterior.attrs["seed"] == 11
        assert posterior.attrs["input_sha256"] == file_sha256(log_path)
        configuration = json.loads(posterior.attrs["configuration"])
        assert configuration["parameters"]["control_weight"] == 5.0
        assert posterior["true_goal"].values.tolist() == log["true_goal"].values.tolist()
        assert posterior["participant"].values.tolist() == log["participant"].values.tolist()
    assert (done.trials, done.samples, done.segments) == (20, 400, 20)


@pytest.mark.parametrize(
    "model", [GoalLQR(stay=0.9), GoalKalman(), NearestGoal()], ids=lambda model: model.name
)
@pytest.mark.parametrize("mode", ["filter", "smooth"])
def test_memory_and_file_give_the_same(log_path, tmp_path, model, mode):
    infer_posterior(log_path, tmp_path / "post.nc", model, mode=mode)
    written = xr.load_dataset(tmp_path / "post.nc")
    ours = infer_log(read_log(log_path), model, mode=mode)
    assert (ours["log_posterior"].values == written["log_posterior"].values).all()
    assert ours.attrs["configuration"] == written.attrs["configuration"]
    assert set(ours.variables) == set(written.variables)


@pytest.mark.parametrize(
    "model", [GoalLQR(stay=0.9), GoalKalman(), NearestGoal()], ids=lambda model: model.name
)
@pytest.mark.parametrize("mode", ["filter", "smooth"])
def test_blocks_change_nothing(log_path, tmp_path, model, mode):
    infer_posterior(log_path, tmp_path / "one.nc", model, mode=mode)
    infer_posterior(log_path, tmp_path / "many.nc", model, mode=mode, block_samples=50)
    one, many = (xr.load_dataset(tmp_path / name) for name in ("one.nc", "many.nc"))
    xr.testing.assert_identical(one, many)


def test_the_same_run_writes_the_same_content(log_path, tmp_path):
    for name in ("a.nc", "b.nc"):
        infer_posterior(log_path, tmp_path / name, GoalLQR())
    a, b = (xr.load_dataset(tmp_path / name) for name in ("a.nc", "b.nc"))
    xr.testing.assert_identical(a, b)
    assert a.attrs["content_sha256"] == b.attrs["content_sha256"]


def test_rows_begin_where_the_goals_change():
    evidence = goal_evidence(changing_goals(), "human")
    assert evidence.row_size.tolist() == [3, 2, 3]
    assert evidence.goal_present.tolist() == [[True, True], [True, False], [True, True]]
    assert evidence.row_name(1) == "trial 't1' from its sample 3"


def test_rows_begin_at_segments_where_asked():
    robot = goal_evidence(changing_goals(), "robot", restart="segments")
    assert robot.row_size.tolist() == [1, 2, 2, 2, 1]
    carried = goal_evidence(changing_goals(), "human", carry=True)
    assert carried.continues.tolist() == [False, True, True]


def test_a_belief_starts_anew_or_is_carried_over(tmp_path):
    write_log(changing_goals(), tmp_path / "log.nc")
    for carry in (False, True):
        infer_posterior(tmp_path / "log.nc", tmp_path / f"{carry}.nc", NearestGoal(), carry=carry)
        infer_posterior(
            tmp_path / "log.nc", tmp_path / f"lqr-{carry}.nc", GoalLQR(rationality=1.0), carry=carry
        )
    anew = xr.load_dataset(tmp_path / "lqr-False.nc")["log_posterior"].values
    carried = xr.load_dataset(tmp_path / "lqr-True.nc")["log_posterior"].values
    assert_allclose(anew[[0, 5]], np.log(0.5), atol=1e-12)
    assert anew[4].tolist() == [0.0, -np.inf]
    assert carried[4].tolist() == [0.0, -np.inf]
    # the pan is there again, and may be pursued whatever was believed while it was not
    assert_allclose(carried[5], np.log(0.5), atol=1e-12)
    # a memoryless model has nothing to carry
    xr.testing.assert_equal(
        xr.load_dataset(tmp_path / "False.nc")["log_posterior"],
        xr.load_dataset(tmp_path / "True.nc")["log_posterior"],
    )


def test_any_agent_can_be_inferred_and_keeps_its_own_segments(tmp_path):
    write_log(changing_goals(), tmp_path / "log.nc")
    infer_posterior(tmp_path / "log.nc", tmp_path / "robot.nc", NearestGoal(), agent="robot")
    robot = xr.load_dataset(tmp_path / "robot.nc")
    assert robot["segment_start"].values.tolist() == [1]
    assert_allclose(robot["position"].values, changing_goals()["position"].values[:, 0])
    with pytest.raises(LogError, match="no agent 'dog'; it has 'robot', 'human'"):
        infer_posterior(tmp_path / "log.nc", tmp_path / "dog.nc", NearestGoal(), agent="dog")


def test_dropouts_and_outliers_are_counted(tmp_path):
    log = example_log(participants=1, trials=2, samples=30, positions_only=True)
    position = log["position"].values.copy()
    position[5] = np.nan
    position[20] += 500.0
    observed = np.ones(position.shape[:2], dtype=np.int8)
    observed[5] = 0
    log = log.assign(position=(log["position"].dims, position), observed=(("sample", "agent"), observed))
    write_log(log, tmp_path / "log.nc")
    done = infer_posterior(
        tmp_path / "log.nc", tmp_path / "post.nc", GoalKalman(dynamics="single-integrator")
    )
    assert (done.samples_missing, done.outliers_gated) == (1, 1)
    posterior = xr.load_dataset(tmp_path / "post.nc")
    assert np.flatnonzero(posterior["outlier"].values).tolist() == [20]
    assert posterior.attrs["outliers_gated"] == 1
    assert "Kalman" in posterior.attrs["state_source"]


class Contradiction(GoalModel):
    """Rules out every goal at the fourth sample of a log."""

    def log_likelihood(self, evidence):
        values = np.zeros((evidence.samples, len(evidence.goal_labels)))
        values[3] = -np.inf
        return evidence.likelihood_factor(values)

    def simulate(self, design, rng):
        raise NotImplementedError


def test_nothing_is_written_on_failure(log_path, tmp_path):
    with pytest.raises(ImpossibleEvidenceError, match=r"trial '0', sample 3"):
        infer_posterior(log_path, tmp_path / "post.nc", Contradiction())
    no_goals = xr.load_dataset(log_path).drop_dims("goal").drop_dims("segment")
    write_log(no_goals, tmp_path / "nothing.nc")
    with pytest.raises(LogError, match="holds no goals"):
        infer_posterior(tmp_path / "nothing.nc", tmp_path / "post.nc", GoalLQR())
    broken = xr.load_dataset(log_path)
    broken["time"].values[3] = broken["time"].values[2]
    write_log(broken, tmp_path / "broken.nc", validate=False)
    with pytest.raises(LogError, match=r"trial '0': sample 3: column 'time'.*run 'ppinfer validate"):
        infer_posterior(tmp_path / "broken.nc", tmp_path / "post.nc", GoalLQR())
    assert not list(tmp_path.glob("*post*"))


def test_a_fault_in_a_later_block_is_placed_by_trial_and_sample(log_path, tmp_path):
    broken = xr.load_dataset(log_path)
    broken["segment_stop"].values[7] = 99
    write_log(broken, tmp_path / "broken.nc", validate=False)
    with pytest.raises(LogError, match="trial '7': sample 0: column 'segment_start': its segment") as caught:
        infer_posterior(tmp_path / "broken.nc", tmp_path / "post.nc", GoalLQR(), block_samples=50)
    assert "this first fault" in str(caught.value)


@pytest.mark.parametrize("moving", [False, True])
@pytest.mark.parametrize("with_segments", [False, True])
@pytest.mark.parametrize("model", [GoalLQR(), GoalKalman()], ids=lambda model: model.name)
def test_a_posterior_in_memory_is_written_read_and_scored_like_the_file(
    tmp_path, moving, with_segments, model
):
    log = changing_goals() if moving else example_log(participants=2, trials=3)
    if not with_segments:
        log = log.drop_dims("segment")
    write_log(log, tmp_path / "log.nc")
    infer_posterior(tmp_path / "log.nc", tmp_path / "file.nc", model)
    write_posterior(infer_log(log, model), tmp_path / "memory.nc")
    with (
        open_posterior(tmp_path / "file.nc", load=True, verify=True) as file,
        open_posterior(tmp_path / "memory.nc", load=True, verify=True) as memory,
    ):
        xr.testing.assert_equal(file, memory)
        told_by_the_file = {"input", "input_sha256", "seed", "title", "content_sha256"}
        assert {key: file.attrs[key] for key in file.attrs.keys() - told_by_the_file} == {
            key: memory.attrs[key] for key in memory.attrs.keys() - {"content_sha256"}
        }
        if with_segments:
            assert repr(score_posterior(file)) == repr(score_posterior(memory))  # NaN is not NaN


def test_velocities_that_were_not_logged_are_never_read(tmp_path):
    log = example_log(participants=1, trials=2, positions_only=True)
    wrong = log.assign(
        velocity=(("sample", "agent", "space"), np.full(log["position"].shape, np.nan)),
        has_velocity=("agent", np.zeros(1, dtype=np.int8)),
    )
    evidence = goal_evidence(wrong, "human")
    assert evidence.velocity is None


def test_zarr_gives_the_same_posterior(log_path, tmp_path):
    write_log(xr.load_dataset(log_path), tmp_path / "log.zarr")
    for source in ("log.nc", "log.zarr"):
        infer_posterior(tmp_path / source, tmp_path / f"{source}.post.nc", GoalLQR())
    nc, zarr = (xr.load_dataset(tmp_path / f"{source}.post.nc") for source in ("log.nc", "log.zarr"))
    assert (nc["log_posterior"].values == zarr["log_posterior"].values).all()
    shutil.rmtree(tmp_path / "log.zarr")


def test_the_time_step_is_that_of_the_log(tmp_path):
    log = example_log(participants=1, trials=3, positions_only=True)
    slow = log.assign(time=("sample", log["time"].values * 4))
    write_log(slow, tmp_path / "slow.nc")
    infer_posterior(tmp_path / "slow.nc", tmp_path / "post.nc", GoalLQR())
    configuration = json.loads(xr.load_dataset(tmp_path / "post.nc").attrs["configuration"])
    assert_allclose(configuration["time_step"], 0.4)
    evidence = goal_evidence(slow, "human")
    assert replace(evidence, time_step=0.5).dt == 0.5
