"""Whether an arm's plan stays clear of the other arm, given what is believed of the other's plans."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from ppinfer.coordination import Situation
from ppinfer.coordination.plans import PlanSet
from ppinfer.distributions import Distribution
from ppinfer.errors import ModelError
from ppinfer.safety.clearance import ClearProbability, PlanBodies, clear_probability
from ppsim.arms.geometry import ARMS, Arm
from ppsim.errors import SimulationError

# a plan's end is a multiple of the time step, but for rounding
_SLACK = 1e-9


def arm_bodies(arm: Arm, plans: PlanSet, *, stride: float = 0.1, horizon: float | None = None) -> PlanBodies:
    """Return where an arm's two links are along each of its plans, every `stride` seconds, as capsules.

    An arm whose plan has ended leaves; one that does not move stays.

    Parameters
    ----------
    arm : Arm
        Whose plans they are.
    plans : PlanSet
        Joint angles over time, rad.
    stride : float
        Seconds between steps; the first is one stride from now.
    horizon : float, optional
        Seconds to look ahead; by default until the longest plan has ended.

    Raises
    ------
    SimulationError
        If the stride is not positive, the horizon shorter, or plans are not of two joints.

    Examples
    --------
    >>> plans = PlanSet("robot", [2, 1], [0.0, 1.0, 0.0], [[0.0, 0.0], [0.5, 0.0], [0.0, 0.0]], static=1)
    >>> bodies = arm_bodies(ARMS["robot"], plans, horizon=2.0)
    >>> bodies.ends.shape, bodies.steps
    ((2, 20, 2, 2, 2), array([10, 20]))
    """
    if plans.position.shape[1] != 2:
        raise SimulationError(f"plans of {plans.agent!r} have {plans.position.shape[1]} joints; arms have 2")
    if horizon is None:
        horizon = max(float(plans.duration.max()), stride)
    if not 0.0 < stride < np.inf or not stride - _SLACK <= horizon < np.inf:
        raise SimulationError(
            f"stride must be positive and the horizon no shorter; got {stride!r} and {horizon!r} s"
        )
    count = int(np.floor(horizon / stride + _SLACK))
    points = arm.points(plans.positions(stride * np.arange(1, count + 1)))
    steps = np.minimum(np.floor(plans.duration / stride + _SLACK).astype(np.int64), count)
    if plans.static is not None:
        steps[plans.static] = count
    return PlanBodies(np.stack([points[..., :-1, :], points[..., 1:, :]], axis=-2), arm.radius, steps)


def plan_clearance(
    situation: Situation,
    ego: str,
    belief: Any,
    *,
    arms: Mapping[str, Arm] = ARMS,
    margin: float = 0.0,
    stride: float = 0.1,
    horizon: float | None = None,
    plans: Any = None,
    obstacles: PlanBodies | None = None,
    noise: float = 0.0,
    rollouts: int = 1000,
) -> ClearProbability:
    """Return the probability that each of an arm's plans stays clear of the other arm over a horizon.

    Without noise, with no margin and the whole horizon, it is what the belief gives to the other's plans that do not
    come into contact (`contact_tables`). An agent whose only plan is not to move (`PlanSet.holding`) has finished, and
    has left the table.

    Parameters
    ----------
    situation : Situation
        Of two arms: the plans of both.
    ego : str
        Who asks.
    belief : Distribution or (plan,) array of float
        Of the other's plans; see `believed_plans`.
    arms : mapping from agent to Arm
        Who has which arm.
    margin : float
        m between the arms' surfaces.
    stride, horizon : float
        Seconds, as in `arm_bodies`; the horizon is by default that of the longest plan.
    plans : sequence of int, optional
        Some of ego's plans; default all.
    obstacles : PlanBodies, optional
        Other things on the table; at the same steps.
    noise, rollouts
        As in `clear_probability`; chance is drawn from the situation's seed.

    Raises
    ------
    SimulationError
        If there are not two agents, each with an arm.

    Examples
    --------
    >>> reaches = PlanSet("robot", [2, 1], [0.0, 4.0, 0.0], [[1.0, 0.0], [0.0, 0.0], [1.0, 0.0]], static=1)
    >>> stays = PlanSet("human", [2, 1], [0.0, 4.0, 0.0], [[0.0, 0.0], [1.2, 0.0], [0.0, 0.0]], static=1)
    >>> situation = Situation.from_contacts([reaches, stays], np.full((2, 2), np.inf))
    >>> plan_clearance(situation, "robot", [0.75, 0.25]).clear
    array([0.75, 1.  ])
    """
    if len(situation.plans) != 2 or any(agent not in arms for agent in situation.agents):
        raise SimulationError(f"expected two agents, of {', '.join(arms)}; got {situation.agents}")
    player = situation.player(ego)
    own, other = situation.plans[player], situation.plans[1 - player]
    if horizon is None:
        horizon = max(float(own.duration.max()), float(other.duration.max()), stride)
    if plans is not None:
        own = own.restrict(plans)
    theirs = arm_bodies(arms[other.agent], other, stride=stride, horizon=horizon)
    if len(other) == 1 and other.static == 0:
        theirs = PlanBodies(theirs.ends, theirs.radius, [0])
    return clear_probability(
        arm_bodies(arms[own.agent], own, stride=stride, horizon=horizon),
        [(theirs, belief)],
        margin=margin,
        obstacles=obstacles,
        noise=noise,
        rollouts=rollouts,
        rng=np.random.default_rng(situation.seed) if noise else None,
    )


def believed_plans(situation: Situation, ego: str, belief: Distribution) -> Distribution:
    """Return what the other agent will do, over its plans: p(j) = sum_theta p(theta) W(j | theta).

    W is that of `PlanPrediction`: the other plays an equilibrium that favours theta, of a game among some of the plans.

    Parameters
    ----------
    situation : Situation
        Of two agents.
    ego : str
        Who wonders.
    belief : Distribution
        Over ``theta``, labelled by the agents.

    Raises
    ------
    ModelError
        If the belief is over anything else.

    Examples
    --------
    >>> from ppinfer import Axis
    >>> robot = PlanSet("robot", [2, 1], [0.0, 2.0, 0.0], [[0.0], [1.0], [0.0]], static=1)
    >>> human = PlanSet("human", [2, 1], [0.0, 2.5, 0.0], [[0.0], [1.0], [0.0]], static=1)
    >>> situation = Situation.from_contacts([robot, human], [[1.5, np.inf], [np.inf, np.inf]])
    >>> sure = Distribution.from_probabilities([Axis("theta", ["robot", "human"])], [0.25, 0.75])
    >>> believed_plans(situation, "robot", sure).values
    array([0.75, 0.25])
    """
    from ppinfer.coordination import PlanPrediction

    if belief.random != ("theta",):
        raise ModelError(f"expected a belief over theta; got {belief!r}")
    joint = belief * PlanPrediction().predict(situation, ego)
    assert isinstance(joint, Distribution)
    return joint.marginal(situation.plans[1 - situation.player(ego)].axis.name)
