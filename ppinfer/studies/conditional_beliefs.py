"""What the human will do given what the robot does, at every sample of a log: the beliefs of Algorithm 1."""

from __future__ import annotations

import json
from dataclasses import dataclass, replace

import numpy as np
import xarray as xr
from jaxtyping import Bool, Float, Int

from ppinfer.distributions.logspace import log_sum_exp
from ppinfer.distributions.ragged import row_starts
from ppinfer.errors import LogError, ModelError
from ppinfer.goals import GoalModel, infer_goals
from ppinfer.goals.conditional import SoftmaxConditional, conditional_log_weights
from ppinfer.goals.configuration import parameters_of
from ppinfer.goals.evidence import GoalEvidence
from ppinfer.goals.mental_model import infer_mental_model
from ppinfer.goals.rationality import GoalAndRationality
from ppinfer.goals.reacted import ReactedConditional
from ppinfer.studies.assumed_reactions import (
    AssumedReaction,
    assumed_agent,
    assumed_reactions,
    told_reactions,
)
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

    The numbers are those that a `BehaviourPredictor` and the conditional give step by step. In a log of simulated games
    every trial has the reaction that its own robot expected, and the beliefs are those that it held, except for robots
    of one's own: see `assumed_reaction`.

    Parameters
    ----------
    log : xarray.Dataset
        A study log with goals and two agents at least, in memory.
    model : GoalModel, optional
        How the human acts; default `assumed_agent`, with more than one rationality where the robot considers them.
    robot_model : GoalModel, optional
        How the human takes the robot to act; default `assumed_agent`.
    conditional : SoftmaxConditional or ReactedConditional, optional
        How the human reacts, with its weights, to every robot; default `assumed_reactions`, each robot's own.
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
    robots = assumed_reactions(log, other)
    if conditional is not None:
        robots = tuple((name, AssumedReaction(conditional)) for name, _ in robots)
    step = nominal_time_step(log) if time_step is None else time_step
    human = goal_evidence(log, whose, restart=restart, carry=carry, time_step=step, partner=other)
    robot = goal_evidence(log, other, restart=restart, carry=carry, time_step=step, partner=whose)
    belief = infer_goals(human_model, human).log_posterior
    mind = infer_mental_model(robot, mind_model).log_values
    reactions = _Reactions.of(log, robots, human)
    if model is None:
        belief = np.where(np.isnan(reactions.marginal), belief, reactions.marginal)
    post = _post(human, belief, mind, reactions, log["row_size"].values)
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
                "conditional": told_reactions(robots),
                "restart": restart,
                "carry": carry,
                "time_step": step,
            },
            allow_nan=False,
        ),
    }
    return out


@dataclass(frozen=True, eq=False)
class _Reactions:
    """Which reaction counts at every sample.

    Attributes
    ----------
    which : (sample,) int64
        Index of the conditional.
    conditionals
        All that occur; None is no reaction.
    marginal : (sample, goal) float64
        The log belief of robots that consider rationalities; NaN for others.
    """

    which: Int[np.ndarray, " sample"]
    conditionals: tuple[SoftmaxConditional | ReactedConditional | None, ...]
    marginal: Float[np.ndarray, "sample goal"]

    @classmethod
    def of(
        cls, log: xr.Dataset, robots: tuple[tuple[str, AssumedReaction], ...], human: GoalEvidence
    ) -> _Reactions:
        """Return the reactions that the robots expect, one of them in each trial."""
        assumed = [reaction for _, reaction in robots]
        conditionals = tuple(dict.fromkeys(part for one in assumed for part in (one.conditional, one.unsure)))
        index = {part: number for number, part in enumerate(conditionals)}
        size = log["row_size"].values
        which = np.repeat(np.array([index[one.conditional] for one in assumed], np.int64), size)
        marginal = np.full((len(which), human.goals.shape[1]), np.nan)
        for one in dict.fromkeys(assumed):
            if not one.rationalities:
                continue
            here = np.repeat(np.array([other == one for other in assumed]), size)
            joint = GoalAndRationality(assumed_agent(log), one.rationalities).infer(
                replace(human, continues=None)
            )
            marginal[here] = joint.marginal("goal").log_values[here]
            if one.unsure is not None:
                sure = joint.marginal("rationality").values[:, int(np.argmax(one.rationalities))]
                which[here & (sure < one.resolute)] = index[one.unsure]
        return cls(which, conditionals, marginal)


def _post(
    human: GoalEvidence,
    belief: Float[np.ndarray, "sample goal"],
    mind: Float[np.ndarray, "sample goal"],
    reactions: _Reactions,
    row_size: Int[np.ndarray, " trial"],
) -> Float[np.ndarray, "sample goal goal"]:
    """Return log b_post(theta_post | theta_R), each sample under its own reaction."""
    post = np.repeat(belief[:, None, :], belief.shape[1], axis=1)
    known: dict[SoftmaxConditional, np.ndarray] = {}
    for number, conditional in enumerate(reactions.conditionals):
        here = reactions.which == number
        if conditional is None or not here.any():
            continue
        softmax = conditional.reaction if isinstance(conditional, ReactedConditional) else conditional
        if not isinstance(softmax, SoftmaxConditional):
            raise ModelError(
                "beliefs at every sample need a SoftmaxConditional, or a ReactedConditional of one; got "
                f"{conditional!r}"
            )
        if softmax not in known:
            known[softmax] = post_log_beliefs(human, belief, softmax, row_size)
        post[here] = known[softmax][here]
        if isinstance(conditional, ReactedConditional):
            # who knows the robot's goal has reacted already
            with np.errstate(divide="ignore"):
                unaware = np.log1p(-np.minimum(np.exp(mind[here]), 1.0))
            post[here] = np.logaddexp(
                mind[here][:, :, None] + belief[here][:, None, :], unaware[:, :, None] + post[here]
            )
    return post


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
