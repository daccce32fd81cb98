import json

import numpy as np
import pytest
import xarray as xr

from ppinfer.errors import LogError
from ppinfer.goals import GoalLQR, infer_goals
from ppinfer.studies import RecordingWriter, posterior_dataset, read_log, read_recording, validate_log
from ppinfer.studies.fit import fit_study
from ppinfer.studies.goal_evidence import goal_evidence
from ppinfer.studies.scores import score_posterior
from ppsim.reaching import ReachingStudy, play
from ppsim.study import record_study, recording_path, simulate

SMALL = ReachingStudy(seed=5, participants=2, duration=6.0)


def assert_same_trials(one, other):
    for first, second in zip(one, other, strict=True):
        assert (first.trial_id, first.seed, first.segments) == (
            second.trial_id,
            second.seed,
            second.segments,
        )
        np.testing.assert_array_equal(first.position, second.position)
        np.testing.assert_array_equal(first.goal_position, second.goal_position)


def test_a_trial_depends_on_the_seed_and_its_number_only():
    backwards = [SMALL.trial(index) for index in (3, 2, 1, 0)][::-1]
    assert_same_trials(simulate(SMALL, range(4)), backwards)
    other_seed = ReachingStudy(seed=6, participants=2, duration=6.0).trial(0)
    assert not np.array_equal(other_seed.position, backwards[0].position)


def test_parallel_equals_serial():
    assert_same_trials(simulate(SMALL, range(5), workers=2), simulate(SMALL, range(5)))


def test_the_logged_seed_replays_the_trial():
    trial = SMALL.trial(3)
    replayed = play(SMALL.world(), SMALL.seats(1), seed=trial.seed, samples=60)
    np.testing.assert_array_equal(replayed.position, trial.position)


@pytest.mark.parametrize("dynamics", ["double-integrator", "single-integrator"])
def test_what_is_logged_obeys_the_dynamics(dynamics):
    study = ReachingStudy(seed=1, dynamics=dynamics, duration=8.0)
    trial = study.trial(0)
    if dynamics == "single-integrator":
        assert trial.velocity is None
        step = study.dt * trial.control[:-1]
    else:
        step = study.dt * trial.velocity[:-1] + 0.5 * study.dt**2 * trial.control[:-1]
        np.testing.assert_allclose(np.diff(trial.velocity, axis=0), study.dt * trial.control[:-1], atol=1e-12)
    np.testing.assert_allclose(np.diff(trial.position, axis=0), step, atol=1e-12)


@pytest.mark.parametrize(
    "options",
    [
        {},
        {"positions_only": True, "goals": 3},
        {"noise": 0.05, "dropouts": 0.1, "outliers": 0.01, "stay": 0.98},
        {"dropouts": 0.1},
        {"dynamics": "single-integrator", "human": "near-goal", "robot": "random-goal"},
    ],
)
def test_every_log_is_sound_and_says_what_made_it(options, tmp_path):
    study = ReachingStudy(seed=2, participants=2, duration=12.0, **options)
    record_study(study, 4, tmp_path / "log.nc")
    report = validate_log(tmp_path / "log.nc")
    assert report.ok, report.lines()
    log = read_log(tmp_path / "log.nc")
    told = json.loads(log.attrs["configuration"])
    assert told["seed"] == 2
    assert told["rationality_spread"] == study.rationality_spread
    rationality = [person["rationality"] for person in told["participant_parameters"].values()]
    np.testing.assert_array_equal(log["true_rationality"].values[:2, 0], rationality)
    assert set(log["segment_agent"].values) == {"human", "robot"}
    assert log["goal_position"].dims[0] == "sample"
    assert log["controller"].values[0, 0].startswith("lqr ")
    if study.logs_motion:
        quantity = {"double-integrator": "acceleration", "single-integrator": "velocity"}[study.dynamics]
        assert log["control"].attrs["quantity"] == quantity
    else:
        assert "control" not in log
        assert "velocity" not in log


def test_true_goals_are_where_segments_end(log_of):
    log = log_of(ReachingStudy(seed=4, duration=20.0), 6)
    start = np.cumsum(log["row_size"].values) - log["row_size"].values
    first = start[log["segment_trial"].values] + log["segment_start"].values
    stop = start[log["segment_trial"].values] + log["segment_stop"].values
    agent = [list(log["agent"].values).index(name) for name in log["segment_agent"].values]
    goal = log["goal_position"].values[first, log["true_goal"].values.astype(int)]
    human = np.array(agent) == 0
    # with stay = 1 the human gives nothing up: it is at its goal where its segment ends
    gap = np.linalg.norm(log["position"].values[stop, agent] - goal, axis=1)
    assert (gap[human] <= 0.5).all()
    assert (np.linalg.norm(log["position"].values[first, agent] - goal, axis=1) > 0.5).all()


def test_the_model_that_made_a_log_is_calibrated_and_right_on_it(log_of):
    study = ReachingStudy(seed=8, duration=20.0, rationality_spread=0.0, rationality=0.002)
    log = log_of(study, 12)
    evidence = goal_evidence(log, "human")
    model = GoalLQR(dynamics=study.dynamics, control_weight=study.control_weight, rationality=0.002)
    posterior = posterior_dataset(log, evidence, infer_goals(model, evidence).log_posterior, "human")
    scores = score_posterior(posterior, at=[0.25, 0.75]).overall
    assert scores[1].accuracy > 0.9
    assert scores[0].mean_log_posterior > -0.6


@pytest.mark.parametrize("dynamics", ["double-integrator", "single-integrator"])
def test_rationality_and_control_weight_are_recovered_from_a_log(dynamics, log_of):
    study = ReachingStudy(
        seed=3, dynamics=dynamics, control_weight=3.0, rationality=0.05, rationality_spread=0.0
    )
    log = log_of(study, 24)
    fitted = fit_study(log, GoalLQR(dynamics=dynamics), objective="likelihood", folds=0).fit.model
    assert fitted.control_weight == pytest.approx(3.0, rel=0.2)
    assert fitted.rationality == pytest.approx(0.05, rel=0.2)


def test_participants_differ_by_the_spread_and_by_nothing_without_one():
    many = ReachingStudy(participants=2000, rationality=0.1, rationality_spread=0.5).participant_rationality
    assert np.log(many).mean() == pytest.approx(np.log(0.1), abs=0.05)
    assert np.log(many).std() == pytest.approx(0.5, rel=0.05)
    alike = ReachingStudy(participants=3, rationality_spread=0.0).participant_rationality
    np.testing.assert_array_equal(alike, ReachingStudy.rationality)


def test_a_longer_study_begins_with_the_same_trials(tmp_path):
    short = record_study(SMALL, 2, tmp_path / "short.nc").log
    long = record_study(SMALL, 3, tmp_path / "long.zarr").log
    np.testing.assert_array_equal(long["position"].values[: short.sizes["sample"]], short["position"].values)


def test_the_recording_goes_once_the_log_is_written(tmp_path):
    record_study(SMALL, 2, tmp_path / "log.nc")
    assert [path.name for path in tmp_path.iterdir()] == ["log.nc"]


def test_an_interrupted_study_is_convertible_and_goes_on_where_it_stopped(tmp_path):
    def interrupt(done, total):
        if done == 2:
            raise KeyboardInterrupt

    target = tmp_path / "log.nc"
    with pytest.raises(KeyboardInterrupt):
        record_study(SMALL, 3, target, progress=interrupt)
    assert not target.exists()
    assert read_recording(recording_path(target)).sizes["trial"] == 2
    recorded = record_study(SMALL, 3, target)
    assert recorded.resumed == 2
    whole = record_study(SMALL, 3, tmp_path / "whole.nc").log
    xr.testing.assert_identical(recorded.log, whole)


@pytest.mark.parametrize("torn", [b"", b'{"crc32": "0'])
def test_a_recording_without_a_whole_trial_is_in_nobodys_way(tmp_path, torn):
    target, lone = tmp_path / "log.nc", recording_path(tmp_path / "log.nc")
    RecordingWriter(lone, SMALL.header()).close()
    with lone.open("ab") as file:
        file.write(torn)
    recorded = record_study(SMALL, 2, target, resume=False)
    assert recorded.resumed == 0
    assert recorded.log.sizes["trial"] == 2


@pytest.mark.parametrize("left", [False, True])
def test_a_study_that_fails_in_its_first_trial_leaves_no_recording(tmp_path, monkeypatch, left):
    lone = recording_path(tmp_path / "log.nc")

    def fail(study, index):
        # as a disk that is full does: a part of the line is there
        with lone.open("ab") as file:
            file.write(b'{"crc32": "0')
        raise OSError("no space left")

    monkeypatch.setattr(ReachingStudy, "trial", fail)
    if left:
        RecordingWriter(lone, SMALL.header()).close()
    with pytest.raises(OSError, match="no space"):
        record_study(SMALL, 2, tmp_path / "log.nc", resume=False)
    assert list(tmp_path.iterdir()) == []


def test_the_recording_of_another_study_is_not_overwritten(tmp_path):
    target = tmp_path / "log.nc"
    with RecordingWriter(recording_path(target), ReachingStudy(seed=99).header()) as recording:
        recording.append(ReachingStudy(seed=99, duration=2.0).trial(0))
    before = recording_path(target).read_bytes()
    with pytest.raises(LogError, match="another study"):
        record_study(SMALL, 2, target)
    assert recording_path(target).read_bytes() == before


@pytest.mark.parametrize(
    ("options", "told"),
    [
        ({"duration": 0.1}, "has 1 samples"),
        ({"dt": 0.0}, "dt must be positive"),
        ({"dynamics": "rocket"}, "dynamics must be one of"),
        ({"human": "wise"}, "human must be one of near"),
        ({"participants": 0}, "participants must be at least 1"),
        ({"seed": -1}, "seed must be at least 0"),
        ({"goals": 1}, "too few for 2 agents"),
        ({"rationality": float("nan")}, "rationality must be positive"),
        ({"stay": 2.0}, "stay must lie in"),
        ({"dropouts": -0.1}, "dropouts must lie in"),
        ({"noise": float("inf")}, "noise must be finite"),
    ],
)
def test_studies_that_cannot_be_simulated_are_refused(options, told):
    with pytest.raises(ValueError, match=told):
        ReachingStudy(**options)
