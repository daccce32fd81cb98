"""From a log of several agents to evidence with partners, and to posteriors that look at them."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from ppinfer.errors import LogError, ModelError
from ppinfer.goals import GoalCoupled, infer_goals
from ppinfer.studies import goal_evidence, infer_log, infer_posterior, write_log
from ppinfer.studies.fit import fit_study
from ppinfer.studies.posterior import open_posterior
from ppinfer.testing import example_log

from .logs import small_log


@pytest.fixture(scope="module")
def log():
    return example_log(participants=3, trials=4, model=GoalCoupled())


def test_all_other_agents_come_along(log):
    evidence = goal_evidence(log, "human")
    assert [partner.name for partner in evidence.partners] == ["robot"]
    assert_array_equal(evidence.partners[0].position, log["position"].values[:, 1])
    assert [partner.name for partner in goal_evidence(log, "robot").partners] == ["human"]


def test_a_partner_keeps_its_own_dropouts_and_velocities():
    log = small_log()
    evidence = goal_evidence(log, "human")
    index = log["agent"].values.tolist().index("robot")
    (robot,) = evidence.partners
    if "observed" in log:
        assert_array_equal(robot.seen, log["observed"].values[:, index] == 1)
    assert (robot.velocity is None) == (goal_evidence(log, "robot").velocity is None)


def test_the_evidence_of_a_partner_is_that_of_the_log(log):
    ours, theirs = goal_evidence(log, "human").of_partner("robot"), goal_evidence(log, "robot")
    assert_array_equal(ours.position, theirs.position)
    assert_array_equal(ours.goals, theirs.goals)


def test_one_partner_may_be_chosen(log):
    three = example_log(participants=1, trials=1, model=GoalCoupled())
    assert [p.name for p in goal_evidence(three, "human", partner="robot").partners] == ["robot"]
    with pytest.raises(LogError, match="no agent 'dog'"):
        goal_evidence(three, "human", partner="dog")
    with pytest.raises(LogError, match="own partner"):
        goal_evidence(three, "human", partner="human")


def test_a_file_in_blocks_gives_what_memory_gives(log, tmp_path):
    write_log(log, tmp_path / "log.nc")
    done = infer_posterior(tmp_path / "log.nc", tmp_path / "post.nc", GoalCoupled(), block_samples=45)
    assert done.state_source == "differences of positions; partner: robot"
    with open_posterior(tmp_path / "post.nc", load=True, verify=True) as posterior:
        assert_allclose(
            posterior["log_posterior"].values,
            infer_log(log, GoalCoupled())["log_posterior"].values,
            atol=1e-12,
        )


def test_a_log_of_one_agent_is_refused_and_nothing_is_written(tmp_path):
    write_log(example_log(), tmp_path / "log.nc")
    with pytest.raises(ModelError, match="the evidence is of 'human' alone"):
        infer_posterior(tmp_path / "log.nc", tmp_path / "post.nc", GoalCoupled())
    assert not (tmp_path / "post.nc").exists()


def test_held_out_predictions_are_those_of_the_folds(log):
    held = tuple(name for name in GoalCoupled().parameters if name != "distance.weight")
    fitted = fit_study(log, GoalCoupled(), fixed=held, folds=3)
    posterior = fitted.held_out_posterior
    evidence = goal_evidence(log, "human")
    person = np.repeat(log["participant"].values.astype(str), log["row_size"].values)
    ours = posterior["log_posterior"].values
    beliefs = [infer_goals(fold.model, evidence).log_posterior for fold in fitted.folds]
    for name in np.unique(person):
        mine = person == name
        assert any(np.allclose(ours[mine], belief[mine], atol=1e-12) for belief in beliefs)
    assert posterior.attrs["held_out_folds"] == 3
