"""The joint choice of a goal and a trajectory: its cost, its guarantee, and what it leaves out."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose

from ppinfer.distributions import Axis, Distribution
from ppinfer.errors import ModelError
from ppinfer.goals import SoftmaxConditional
from ppinfer.goals.choice import ExpectedCost, GoalSituation
from ppinfer.goals.choice.joint import JointChoice, point_agent
from ppinfer.safety import Mover, candidate_trajectories, clopper_pearson_lower, plan_safe_probability
from ppinfer.testing import example_goal_situation


def head_on(human_y: float = 0.0, wanted: float = 1.0) -> GoalSituation:
    """Return a human who comes the robot's way: each wants to be where the other is."""
    goal = Axis("goal", ["left", "right", "up"])
    human, robot = np.array([4.0, 0.0, human_y, 0.0]), np.array([-4.0, 0.0, 0.0, 0.0])
    rest = (1.0 - wanted) / 2
    belief = Distribution.from_probabilities([goal], [wanted, rest, rest])
    return GoalSituation(
        goals=np.array([[-6.0, 0.0], [6.0, 0.0], [0.0, 60.0]]),
        human=human,
        robot=robot,
        human_position=human[[0, 2]],
        robot_position=robot[[0, 2]],
        belief=belief,
        mental_model=Distribution.uniform(goal.rename("robot_goal")),
    )


def random_situation(rng: np.random.Generator) -> GoalSituation:
    goal = Axis("goal", ["a", "b", "c"])
    goals = rng.uniform(-6.0, 6.0, (3, 2))
    human, robot = np.zeros(4), np.zeros(4)
    human[[0, 2]] = rng.uniform(-6.0, 6.0, 2)
    while True:
        robot[[0, 2]] = rng.uniform(-6.0, 6.0, 2)
        if np.linalg.norm(robot - human) > 2.0:
            break
    return GoalSituation(
        goals=goals,
        human=human,
        robot=robot,
        human_position=human[[0, 2]],
        robot_position=robot[[0, 2]],
        belief=Distribution.from_probabilities([goal], rng.dirichlet(np.ones(3))),
        mental_model=Distribution.uniform(goal.rename("robot_goal")),
    )


def literal_costs(chooser: JointChoice, situation: GoalSituation) -> dict[int, list[float]]:
    """Return J of every offered pair by loops over goals, candidates and modes, without pruning any."""
    rng = np.random.default_rng(chooser.seed)
    post = np.exp(chooser.conditional.post(situation).log_values)
    goals, robot = situation.goals, chooser.robot
    offers = {}
    for r in range(len(goals)):
        target = np.array([goals[r, 0], 0.0, goals[r, 1], 0.0])
        targets = np.stack([goals[:, 0], 0 * goals[:, 0], goals[:, 1], 0 * goals[:, 1]], axis=1)
        human = Mover(chooser.human, situation.human, targets, post[r] / post[r].sum())
        made = candidate_trajectories(
            robot, situation.robot, target, [human], obstacles=chooser.obstacles, horizon=chooser.horizon,
            distance=chooser.distance, eps=chooser.eps, pursuit=True, rng=rng,
        )  # fmt: skip
        offers[r] = made, np.flatnonzero(made.safe) if made.safe.any() else np.arange(len(made)), human
    among = sum(len(offered) for _, offered, _ in offers.values())
    costs: dict[int, list[float]] = {}
    for r, (made, offered, human) in offers.items():
        state, behind = situation.robot, [np.linalg.norm(situation.robot_position - goals[r])]
        for _ in range(chooser.horizon):
            target = np.array([goals[r, 0], 0.0, goals[r, 1], 0.0])
            state = robot.A @ state - robot.B @ robot.gain @ (state - target)
            behind.append(np.linalg.norm(state[[0, 2]] - goals[r]))
        found = plan_safe_probability(
            made.positions[offered], [human], rollouts=chooser.rollouts, rng=np.random.default_rng(5)
        )
        costs[r] = []
        for which, c in enumerate(offered):
            lag = np.mean([np.linalg.norm(p - goals[r]) for p in made.positions[c]]) - np.mean(behind)
            cost = 0.0
            for i in range(len(goals)):
                mine = np.linalg.norm(situation.robot_position - goals[r]) + lag
                theirs = np.linalg.norm(situation.human_position - goals[i])
                cost += post[r, i] * (max(mine, theirs) + (chooser.penalty if i == r else 0.0))
            cost += chooser.control_weight * (made.controls[c] ** 2).sum() * chooser.dt
            shared = 1 - (1 - chooser.confidence) / among
            bound = 1 - clopper_pearson_lower(int(found.safe[which]), chooser.rollouts, shared)
            costs[r].append(cost + chooser.violation_weight * max(bound - chooser.eps, 0.0))
    return costs


@pytest.mark.parametrize("seed", range(12))
def test_the_pair_chosen_is_the_best_of_all_pairs(seed: int) -> None:
    situation = random_situation(np.random.default_rng(seed))
    chooser = JointChoice(obstacles=12, rollouts=500)
    decision = chooser.choose(situation)
    costs = literal_costs(chooser, situation)
    best = {r: min(values) for r, values in costs.items()}
    # rollouts are other ones in the literal loop: where the risk has no part in it, costs agree to rounding
    assert decision.among == sum(len(values) for values in costs.values())
    assert decision.goal == min(best, key=lambda r: best[r])
    assert_allclose(decision.score[decision.goal], best[decision.goal], rtol=1e-2)
    for r, value in best.items():
        assert decision.score[r] <= value * (1 + 1e-2)


def test_with_nobody_near_it_is_the_chooser_of_goals_that_goes_the_nominal_way() -> None:
    situation = example_goal_situation()
    far = replace(situation, human=np.array([0.0, 0.0, 400.0, 0.0]), human_position=np.array([0.0, 400.0]))
    joint = JointChoice(control_weight=0.0, conditional=SoftmaxConditional()).choose(far)
    alone = ExpectedCost().choose(far)
    assert joint.goal == alone.goal
    # no synthetic obstacle, or nothing at all, is what it minds
    assert joint.chosen in (0, len(joint.candidates) - 1)
    assert not joint.flagged
    assert_allclose(joint.score[joint.goal], alone.score[alone.goal], rtol=1e-12)


def test_who_comes_the_other_way_is_passed_at_a_distance() -> None:
    situation = head_on()
    decision = JointChoice(penalty=0.0).choose(situation)
    assert not decision.flagged
    assert decision.safe_probability.lower(0.99, decision.among) >= 0.95
    assert decision.goal != 1 or decision.chosen != len(decision.candidates) - 1


def test_accepted_trajectories_violate_no_more_often_than_eps() -> None:
    rng = np.random.default_rng(11)
    chooser = JointChoice(obstacles=24, rollouts=500).with_generator(rng)
    violated = accepted = 0
    for _ in range(60):
        situation = random_situation(rng)
        decision = chooser.choose(situation)
        if decision.flagged:
            continue
        post = np.exp(decision.post.log_values[decision.goal])
        goals = situation.goals
        targets = np.stack([goals[:, 0], 0 * goals[:, 0], goals[:, 1], 0 * goals[:, 1]], axis=1)
        human = Mover(chooser.human, situation.human, targets, post / post.sum())
        plan = decision.candidates.positions[[decision.chosen]]
        fresh = plan_safe_probability(plan, [human], rollouts=2000, rng=rng)
        accepted += 1
        violated += fresh[0].estimate < 0.95
    assert accepted > 30
    assert violated == 0


def test_where_nothing_is_safe_it_says_so_and_still_decides() -> None:
    situation = head_on()
    near = replace(situation, human=np.array([-3.5, 0.0, 0.0, 0.0]), human_position=np.array([-3.5, 0.0]))
    decision = JointChoice(obstacles=8, rollouts=200).choose(near)
    assert decision.flagged
    assert np.isfinite(decision.control).all()


def test_the_same_situation_has_the_same_decision_and_a_generator_goes_on() -> None:
    situation = head_on(0.3, wanted=0.6)
    one, other = (JointChoice(obstacles=16, rollouts=300).choose(situation) for _ in range(2))
    assert one.chosen == other.chosen
    assert np.array_equal(one.score, other.score)
    moving = JointChoice(obstacles=16, rollouts=300).with_generator(np.random.default_rng(1))
    drawn = [moving.choose(situation).candidates.positions for _ in range(2)]
    assert not np.array_equal(*drawn)


def test_a_goal_that_is_absent_is_never_chosen() -> None:
    situation = example_goal_situation()
    goal = situation.belief.axes[0]
    belief = Distribution.from_probabilities([goal], [0.0, 0.6, 0.4])
    mental = belief.rename(goal="robot_goal")
    assert isinstance(mental, Distribution)
    gone = replace(
        situation, belief=belief, mental_model=mental, present=np.array([False, True, True]), previous=None
    )
    decision = JointChoice(obstacles=8, rollouts=200).choose(gone)
    assert decision.goal in (1, 2)
    assert decision.score[0] == np.inf


def test_agents_of_another_kind_are_refused() -> None:
    situation = example_goal_situation()
    short = replace(situation, human=situation.human_position, robot=situation.robot_position)
    with pytest.raises(ModelError, match="do not fit agents of 4 and 4"):
        JointChoice().choose(short)
    with pytest.raises(ModelError, match="eps must lie in"):
        JointChoice(eps=0.0)
    assert point_agent().noise is not None
