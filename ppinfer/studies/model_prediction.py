"""The model-based prediction of examples for learned ones: Bayes for the prior goal, then the softmax conditional."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from jaxtyping import Float

from ppinfer.goals.conditional import SoftmaxConditional, conditional_log_weights
from ppinfer.goals.dynamics import Dynamics
from ppinfer.goals.learned import PredictionExamples
from ppinfer.goals.noisily_rational import NoisilyRational


@dataclass(frozen=True)
class ModelPrediction:
    """Algorithm 1's prediction: b_post(i | R) = sum_j p(i | j, R) b_prior(j), with b_prior by (22)-(27).

    Parameters
    ----------
    conditional : SoftmaxConditional
        p(post goal | prior goal, robot's goal).
    rationality : float
        beta of the human as the robot takes it to be, in 1/cost.
    state_weight, control_weight : float
        Q and R of the human's LQR.
    dynamics : str
        What states hold.
    dt : float
        Seconds of a step.

    Examples
    --------
    >>> from ppinfer.testing.prediction_examples import example_predictions
    >>> np.exp(ModelPrediction().log_probabilities(example_predictions(4))).sum(axis=1).round(12)
    array([1., 1., 1., 1.])
    """

    conditional: SoftmaxConditional = field(default_factory=SoftmaxConditional)
    rationality: float = 3e-4
    state_weight: float = 10.0
    control_weight: float = 1.0
    dynamics: str = "double-integrator"
    dt: float = 0.1

    def log_probabilities(self, examples: PredictionExamples) -> Float[np.ndarray, "example goal"]:
        """Return log b_post for the robot's goal of every example, -inf for goals that are absent."""
        return self._posterior(examples, self._evidence(examples))

    def _posterior(
        self, examples: PredictionExamples, evidence: Float[np.ndarray, "example goal"]
    ) -> Float[np.ndarray, "example goal"]:
        prior = self.rationality * evidence
        prior = np.where(examples.present, prior, -np.inf)
        prior -= np.logaddexp.reduce(prior, axis=1, keepdims=True)
        dynamics = Dynamics.named(self.dynamics, self.dt)
        table = conditional_log_weights(
            examples.goals.astype(np.float64),
            examples.human[:, -1, list(dynamics.position_index)].astype(np.float64),
            human_weight=self.conditional.human_weight,
            robot_weight=self.conditional.robot_weight,
            stay_weight=self.conditional.stay_weight,
            rationality=self.conditional.rationality,
            present=examples.present,
        )
        given = table[np.arange(len(examples)), :, examples.robot_goal]
        post: np.ndarray = np.logaddexp.reduce(prior[:, :, None] + given, axis=1)
        return post

    def _evidence(self, examples: PredictionExamples) -> Float[np.ndarray, "example goal"]:
        """Return the log likelihood of the motion so far towards each goal, for beta = 1, up to a constant."""
        dynamics = Dynamics.named(self.dynamics, self.dt)
        agent = NoisilyRational.lqr(
            dynamics, state_weight=self.state_weight, control_weight=self.control_weight
        )
        states = examples.human.astype(np.float64)
        control = dynamics.control_between(
            states[:, :-1], states[:, 1:], np.full((len(states), states.shape[1] - 1), self.dt)
        )
        goal = dynamics.goal_states(examples.goals.astype(np.float64))
        pulled = control + states[:, :-1] @ agent.K.T
        off = pulled[:, :, None] - (goal @ agent.goal_gain.T)[:, None]
        evidence: np.ndarray = -np.einsum("etgm,mk,etgk->eg", off, agent.S, off)
        return evidence


def fit_model_prediction(start: ModelPrediction, examples: PredictionExamples) -> ModelPrediction:
    """Return the prediction whose four weights and two rationalities give the least squared error on some examples.

    What is minimised is what learning minimises, so that the two differ in what they know and in nothing else. Only the
    products of beta_c with w1, w2 and w3 matter; beta_c stays as it is.

    Parameters
    ----------
    start : ModelPrediction
        Where the search begins.
    examples : PredictionExamples
        In memory; some hundred are plenty.

    Examples
    --------
    >>> from ppinfer.testing.prediction_examples import example_predictions
    >>> fitted = fit_model_prediction(ModelPrediction(), example_predictions(50))
    >>> fitted.conditional.rationality
    0.5
    """
    from scipy.optimize import minimize

    def at(logs: Float[np.ndarray, " parameter"]) -> ModelPrediction:
        human, robot, stay, rationality = np.exp(np.clip(logs, -25.0, 12.0)).tolist()
        conditional = SoftmaxConditional(human, robot, stay, start.conditional.rationality)
        return replace(start, conditional=conditional, rationality=rationality)

    goals = examples.present.sum(axis=1)
    evidence = start._evidence(examples)

    def loss(logs: Float[np.ndarray, " parameter"]) -> float:
        error = (np.exp(at(logs)._posterior(examples, evidence)) - examples.frequency) ** 2
        return float(np.mean(error.sum(axis=1) / goals))

    first = start.conditional
    begin = np.log([first.human_weight, first.robot_weight, first.stay_weight, start.rationality])
    options: Any = {"maxiter": 300, "xatol": 1e-2, "fatol": 1e-6}
    found = minimize(loss, begin, method="Nelder-Mead", options=options)
    return at(np.asarray(found.x))
