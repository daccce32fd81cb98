from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose

from ppinfer.errors import SafetyError
from ppinfer.safety import (
    CandidateController,
    LinearAgent,
    Mover,
    SafeController,
    StaticObstacle,
    choose_safe_plan,
    find_safe_state,
    long_term_safe_probability,
    plan_safe_probability,
)

from .literal import safe_control
from .worlds import at, double_integrator, heading, oncoming, single_integrator


def test_while_the_pursuit_is_safe_it_is_what_the_controller_does():
    robot = double_integrator()
    did = SafeController(robot).control(at(-5, 3), at(-5, 0), [oncoming(0.1)], np.random.default_rng(0))
    if did.safe_state is None:
        assert_allclose(did.control, safe_control(robot, at(-5, 3), at(-5, 0), None, 50.0, 0.5))
    away = SafeController(robot).control(at(-5, 0), at(-5, 9), [oncoming(0.1)], np.random.default_rng(0))
    assert away.safe_state is None
    assert not away.flagged
    assert_allclose(away.control, safe_control(robot, at(-5, 0), at(-5, 9), None, 50.0, 0.5))


def test_where_it_is_not_the_control_is_that_of_the_literal_algorithm_towards_the_safe_state():
    robot, human = double_integrator(), oncoming(0.1, (1.0, 0.0))
    controller = SafeController(robot, stronger=(1.0,))
    did = controller.control(at(-1, 0), at(5, 0), [human], np.random.default_rng(0))
    assert did.safe_state is not None
    assert did.safe_state.found
    assert_allclose(did.control, safe_control(robot, at(-1, 0), at(5, 0), did.safe_state.state, 50.0, 0.5))
    # the plan is what the control begins, and the certificate is of the plan
    assert_allclose(did.plan[0], [-1.0, 0.0])
    assert_allclose(did.plan[1], robot.position(robot.A @ at(-1, 0) + robot.B @ did.control))
    again = plan_safe_probability(did.plan[None], [human], rollouts=20_000, rng=np.random.default_rng(1))[0]
    assert abs(again.estimate - did.certificate.estimate) < 0.05


def test_a_safe_state_says_of_itself_what_a_fresh_look_confirms():
    robot, human = double_integrator(), oncoming(0.3)
    found = find_safe_state(robot, at(-2, 0), at(5, 0), [human], rng=np.random.default_rng(0))
    assert found.found
    assert_allclose(found.state[[1, 3]], 0.0)
    assert np.linalg.norm(found.state[[0, 2]] - [-2.0, 0.0]) <= found.radius
    fresh = long_term_safe_probability(
        robot, found.state, at(5, 0), [human], rollouts=20_000, rng=np.random.default_rng(1)
    )
    assert fresh.estimate >= 0.95
    # a robot that is not there yet is not as safe
    here = long_term_safe_probability(robot, at(-2, 0), at(5, 0), [human], rng=np.random.default_rng(2))
    assert here.safe < found.certificate.safe


def test_where_there_is_no_safe_state_the_ball_grows_to_its_limit_and_the_best_seen_is_returned():
    robot = single_integrator()
    # somebody all around who comes to where the robot wants to stay
    ring = [
        heading(single_integrator(0.05), 3 * np.array([np.cos(a), np.sin(a)]), [[0.0, 0.0]], [1.0])
        for a in np.linspace(0, 2 * np.pi, 6, endpoint=False)
    ]
    given = {"samples": 8, "rollouts": 50, "radius_limit": 3.0}
    found = find_safe_state(robot, np.zeros(2), np.zeros(2), ring, rng=np.random.default_rng(0), **given)
    assert not found.found
    assert found.looked_at == 24
    did = SafeController(robot, samples=8, rollouts=50).control(
        np.zeros(2), np.zeros(2), ring, np.random.default_rng(0)
    )
    assert did.flagged
    assert not did.safe_state.found


def test_the_search_grows_only_where_it_has_to():
    robot, rng = double_integrator(), np.random.default_rng(0)
    near = find_safe_state(robot, at(0, 0), at(0, 1), [oncoming(0.05, (0.0, 1.0))], rng=rng)
    assert near.radius == 1.0
    human = heading(single_integrator(0.02), [0.5, 0.0], [[0.5, 0.0]], [1.0])
    far = find_safe_state(robot, at(0.5, 0), at(-5, 0), [human], rng=rng, radius=0.5, radius_step=0.5)
    assert far.found
    assert far.radius > 0.5


@pytest.mark.parametrize("limit", [None, 8.0])
def test_a_control_within_its_limit_is_followed_by_what_the_plan_says(limit):
    robot = double_integrator(limit=limit)
    did = SafeController(robot).control(
        at(-1, 0), at(5, 0), [oncoming(0.1, (1.0, 0.0))], np.random.default_rng(0)
    )
    if limit is not None:
        assert np.linalg.norm(did.control) <= limit + 1e-9
    assert_allclose(did.plan[1], robot.position(robot.A @ at(-1, 0) + robot.B @ did.control))


def test_a_robot_with_noise_is_certified_with_its_noise():
    exact, shaky = double_integrator(), double_integrator(0.5)
    human = heading(double_integrator(0.05), at(5, 1.3), [at(-5, 1.3)], [1.0])
    given = {"rng": np.random.default_rng(0)}
    sure = long_term_safe_probability(exact, at(-5, 0), at(5, 0), [human], **given)
    unsure = long_term_safe_probability(shaky, at(-5, 0), at(5, 0), [human], **given)
    assert unsure.safe < sure.safe
    # a plan that it follows is as uncertain as the pursuit that it is
    from ppinfer.safety import nominal_motion

    plan = exact.position(nominal_motion(exact, at(-5, 0)[None], at(5, 0)[None], 50)[0])
    followed = plan_safe_probability(plan, [human], robot=shaky, rollouts=20_000, **given)[0]
    rolled = long_term_safe_probability(shaky, at(-5, 0), at(5, 0), [human], rollouts=20_000, **given)
    assert abs(followed.estimate - rolled.estimate) < 0.02
    found = find_safe_state(shaky, at(-2, 0), at(5, 0), [human], rollouts=200, eps=0.2, **given)
    assert found.certificate.rollouts == 200
    limited = double_integrator(0.5, limit=9.0)
    found = find_safe_state(
        limited, at(-2, 0), at(5, 0), [human], rollouts=50, samples=4, radius_limit=1.0, **given
    )
    assert found.looked_at == 4


def test_candidates_are_chosen_by_their_probability_not_by_the_printed_tube():
    robot, human = double_integrator(), oncoming(0.3, (1.0, 0.0))
    controller = CandidateController(robot)
    did = controller.control(at(-5, 0), at(5, 0), [human], np.random.default_rng(3))
    assert not did.flagged
    assert did.certificate.is_safe(among=2)
    made = controller.candidates(at(-5, 0), at(5, 0), [human], np.random.default_rng(3))
    which = int(np.argmin(np.abs(made.positions - did.plan).max(axis=(1, 2))))
    assert_allclose(made.positions[which], did.plan)
    assert_allclose(made.controls[which, 0], did.control)
    choice = choose_safe_plan(
        made.positions, controller.costs(made, at(5, 0)), [human], rng=np.random.default_rng(4)
    )
    costs = controller.costs(made, at(5, 0))
    # of what is cheaper, the screening let pass at most the one that a fresh look then refused
    assert choice.screened.is_safe(among=1)[costs < costs[choice.plan]].sum() <= 1
    assert_allclose(
        costs[0],
        10 * ((made.states[0] - at(5, 0)) ** 2).sum() + (made.controls[0] ** 2).sum(),
    )


def test_both_controllers_keep_clear_of_what_stands_still():
    static = (StaticObstacle([0.0, 0.2], 1.0),)
    robot, rng = double_integrator(), np.random.default_rng(0)
    far = heading(double_integrator(), at(50, 50), [at(50, 50)], [1.0])
    for controller in (SafeController(robot, static=static), CandidateController(robot, static=static)):
        x, nearest = at(-3, 0), np.inf
        for _ in range(45):
            did = controller.control(x, at(4, 0), [far], rng)
            x = robot.A @ x + robot.B @ did.control
            nearest = min(nearest, float(np.linalg.norm(x[[0, 2]] - [0.0, 0.2])))
        assert nearest >= 1.0
        assert np.linalg.norm(x[[0, 2]] - [4.0, 0.0]) < 0.5


def test_controllers_that_cannot_be_are_refused():
    wide = LinearAgent(np.eye(4), np.ones((4, 3)), np.ones((3, 4)), (0, 2))
    for controller in (SafeController, CandidateController):
        with pytest.raises(SafetyError, match="one control for each dimension"):
            controller(wide)
    with pytest.raises(SafetyError, match="strength and the factors"):
        SafeController(double_integrator(), stronger=())
    with pytest.raises(SafetyError, match="leave out the limit"):
        SafeController(double_integrator(0.1, limit=3.0))
    with pytest.raises(SafetyError, match="0 < radius <= radius_limit"):
        find_safe_state(
            double_integrator(), at(0, 0), at(1, 0), [oncoming()], radius=9.0, rng=np.random.default_rng(0)
        )


def test_agents_and_movers_that_cannot_be_are_refused():
    eye = np.eye(2)
    for wrong, told in [
        ({"A": np.eye(3)}, "A must be finite and of shape"),
        ({"gain": np.full((2, 2), np.nan)}, "gain must be finite"),
        ({"position_index": (0, 2)}, "does not fit a state of 2"),
        ({"noise": np.array([[1.0, 2.0], [2.0, 1.0]])}, "must be a covariance"),
        ({"control_limit": 0.0}, "control_limit must be positive"),
    ]:
        with pytest.raises(SafetyError, match=told):
            LinearAgent(**({"A": eye, "B": eye, "gain": eye, "position_index": (0, 1)} | wrong))
    agent = LinearAgent(eye, eye, eye, (0, 1))
    with pytest.raises(SafetyError, match="must be a distribution over 2 targets"):
        Mover(agent, np.zeros(2), np.zeros((2, 2)), np.array([0.5, 0.6]))
    with pytest.raises(SafetyError, match="targets must be finite and of shape"):
        Mover(agent, np.zeros(2), np.zeros((2, 3)), np.array([0.5, 0.5]))
    with pytest.raises(SafetyError, match="distance must be finite"):
        StaticObstacle([0.0, 0.0], -1.0)
    with pytest.raises(SafetyError, match="position must be finite"):
        StaticObstacle([0.0, np.nan], 1.0)
