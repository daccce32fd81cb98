"""A small log of a robot and a human among goals, in which the human gives way."""

from __future__ import annotations

import numpy as np
import xarray as xr

from ppinfer.goals.mental_model import paper_agent

GOALS = np.array([[4.0, 0.0], [0.0, 4.0], [-4.0, -1.0]])
_STARTS = {"human": (0.0, 0.0), "robot": (1.5, 7.0)}
# the human turns from the goal that the robot goes for to another one
_TURN = 9


def example_interaction_log(*, trials: int = 2, samples: int = 30, dt: float = 0.1) -> xr.Dataset:
    """Return a log of a robot that goes for goal 1, and of a human who first does so too and then turns to goal 0.

    Both are double integrators under LQR control, without noise; trials differ in how the scene is turned.

    Parameters
    ----------
    trials, samples : int
        How many, and samples of each.
    dt : float
        Time step (s).

    Examples
    --------
    >>> log = example_interaction_log()
    >>> log.sizes["trial"], log["agent"].values.tolist(), log["pursued"].values[[0, -1]].tolist()
    (2, ['human', 'robot'], [[1, 1], [0, 1]])
    """
    from ppinfer.studies import build_log

    agent = paper_agent().agent_at(dt)
    dynamics = agent.dynamics
    pursued = np.ones((samples, 2), np.int8)
    pursued[_TURN:, 0] = 0
    state = dynamics.goal_states(np.array([_STARTS["human"], _STARTS["robot"]]))
    targets = dynamics.goal_states(GOALS)
    states = np.empty((samples, *state.shape))
    for sample in range(samples):
        states[sample] = state
        state = dynamics.step(state, agent.mean_control(state, targets[pursued[sample]]))
    angle = np.arange(trials) * (np.pi / 3)
    turn = np.stack([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]]).transpose(2, 0, 1)
    position, velocity = (
        np.concatenate([states[..., list(index)] @ one.T for one in turn])
        for index in (dynamics.position_index, dynamics.velocity_index)
    )
    return build_log(
        agents=["human", "robot"],
        goals=["0", "1", "2"],
        trial_id=[f"scene-{trial}" for trial in range(trials)],
        row_size=np.full(trials, samples),
        time=np.tile(np.arange(samples) * dt, trials),
        position=position,
        velocity=velocity,
        goal_position=np.stack([GOALS @ one.T for one in turn]),
        segment_trial=np.repeat(np.arange(trials), 2),
        segment_agent=["human"] * (2 * trials),
        segment_start=np.tile([0, _TURN], trials),
        segment_stop=np.tile([_TURN, samples], trials),
        true_goal=["1", "0"] * trials,
        variables={"pursued": (("sample", "agent"), np.tile(pursued, (trials, 1)))},
        title="made by ppinfer.testing.example_interaction_log",
    )
