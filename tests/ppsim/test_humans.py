"""Simulated humans of the reaching game infer, choose and move as they say."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from ppinfer.goals import GoalEvidence, infer_goals
from ppsim.errors import SimulationError
from ppsim.reaching import Movement, ReachingWorld, Rules, make_human, play
from ppsim.reaching.humans import HUMANS, HumanSeat, MovingHuman, SimulatedHuman, StubbornHuman, WaitingHuman

DISTANCES = arrays(np.float64, 4, elements=st.floats(0.1, 30), unique=True)
BELIEFS = arrays(np.float64, 4, elements=st.floats(0.01, 1), unique=True).map(
    lambda weights: weights / weights.sum()
)


class Straight:
    """Heads for one goal all the time."""

    controller = "straight"

    def __init__(self, goal):
        self.goal = goal
        self.movement = Movement()

    def reset(self, rng):
        """Do nothing."""

    def act(self, seen):
        """Return the best control."""
        return self.movement.control(seen.state, seen.goals[self.goal])


def game(kind, robot, *, seed=4, samples=25, **options):
    """Play a human with a robot."""
    world = ReachingWorld(Rules(goals=3), Movement().dynamics, redraw="picked")
    return play(world, {"human": make_human(kind, **options), "robot": robot}, seed=seed, samples=samples)


@given(DISTANCES, BELIEFS)
def test_yielding_humans_never_choose_the_goal_they_predict_and_the_stubborn_one_minds_nothing(
    distance, belief
):
    predicted = int(belief.argmax())
    rest = np.delete(np.arange(4), predicted)
    next_best = rest[distance[rest].argmin()]
    assert StubbornHuman().choose(distance, belief) == distance.argmin()
    assert MovingHuman().choose(distance, belief) == next_best
    chosen = WaitingHuman().choose(distance, belief)
    if belief[predicted] >= 0.8:
        assert chosen == next_best
    elif distance.argmin() == predicted:
        assert chosen is None
    else:
        assert chosen == distance.argmin()


@given(DISTANCES)
def test_an_even_belief_predicts_nothing(distance):
    even = np.full(4, 0.25)
    assert MovingHuman().choose(distance, even) == distance.argmin()
    assert WaitingHuman().choose(distance, even) is None


@given(DISTANCES, BELIEFS, st.permutations(range(4)))
def test_goals_may_come_in_any_order(distance, belief, order):
    for human in HUMANS.values():
        chosen, other = human().choose(distance, belief), human().choose(distance[order], belief[order])
        assert (chosen is None) == (other is None)
        if chosen is not None:
            assert order[other] == chosen


def test_the_belief_of_a_human_is_that_of_bayes_rule_on_the_robots_motion():
    beliefs = []

    class Remembers(SimulatedHuman):
        """Stands, and remembers what it believed."""

        def choose(self, distance, belief):
            beliefs.append(belief)

    world = ReachingWorld(Rules(goals=3), Movement().dynamics)
    played = play(world, {"human": HumanSeat(Remembers()), "robot": Straight(1)}, seed=4, samples=25)
    evidence = GoalEvidence(
        time=played.time,
        position=played.position[:, 1],
        velocity=played.velocity[:, 1],
        goals=played.goals[:1],
        row_size=np.array([25]),
        goal_labels=("0", "1", "2"),
        time_step=0.1,
    )
    offline = infer_goals(Movement().model, evidence).log_posterior
    np.testing.assert_allclose(beliefs, np.exp(offline), atol=1e-10)
    assert beliefs[-1][1] > 0.99


def test_who_stands_brakes_and_who_waits_goes_once_it_is_sure():
    played = game("waiting", Straight(0), seed=1)
    pursued = played.pursued[:, 0]
    assert pursued[0] == -1
    assert pursued[-1] != 0
    still = np.argmax(pursued >= 0)
    np.testing.assert_array_equal(played.position[:still, 0], played.position[:1, 0].repeat(still, axis=0))


def test_a_human_moves_as_its_lqr_says_and_noise_disturbs_its_velocity():
    calm = game("stubborn", Straight(0))
    movement = Movement()
    goal = movement.dynamics.goal_states(calm.goals[0, calm.pursued[0, 0]])
    state = movement.dynamics.goal_states(calm.position[0, 0])
    loop = movement.agent.closed_loop
    expected = [goal + np.linalg.matrix_power(loop, step) @ (state - goal) for step in range(25)]
    np.testing.assert_allclose(calm.position[:, 0], np.array(expected)[:, [0, 2]], atol=1e-10)
    runs = [game("stubborn", Straight(0), seed=seed, samples=2, noise=0.5) for seed in range(400)]
    calms = [game("stubborn", Straight(0), seed=seed, samples=2) for seed in range(400)]
    disturbed = np.array(
        [one.velocity[1, 0] - two.velocity[1, 0] for one, two in zip(runs, calms, strict=True)]
    )
    assert disturbed.std() == pytest.approx(0.5, rel=0.1)


def test_what_cannot_sit_there_is_refused():
    with pytest.raises(
        SimulationError, match="there are no humans 'shy'; there are waiting, moving, stubborn"
    ):
        make_human("shy")
    with pytest.raises(SimulationError, match="noise must be finite and not negative"):
        make_human("moving", noise=-1.0)
    with pytest.raises(ValueError, match="threshold"):
        WaitingHuman(threshold=1.5)
