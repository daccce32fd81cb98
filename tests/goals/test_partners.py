"""Evidence that holds the other agents' motion."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_array_equal

from ppinfer.errors import LogError
from ppinfer.goals import GoalCoupled, GoalEvidence, GoalLQR, PartnerMotion, infer_goals


def evidence(**changed):
    """Return two rows of a person beside a robot."""
    values = {
        "time": np.array([0.0, 0.1, 0.2, 0.0, 0.1]),
        "position": np.arange(10.0).reshape(5, 2),
        "goals": np.ones((2, 2, 2)) * np.array([0.0, 1.0])[:, None, None],
        "row_size": np.array([3, 2]),
        "goal_labels": ("cup", "bowl"),
        "partners": (
            PartnerMotion("robot", -np.arange(10.0).reshape(5, 2), velocity=np.ones((5, 2))),
            PartnerMotion("cat", np.full((5, 2), np.nan), observed=np.zeros(5, dtype=bool)),
        ),
        "agent": "human",
    }
    return GoalEvidence(**{**values, **changed})


def test_partners_are_taken_along_with_rows():
    taken = evidence().take_rows(np.array([1]))
    assert_array_equal(taken.partners[0].position, -np.arange(10.0).reshape(5, 2)[3:])
    assert_array_equal(taken.partners[0].velocity, np.ones((2, 2)))
    assert_array_equal(taken.partners[1].observed, [False, False])


def test_the_beginnings_of_rows_are_what_was_known_then():
    early = evidence().take_beginnings(np.array([2, 1]))
    assert_array_equal(early.time, [0.0, 0.1, 0.0])
    assert_array_equal(early.partners[0].position, -np.arange(10.0).reshape(5, 2)[[0, 1, 3]])


def test_a_partner_has_evidence_of_its_own_with_the_agent_as_partner():
    robot = evidence().of_partner("robot")
    assert robot.agent == "robot"
    assert [partner.name for partner in robot.partners] == ["human", "cat"]
    assert_array_equal(robot.position, -np.arange(10.0).reshape(5, 2))
    assert_array_equal(robot.velocity, np.ones((5, 2)))
    back = robot.of_partner("human")
    assert_array_equal(back.position, evidence().position)
    assert infer_goals(GoalLQR(), robot).distribution.random == ("goal",)


def test_a_partner_that_was_not_seen_is_one_that_was_not_seen():
    assert not evidence().of_partner("cat").seen.any()


def test_partners_that_are_not_there_are_named():
    with pytest.raises(LogError, match=r"no partner 'dog' beside 'human'; there are .*'robot', 'cat'"):
        evidence().of_partner("dog")
    with pytest.raises(LogError, match="say which"):
        evidence().of_partner()


@pytest.mark.parametrize(
    ("partner", "message"),
    [
        (lambda: PartnerMotion("robot", np.zeros((4, 2))), r"shape \(4, 2\); expected \(5, 2\)"),
        (lambda: PartnerMotion("robot", np.full((5, 2), np.nan)), "not finite at sample 0"),
        (lambda: PartnerMotion("robot", np.zeros((5, 2)), velocity=np.zeros((5, 1))), "velocity has shape"),
        (lambda: PartnerMotion("robot", np.zeros((5, 2)), np.ones(4, dtype=bool)), "observed has shape"),
    ],
)
def test_partners_that_do_not_fit_are_refused(partner, message):
    with pytest.raises(LogError, match=message):
        evidence(partners=(partner(),))


def test_a_velocity_that_is_not_finite_matters_to_models_that_look_at_it_only():
    velocity = np.ones((5, 2))
    velocity[3] = np.nan
    beside = evidence(partners=(PartnerMotion("robot", np.zeros((5, 2)), velocity=velocity),))
    plain = infer_goals(GoalLQR(), evidence()).log_posterior
    assert_array_equal(infer_goals(GoalLQR(), beside).log_posterior, plain)
    with pytest.raises(LogError, match=r"partner 'robot': velocity is not finite at sample 3; mark dropouts"):
        infer_goals(GoalCoupled(), beside)
