"""What the human will do given what the robot does, at every sample of a log: the beliefs of Algorithm 1."""

from __future__ import annotations

import json
from dataclasses import asdict, replace
from typing import Any

import numpy as np
import xarray as xr
from jaxtyping import Bool, Float, Int

from ppinfer.distributions.logspace import log_sum_exp
from ppinfer.distributions.ragged import row_starts
from ppinfer.errors import LogError, ModelError
from ppinfer.goals import GoalLQR, GoalModel, infer_goals
from ppinfer.goals.conditional import SoftmaxConditional, conditional_log_weights
from ppinfer.goals.configuration import parameters_of
from ppinfer.goals.evidence import GoalEvidence
from ppinfer.goals.mental_model import infer_mental_model, paper_agent
from ppinfer.goals.reacted import ReactedConditional
from ppinfer.studies.goal_evidence import Restart, goal_evidence
from ppinfer.studies.log_inference import default_agent, nominal_time_step

# samples whose tables over prior, robot's and post goals are in memory at a time
_BLOCK = 1 << 15
_KEPT = ("trial_id", "row_size", "participant", "condition", "controller", "time")


def infer_log_conditional(
    log: xr.Dataset,
    model: GoalModel | None = None,
    *,
    robot_model: GoalModel | None = None,
    conditional: SoftmaxConditional | ReactedConditional | None = None,
    agent: str | None = None,
    partner: str | None = None,
    restart: Restart = "goals",
    carry: bool = False,
    time_step: float | None = None,
) -> xr.Dataset:
    """Return the beliefs that a robot of Algorithm 1 would hold at every sample of a log, all in one array program.

    The numbers are those that a `BehaviourPredictor` and the conditional give step by step.

    Parameters
    ----------
    log : xarray.Dataset
        A study log with goals and two agents at least, in memory.
    model : GoalModel, optional
        How the human acts; default `assumed_agent`.
    robot_model : GoalModel, optional
        How the human takes the robot to act; default `assumed_agent`.
    conditional : SoftmaxConditional or ReactedConditional, optional
        How the human reacts, with its weights; default `assumed_conditional`.
    agent, partner : str, optional
        Who is predicted, and who they react to; default: ``human`` and the log's other agent.
    restart, carry
        Where the beliefs start anew within a trial, and from what; see `goal_evidence`.
    time_step : float, optional
        Nominal seconds between samples; default: the median of this log.

    Returns
    -------
    xarray.Dataset
        Natural logarithms of probabilities, over the samples of the log:

        - ``log_belief(sample, goal)``: b_R(theta_prior), the human's goal before any reaction;
        - ``log_mental_model(sample, robot_goal)``: b_H(theta_R);
        - ``log_post(sample, robot_goal, goal)``: b_post(theta_post | theta_R), one row for each goal of the robot;
        - ``log_overall(sample, goal)``: p(theta_post), averaged over b_H(theta_R);
        - ``log_given(sample, goal)``: b_post given the goal that the robot had then, where the log says which; else,
          and where it waited, p(theta_post). ``robot_goal_index(sample)`` is that goal, -1 where there is none.

        Until the human is first seen in a trial, no reaction is predicted: b_post is the belief.

    Raises
    ------
    LogError
        Where the log has no goals, not these agents, or one agent only.
    ModelError
        Where the conditional is of another kind: it needs situations one by one.
    ImpossibleEvidenceError
        Where every goal is ruled out.

    Examples
    --------
    >>> from ppinfer.testing import example_interaction_log
    >>> beliefs = infer_log_conditional(example_interaction_log())
    >>> beliefs["log_post"].dims
    ('sample', 'robot_goal', 'goal')
    >>> bool((abs(np.exp(beliefs["log_post"]).sum("goal") - 1) < 1e-12).all())
    True
    """
    whose = default_agent(log) if agent is None else agent
    other = other_agent(log, whose, partner)
    human_model = assumed_agent(log) if model is None else model
    mind_model = assumed_agent(log) if robot_model is None else robot_model
    reaction = assumed_conditional(log) if conditional is None else conditional
    softmax = reaction.reaction if isinstance(reaction, ReactedConditional) else reaction
    if not isinstance(softmax, SoftmaxConditional):
        raise ModelError(
            f"beliefs at every sample need a SoftmaxConditional, or a ReactedConditional of one; got {reaction!r}"
        )
    step = nominal_time_step(log) if time_step is None else time_step
    human = goal_evidence(log, whose, restart=restart, carry=carry, time_step=step, partner=other)
    robot = goal_evidence(log, other, restart=restart, carry=carry, time_step=step, partner=whose)
    belief = infer_goals(human_model, human).log_posterior
    mind = infer_mental_model(robot, mind_model).log_values
    post = post_log_beliefs(human, belief, softmax, log["row_size"].values)
    if isinstance(reaction, ReactedConditional):
        # who knows the robot's goal has reacted already
        with np.errstate(divide="ignore"):
            unaware = np.log1p(-np.minimum(np.exp(mind), 1.0))
        post = np.logaddexp(mind[:, :, None] + belief[:, None, :], unaware[:, :, None] + post)
    overall = log_sum_exp(post + mind[:, :, None], (1,))
    robot_goal = pursued_goals(log, other)
    known = robot_goal >= 0
    given = overall.copy()
    given[known] = post[np.flatnonzero(known), robot_goal[known]]
    kept = log[[name for name in _KEPT if name in log]]
    labels = log["goal"].values
    out = kept.assign_coords(goal=labels, robot_goal=("robot_goal", labels)).assign(
        log_belief=(("sample", "goal"), belief),
        log_mental_model=(("sample", "robot_goal"), mind),
        log_post=(("sample", "robot_goal", "goal"), post),
        log_overall=(("sample", "goal"), overall),
        log_given=(("sample", "goal"), given),
        robot_goal_index=("sample", robot_goal),
    )
    out.attrs = {
        "agent": whose,
        "partner": other,
        "configuration": json.dumps(
            {
                "model": {"name": human_model.name, "parameters": parameters_of(human_model)},
                "robot_model": {"name": mind_model.name, "parameters": parameters_of(mind_model)},
                "conditional": {"name": reaction.name, "parameters": asdict(reaction)},
                "restart": restart,
                "carry": carry,
                "time_step": step,
            },
            allow_nan=False,
        ),
    }
    return out


def assumed_agent(log: xr.Dataset) -> GoalLQR:
    """Return what robot and human took each other for in a simulated game, as its log says; else `paper_agent`.

    Examples
    --------
    >>> from ppinfer.testing import example_interaction_log
    >>> assumed_agent(example_interaction_log()) == paper_agent()
    True
    """
    said = _configuration(log)
    if said.get("world") != "reaching-game":
        return paper_agent()
    named = ("control_weight", "state_weight", "rationality")
    values: dict[str, Any] = {name: float(said[name]) for name in named if name in said}
    return replace(paper_agent(), **values)


def assumed_conditional(log: xr.Dataset) -> SoftmaxConditional | ReactedConditional:
    """Return how robots of a simulated game took the human to react, as its log says; else a `SoftmaxConditional`.

    It is what the log says of influence and expected-cost; other robots may have taken it for something else.

    Examples
    --------
    >>> from ppinfer.testing import example_interaction_log
    >>> assumed_conditional(example_interaction_log()) == SoftmaxConditional()
    True
    """
    said = _configuration(log)
    if said.get("world") == "reaching-game" and said.get("reaction") == ReactedConditional.name:
        return ReactedConditional()
    return SoftmaxConditional()


def other_agent(log: xr.Dataset, agent: str, partner: str | None = None) -> str:
    """Return the agent that another one reacts to: the one asked for, or the only one beside it.

    Raises
    ------
    LogError
        Where there is no such agent, or several and none is named.

    Examples
    --------
    >>> from ppinfer.testing import example_interaction_log
    >>> other_agent(example_interaction_log(), "human")
    'robot'
    """
    others: list[str] = [name for name in log["agent"].values.astype(str).tolist() if name != agent]
    if partner is not None:
        if partner not in others:
            raise LogError(
                f"agent {agent!r} cannot react to {partner!r}; the log has "
                f"{', '.join(map(repr, others)) or 'nobody else'}"
            )
        return partner
    if len(others) != 1:
        raise LogError(
            f"beliefs given what another agent does need one beside {agent!r}; the log has "
            f"{', '.join(map(repr, others)) or 'none'}{': name one of them (partner)' if others else ''}"
        )
    return others[0]


def post_log_beliefs(
    evidence: GoalEvidence,
    log_belief: Float[np.ndarray, "sample goal"],
    conditional: SoftmaxConditional,
    row_size: Int[np.ndarray, " trial"],
) -> Float[np.ndarray, "sample goal goal"]:
    """Return log b_post(theta_post | theta_R) at every sample: the conditional averaged over the belief.

    Parameters
    ----------
    evidence : GoalEvidence
        The human's motion, as `goal_evidence` makes it.
    log_belief : (sample, goal) float64
        log b_R(theta_prior).
    conditional : SoftmaxConditional
        How the human reacts.
    row_size : (trial,) int64
        Samples of each trial. A human that is out of sight is where they were last seen in the trial.

    Returns
    -------
    (sample, robot_goal, goal) float64

    Examples
    --------
    >>> from ppinfer.testing import example_interaction_log
    >>> log = example_interaction_log()
    >>> evidence = goal_evidence(log, "human")
    >>> even = np.full((evidence.samples, evidence.goals.shape[1]), -np.log(evidence.goals.shape[1]))
    >>> post_log_beliefs(evidence, even, SoftmaxConditional(), log["row_size"].values).shape
    (60, 3, 3)
    """
    position, seen = last_seen(evidence.position, evidence.seen, row_size)
    row, count = evidence.row_of_sample, evidence.goals.shape[1]
    post = np.empty((len(row), count, count))
    for first in range(0, len(row), _BLOCK):
        here = slice(first, first + _BLOCK)
        weights = conditional_log_weights(
            evidence.goals[row[here]],
            position[here],
            human_weight=conditional.human_weight,
            robot_weight=conditional.robot_weight,
            stay_weight=conditional.stay_weight,
            rationality=conditional.rationality,
            present=evidence.goal_present[row[here]],
        )
        post[here] = log_sum_exp(weights + log_belief[here][:, :, None, None], (1,))
    post[~seen] = log_belief[~seen][:, None]
    return post


def last_seen(
    position: Float[np.ndarray, "sample space"],
    seen: Bool[np.ndarray, " sample"],
    row_size: Int[np.ndarray, " trial"],
) -> tuple[Float[np.ndarray, "sample space"], Bool[np.ndarray, " sample"]]:
    """Return where an agent was last seen by each sample of its trial, and whether it was by then; zero where not.

    Examples
    --------
    >>> at = np.array([[0.0], [1.0], [2.0], [3.0]])
    >>> where, known = last_seen(at, np.array([False, True, False, False]), np.array([3, 1]))
    >>> where[:, 0], known
    (array([0., 1., 1., 0.]), array([False,  True,  True, False]))
    """
    first = np.repeat(row_starts(row_size), row_size)
    latest = np.maximum.accumulate(np.where(seen, np.arange(len(seen)), -1))
    known = latest >= first
    return np.where(known[:, None], position[latest], 0.0), known


def pursued_goals(log: xr.Dataset, agent: str) -> Int[np.ndarray, " sample"]:
    """Return the index of the goal that an agent went for at every sample, as its log says; -1 where it does not.

    A log says it by ``pursued(sample, agent)``, or ``AGENT_goal_index(sample)``; failing these, by the agent's segments
    with their true goals.

    Examples
    --------
    >>> from ppinfer.testing import example_interaction_log
    >>> sorted(set(pursued_goals(example_interaction_log(), "robot").tolist()))
    [1]
    """
    labels = log["goal"].values.astype(str).tolist()
    found: Int[np.ndarray, " sample"]
    if "pursued" in log:
        agents = log["agent"].values.astype(str).tolist()
        found = log["pursued"].values[:, agents.index(agent)].astype(np.int64)
    elif f"{agent}_goal_index" in log:
        found = log[f"{agent}_goal_index"].values.astype(np.int64)
    else:
        found = np.full(log.sizes["sample"], -1, np.int64)
        if "segment_trial" in log:
            starts = row_starts(log["row_size"].values)[log["segment_trial"].values]
            for at in np.flatnonzero(log["segment_agent"].values.astype(str) == agent).tolist():
                goal = str(log["true_goal"].values[at])
                here = slice(
                    starts[at] + int(log["segment_start"].values[at]),
                    starts[at] + int(log["segment_stop"].values[at]),
                )
                found[here] = labels.index(goal) if goal in labels else -1
    return np.where((found >= 0) & (found < len(labels)), found, -1)


def _configuration(log: xr.Dataset) -> dict[str, Any]:
    try:
        said = json.loads(str(log.attrs.get("configuration", "{}")))
    except ValueError:
        return {}
    return said if isinstance(said, dict) else {}
