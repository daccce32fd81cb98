"""What the network sees of an example: everything relative to where the human is."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float

from ppinfer.errors import ModelError
from ppinfer.goals.dynamics import Dynamics
from ppinfer.goals.learned.configuration import NetworkConfiguration
from ppinfer.goals.learned.examples import PredictionExamples

# position and velocity of both agents; of the robot; vectors and distances from human, robot and the plan's end
PAST_FEATURES, PLAN_FEATURES, GOAL_FEATURES = 8, 4, 9


@dataclass(frozen=True, eq=False)
class Features:
    """Inputs of the network, in its own units."""

    past: Float[np.ndarray, "example past 8"]
    plan: Float[np.ndarray, "example horizon 4"]
    goals: Float[np.ndarray, "example goal 9"]
    present: Bool[np.ndarray, "example goal"]


def features_of(
    examples: PredictionExamples,
    configuration: NetworkConfiguration,
    turn: Float[np.ndarray, "example 2 2"] | None = None,
) -> Features:
    """Return the inputs of the network for some examples.

    Positions are relative to the human's present one, so that the answer does not depend on where in the workspace
    all this happens.

    Parameters
    ----------
    examples : PredictionExamples
        With as many steps of past and plan as the network takes.
    configuration : NetworkConfiguration
        The network's units, and what states hold.
    turn : (example, 2, 2) float, optional
        A rotation or reflection of the plane for each example.

    Raises
    ------
    ModelError
        Where the steps, the states or the dimensions of space are not those of the network.

    Examples
    --------
    >>> from ppinfer.testing.prediction_examples import example_predictions
    >>> examples = example_predictions(5)
    >>> features_of(examples, NetworkConfiguration(past=4, horizon=8)).past.shape
    (5, 4, 8)
    """
    dynamics = Dynamics.named(configuration.dynamics, configuration.dt)
    past, horizon, states = *examples.human.shape[1:2], *examples.plan.shape[1:]
    wanted = (configuration.past, configuration.horizon, dynamics.states, 2)
    if (past, horizon, states, examples.goals.shape[2]) != wanted:
        raise ModelError(
            f"the network takes {wanted[0]} steps of the past and {wanted[1]} of a plan, states of {wanted[2]} entries "
            f"and goals in two dimensions; the examples have {past}, {horizon}, {states} and {examples.goals.shape[2]}"
        )
    position, velocity = list(dynamics.position_index), list(dynamics.velocity_index)
    origin = examples.human[:, -1:, position]

    def turned(vectors: Float[np.ndarray, "example step 2"]) -> Float[np.ndarray, "example step 2"]:
        return vectors if turn is None else np.einsum("esi,eij->esj", vectors, turn)

    def motion(states: Float[np.ndarray, "example step n"]) -> Float[np.ndarray, "example step 4"]:
        places = turned(states[..., position] - origin) / configuration.length_scale
        speeds = (
            turned(states[..., velocity]) / configuration.speed_scale if velocity else np.zeros_like(places)
        )
        return np.concatenate([places, speeds], axis=-1)

    to_goal = [
        turned(examples.goals - place[:, None, position]) / configuration.length_scale
        for place in (examples.human[:, -1], examples.robot[:, -1], examples.plan[:, -1])
    ]
    distance = [np.linalg.norm(vectors, axis=-1, keepdims=True) for vectors in to_goal]
    goals = np.where(examples.present[..., None], np.concatenate([*to_goal, *distance], axis=-1), 0.0)
    return Features(
        past=np.concatenate([motion(examples.human), motion(examples.robot)], axis=-1),
        plan=motion(examples.plan),
        goals=goals,
        present=examples.present,
    )


def scales_of(examples: PredictionExamples, dynamics: Dynamics) -> tuple[float, float]:
    """Return typical distances (m) and speeds (m/s) of some examples, as the network's units.

    Examples
    --------
    >>> from ppinfer.testing.prediction_examples import example_predictions
    >>> length, speed = scales_of(example_predictions(20), Dynamics.named("double-integrator", 0.1))
    >>> length > 0 and speed > 0
    True
    """
    position, velocity = list(dynamics.position_index), list(dynamics.velocity_index)
    away = (examples.goals - examples.human[:, -1:, position])[examples.present]
    length = float(np.sqrt(np.mean(np.sum(away.astype(np.float64) ** 2, axis=-1))))
    speeds = np.concatenate([examples.human[:, -1, velocity], examples.plan[:, 0, velocity]])
    speed = float(np.sqrt(np.mean(np.sum(speeds.astype(np.float64) ** 2, axis=-1)))) if velocity else 0.0
    return length or 1.0, speed or 1.0


def random_turns(count: int, rng: np.random.Generator) -> Float[np.ndarray, "count 2 2"]:
    """Draw rotations of the plane, half of them with a reflection.

    Examples
    --------
    >>> turns = random_turns(3, np.random.default_rng(0))
    >>> bool(np.allclose(turns @ turns.transpose(0, 2, 1), np.eye(2)))
    True
    """
    angle = rng.uniform(0.0, 2 * np.pi, count)
    flip = rng.choice([-1.0, 1.0], count)
    cos, sin = np.cos(angle), np.sin(angle)
    return np.stack([np.stack([cos, sin], -1), np.stack([-flip * sin, flip * cos], -1)], axis=1)
