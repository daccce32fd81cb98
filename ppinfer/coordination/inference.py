"""Whom do an agent's equilibria favour? The posterior over theta at every replan of a history."""

from __future__ import annotations

import numpy as np

from ppinfer.coordination.history import PlayHistory
from ppinfer.coordination.personality_model import PersonalityModel
from ppinfer.distributions import Distribution, forward_filter
from ppinfer.distributions.logspace import log_normalise


def infer_personality(model: PersonalityModel, history: PlayHistory, ego: str) -> Distribution:
    """Return p(theta) as one agent held it at each of its replans, after the evidence up to then.

    The same numbers as online, replan by replan. A trial begins with every personality as likely; where beliefs
    accumulate, theta first moves by the model's sticky transition and then meets the evidence since the replan before,

        p_t(theta)  is proportional to  L_t(theta) sum_theta' T(theta | theta') p_(t-1)(theta').

    Parameters
    ----------
    model : PersonalityModel
        Such as `Personality` or `LiteralPersonality`.
    history : PlayHistory
        Many trials.
    ego : str
        Whose view it is: with ``"robot"``, what the robot believes.

    Returns
    -------
    Distribution
        Random in ``theta``, batch ``replan``: the ego's replans, labelled by their places in the history.

    Raises
    ------
    ModelError
        If the history has no replan of this agent's.
    ImpossibleEvidenceError
        If no personality is possible at a replan; the message names it.

    Examples
    --------
    >>> from ppinfer.coordination import Personality, PlanSet, Situation
    >>> robot = PlanSet("robot", [2, 1], [0.0, 2.0, 0.0], [[0.0], [1.0], [0.0]], static=1)
    >>> human = PlanSet("human", [2, 1], [0.0, 4.0, 0.0], [[0.0], [1.0], [0.0]], static=1)
    >>> situation = Situation.from_contacts([robot, human], [[1.5, np.inf], [np.inf, np.inf]])
    >>> history = PlayHistory.from_situations([[situation]], "robot")
    >>> infer_personality(Personality(), history, "robot").values
    array([[0.5, 0.5]])
    """
    evidence = history.seen_by(ego)
    likelihood = model.log_likelihood(evidence)
    theta = model.theta(history.agents)
    log_likelihood = likelihood.align(evidence.replan_axis, theta).log_values

    def describe(row: int) -> str:
        trial = history.trial_of_replan[evidence.replans[row]]
        return f"{history.replan_time[evidence.replans[row]]:g} s of trial {trial}"

    if model.accumulates():
        prior = np.zeros((len(evidence.row_size), len(theta)))
        transition = None if model.stay == 1.0 else model._log_transition(len(theta))[None]
        log_posterior = forward_filter(
            log_likelihood, evidence.row_size, prior, transition, describe=describe
        )
    else:
        log_posterior, dead = log_normalise(log_likelihood, (1,))
        if dead is not None:
            # the filter names the replan that stops it
            each = np.ones(len(log_likelihood), np.int64)
            forward_filter(log_likelihood, each, np.zeros_like(log_likelihood), describe=describe)
    return Distribution._sound((evidence.replan_axis, theta), log_posterior, ("batch", "random"))
