import json
from dataclasses import replace

import h5py
import numpy as np
import pytest
import xarray as xr
from hypothesis import given, settings
from hypothesis import strategies as st

from ppinfer.coordination import LiteralPersonality, Personality, PredictivePersonality
from ppinfer.errors import ImpossibleEvidenceError, LogError, ModelError
from ppinfer.studies import (
    infer_log_personality,
    infer_personalities,
    log_of_trials,
    open_posterior,
    play_history,
    read_theta_posterior,
    select_trials,
    validate_file,
    validate_log,
    write_log,
    write_theta_posterior,
)
from ppinfer.studies.personality_inference import live_difference
from ppinfer.studies.personality_models import make_personality, personality_of_text, personality_text
from ppinfer.testing.example_plays import example_planned_log, planned_study
from ppinfer.testing.log_strategies import studies

from .logs import plain

LOG = example_planned_log(trials=6, replans=5, robots=("bayes", "bayes-literal", "norm"))


@pytest.fixture(scope="module")
def written(tmp_path_factory):
    """Return a log and its posterior on disk."""
    folder = tmp_path_factory.mktemp("theta")
    write_log(LOG, folder / "log.nc")
    infer_personalities(folder / "log.nc", folder / "post.nc", seed=3)
    return folder


def test_offline_equals_live_with_the_model_that_each_trial_was_played_with():
    posterior = infer_log_personality(LOG)
    applied = [json.loads(text)["model"] for text in posterior["model"].values]
    assert applied == ["personality", "personality-literal", "personality"] * 2
    compared, difference = live_difference(posterior)
    assert compared == 4 * 5
    assert difference < 1e-10
    assert posterior["theta"].values.tolist() == ["human", "robot"]


def test_a_posterior_file_is_what_memory_gives_in_blocks_of_any_size(written, tmp_path):
    whole = infer_log_personality(LOG)
    told = []
    done = infer_personalities(
        written / "log.nc", tmp_path / "post.nc", block_numbers=1, progress=lambda *done: told.append(done)
    )
    assert told == [(trials, 6) for trials in range(1, 7)]
    for path in (written / "post.nc", tmp_path / "post.nc"):
        back = read_theta_posterior(path)
        assert plain(back).drop_attrs(deep=False).identical(plain(whole).drop_attrs(deep=False))
    assert (done.agent, done.trials, done.replans, done.live_replans) == ("robot", 6, 30, 20)
    assert sum(done.models.values()) == 6
    assert [item.name for item in tmp_path.iterdir()] == ["post.nc"]


def test_a_posterior_tells_its_trials_and_how_it_was_made(written):
    posterior = read_theta_posterior(written / "post.nc")
    for name in ("trial_id", "participant", "controller", "scene", "plan_sets", "outcome", "live_model"):
        np.testing.assert_array_equal(posterior[name].values, LOG[name].values)
    mine = LOG["replan_agent"].values == "robot"
    for name in ("replan_time", "replan_sample", "live_log_posterior"):
        np.testing.assert_array_equal(posterior[name].values, LOG[name].values[mine])
    assert posterior["replan_row_size"].values.tolist() == [5] * 6
    expected = {"hypothesis": "theta", "agent": "robot", "seed": 3, "input": "log.nc", "variant": "as-logged"}
    assert {name: posterior.attrs[name] for name in expected} == expected
    assert len(posterior.attrs["input_sha256"]) == 64


@pytest.mark.parametrize(
    "model", [Personality(stay=0.7), LiteralPersonality(rationality=2.0), PredictivePersonality()]
)
def test_one_model_may_be_chosen_for_all_trials(model):
    posterior = infer_log_personality(LOG, model)
    assert set(posterior["model"].values) == {personality_text(model)}
    assert personality_of_text(personality_text(model)) == model
    assert posterior.attrs["variant"] == model.name


def test_beliefs_are_those_of_the_agent_asked_for():
    posterior = infer_log_personality(LOG, agent="human")
    assert set(posterior["replan_agent"].values) == {"human"}
    assert live_difference(posterior) == (0, None)
    with pytest.raises(LogError, match="no replan is of 'ghost'; those that replanned: 'human', 'robot'"):
        infer_log_personality(LOG, agent="ghost")


def test_classes_that_only_some_models_have_are_impossible_in_the_others():
    trials, options = planned_study(trials=2, replans=3)
    fair = personality_text(Personality(fair_within=1.0))
    variables = trials[1].variables | {"live_model": ((), fair)}
    # who has no belief can be inferred in any way
    bare = [replace(one, live_log_posterior=None) for one in trials[1].replans]
    log = log_of_trials([trials[0], replace(trials[1], variables=variables, replans=bare)], **options)
    posterior = infer_log_personality(log)
    assert posterior["theta"].values.tolist() == ["human", "robot", "fair"]
    assert np.isneginf(posterior["log_posterior"].values[:3, 2]).all()
    assert np.isfinite(posterior["log_posterior"].values[3:]).all()
    assert live_difference(posterior)[1] < 1e-10


def test_any_label_that_was_believed_in_and_is_not_inferred_is_told():
    belief = np.log([0.2, 0.3, 0.5])
    trials, options = planned_study(trials=1, replans=2)
    options = options | {"theta": ("human", "robot", "shy", "fair")}
    replans = [
        replace(one, live_log_posterior=belief, theta=("human", "robot", "fair")) for one in trials[0].replans
    ]
    log = log_of_trials([replace(trials[0], replans=replans)], **options)
    with pytest.raises(LogError, match="beliefs were held over theta"):
        infer_log_personality(log, Personality())


def test_trials_without_replans_of_the_viewer_stay_in_the_posterior():
    trials, options = planned_study(trials=3, replans=2)
    alone = [one for one in trials[1].replans if one.agent == "human"]
    log = log_of_trials(
        [trials[0], replace(trials[1], replans=alone), replace(trials[2], replans=())], **options
    )
    posterior = infer_log_personality(log)
    assert posterior["replan_row_size"].values.tolist() == [2, 0, 0]
    assert posterior.sizes["trial"] == 3


def test_a_log_that_does_not_say_who_moved_the_agents_is_inferred_like_any_other(tmp_path):
    log = example_planned_log(trials=2, replans=3)
    write_log(log.drop_vars(["controller", "instruction"], errors="ignore"), tmp_path / "log.nc")
    infer_personalities(tmp_path / "log.nc", tmp_path / "post.nc")
    posterior = read_theta_posterior(tmp_path / "post.nc")
    assert "controller" not in posterior
    assert posterior["agent"].values.tolist() == log["agent"].values.tolist()


def test_what_a_log_does_not_have_is_told_with_what_to_do(tmp_path):
    with pytest.raises(LogError, match=r"holds no replans .* --model goal-lqr"):
        infer_log_personality(
            LOG.drop_dims(["replan", "plan", "waypoint", "profile"]).drop_vars("replan_row_size")
        )
    with pytest.raises(LogError, match="has replans but no cost"):
        infer_log_personality(LOG.drop_vars("cost"))
    unknown = LOG.copy(deep=True)
    unknown["live_model"].values[2] = '{"model": "crystal-ball"}'
    with pytest.raises(
        LogError, match=r"trial 'scene-2': live_model: unknown model 'crystal-ball'.*--variant"
    ):
        infer_log_personality(unknown)
    write_log(LOG.assign(cost=-LOG.cost), tmp_path / "log.nc", validate=False)
    with pytest.raises(LogError, match="inference stopped at this first fault"):
        infer_personalities(tmp_path / "log.nc", tmp_path / "post.nc")
    assert not (tmp_path / "post.nc").exists()


def test_samples_at_uneven_steps_are_refused_by_trial():
    log = LOG.copy(deep=True)
    log["time"].values[50:82] += 0.05
    with pytest.raises(LogError, match=r"trial 'scene-1': sample 9 comes 0\.15 s after"):
        play_history(log)


def test_an_agent_without_plans_is_told_by_trial():
    trials, options = planned_study(trials=2, replans=2)
    first, second, *rest = trials[1].replans
    left = replace(
        second, plans=second.plans[1:], cost=second.cost[1:, 0], contact_time=np.ones(4), decision=[0]
    )
    log = log_of_trials([trials[0], replace(trials[1], replans=[first, left, *rest])], **options)
    assert validate_log(log).ok
    with pytest.raises(LogError, match="trial 'scene-1': 'human' has no plans at a replan"):
        play_history(log)


def test_velocities_and_holds_are_taken_where_they_are_logged():
    bare = LOG.drop_vars(["velocity", "has_velocity", "held"])
    history = play_history(bare)
    assert np.isnan(history.velocity).all()
    assert not history.held.any()
    assert play_history(LOG).held.sum() == LOG["held"].values.sum() > 0


def test_evidence_that_nobody_could_have_caused_names_the_trial():
    stubborn = Personality(contamination=0.0, skip_empty=False, stay=1.0, rationality=1e5)
    log = example_planned_log(trials=6, replans=8)
    with pytest.raises(ImpossibleEvidenceError, match=r"^trial 'scene-[0-9]'"):
        infer_log_personality(log, stubborn)


@settings(max_examples=20)
@given(study=studies(), data=st.data())
def test_selected_trials_are_the_log_of_those_trials(study, data):
    trials, options = study
    chosen = data.draw(st.lists(st.integers(0, len(trials) - 1), min_size=1, unique=True))
    found = select_trials(log_of_trials(trials, **options), chosen)
    expected = log_of_trials([trials[index] for index in chosen], **options)
    for name in expected.data_vars:
        # segments keep the order of the log; a number that no chosen trial has is not in their own log
        if not name.startswith("segment_") and name != "true_goal":
            np.testing.assert_array_equal(found[name].values, expected[name].values)
    order = np.argsort(found["segment_trial"].values, kind="stable")
    assert found["segment_trial"].values[order].tolist() == expected["segment_trial"].values.tolist()
    assert found["true_goal"].values[order].tolist() == expected["true_goal"].values.tolist()
    assert validate_log(found).ok


@pytest.mark.parametrize(
    ("name", "parameters", "told"),
    [
        ("crystal-ball", {}, "unknown model 'crystal-ball' of personality"),
        ("personality", {"stays": "1"}, "no parameter 'stays': expected one of rationality"),
        ("personality", {"stay": "much"}, "stay cannot be 'much'"),
        ("personality", {"observed": "nobody"}, "observed cannot be 'nobody'"),
        ("personality", {"stay": "1.5"}, r"stay must lie in \[0, 1\]"),
    ],
)
def test_models_that_cannot_be_made_say_why(name, parameters, told):
    with pytest.raises(ModelError, match=told):
        make_personality(name, parameters)


def test_parameters_given_as_text_become_what_they_are():
    text = {"rationality": "3", "velocities": "true", "fair_within": "none", "dominance": "strict"}
    assert make_personality("personality", text) == Personality(
        rationality=3.0, velocities=True, fair_within=None, dominance="strict"
    )


@pytest.mark.parametrize("text", ["{", "[]", '{"parameters": {}}', '{"model": 3}'])
def test_text_that_describes_no_model_is_told(text):
    with pytest.raises(LogError, match="live_model"):
        personality_of_text(text)


def test_a_posterior_over_theta_is_not_taken_for_one_over_goals(written):
    with pytest.raises(LogError, match="is a posterior over theta, and one over goals is expected"):
        open_posterior(written / "post.nc")
    report = validate_file(written / "post.nc")
    assert report.ok
    assert report.sizes["replan"] == 30


@pytest.mark.parametrize(
    ("change", "told"),
    [
        (lambda post: post.drop_vars("replan_time"), "replan_time is missing"),
        (lambda post: post.assign(replan_row_size=post.replan_row_size + 1), "replan_row_size adds up to 36"),
        (lambda post: post.assign(log_posterior=post.log_posterior + 0.1), "log_posterior of replan 0"),
        (lambda post: post.assign(replan_time=post.replan_sample), "replan_time is of type int64"),
        (lambda post: post.assign_attrs(hypothesis="goal"), "is not a posterior over theta"),
        (lambda post: post.assign_attrs(ppinfer_format_version=9), "upgrade ppinfer"),
    ],
)
def test_what_is_no_posterior_over_theta_is_not_written(change, told, tmp_path):
    with pytest.raises(LogError, match=told):
        write_theta_posterior(change(infer_log_personality(LOG)), tmp_path / "post.nc")
    assert not list(tmp_path.iterdir())


@settings(max_examples=80)
@given(data=st.data())
def test_a_damaged_posterior_is_never_read_as_another(written, data):
    content = bytearray((written / "post.nc").read_bytes())
    if data.draw(st.booleans()):
        content = content[: data.draw(st.integers(0, len(content) - 1))]
    else:
        bit = data.draw(st.integers(0, 8 * len(content) - 1))
        content[bit // 8] ^= 1 << bit % 8
    (written / "damaged.nc").write_bytes(content)
    try:
        found = read_theta_posterior(written / "damaged.nc")
    except LogError:
        assert not validate_file(written / "damaged.nc").ok
        return
    # the bit lay where nothing is stored
    assert found.identical(read_theta_posterior(written / "post.nc"))


def test_an_edited_posterior_is_noticed(written, tmp_path):
    (tmp_path / "post.nc").write_bytes((written / "post.nc").read_bytes())
    with h5py.File(tmp_path / "post.nc", "r+") as file:
        file["participant"][0] = "somebody else"
    with pytest.raises(LogError, match="does not match its digest"):
        read_theta_posterior(tmp_path / "post.nc")


@pytest.mark.parametrize("name", ["nowhere/post.nc", "post.txt"])
def test_a_target_that_cannot_work_is_refused(name, tmp_path):
    with pytest.raises(LogError, match=r"make it first|ends in \.nc"):
        write_theta_posterior(infer_log_personality(LOG), tmp_path / name)


def test_a_log_is_no_posterior(written, tmp_path):
    with pytest.raises(LogError, match="is not a posterior over theta"):
        read_theta_posterior(written / "log.nc")
    with pytest.raises(LogError, match="is a folder"):
        read_theta_posterior(tmp_path)
    assert isinstance(read_theta_posterior(written / "post.nc"), xr.Dataset)
