"""Heading where, and how rationally? One belief over goal and rationality."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any

import numpy as np
from jaxtyping import Bool, Float

from ppinfer.distributions import Axis, Distribution, Factor, Ragged, forward_filter, smooth
from ppinfer.distributions.logspace import log_normalise
from ppinfer.errors import ModelError
from ppinfer.goals.belief import Mode
from ppinfer.goals.evidence import GoalEvidence
from ppinfer.goals.lqr import GoalLQR, log_peak
from ppinfer.goals.mental_model import paper_agent
from ppinfer.goals.model import LARGEST, require_range
from ppinfer.goals.noisily_rational import NoisilyRational
from ppinfer.goals.priors import log_priors
from ppinfer.goals.switching import row_transitions

SWITCHING_RATIONALITIES = (5e-6, 5e-5, 5e-3)
"""Rationalities (1/cost) between which the switching robot tells, for the paper's agent."""


@dataclass(frozen=True)
class GoalAndRationality:
    """Infers jointly where an agent is heading and how rational it is, the latter one of a few values that stay put.

    The likelihood of a sample under goal theta and rationality beta is that of `GoalLQR`, tempered and with its floor
    where these are set. With z_t = u_t + K x_t and its normaliser, which depends on beta,

        log L_t(theta, beta) = -beta (z_t - K theta)' S (z_t - K theta) + (m / 2) log beta + const,

    so that motion far from what any goal asks for speaks for a low beta, and motion close to it for a high one.

    Parameters
    ----------
    model : GoalLQR
        The agent; its own rationality is not used. Default: `paper_agent`.
    rationalities : tuple of float
        The values of beta (1/cost), all different.
    rationality_prior : tuple of float, optional
        Their probabilities, up to a factor; default even.

    Raises
    ------
    ModelError
        Where a rationality is not positive, or repeated, or the prior does not fit.

    Examples
    --------
    >>> from ppinfer.goals import GoalDesign
    >>> joint = GoalAndRationality()
    >>> rng = np.random.default_rng(0)
    >>> evidence = joint.at(5e-3).simulate(GoalDesign.random(rng, rows=1, samples=30), rng)
    >>> belief = joint.infer(evidence)
    >>> belief
    Distribution p(goal, rationality; sample): sample 30, goal 3, rationality 3
    >>> belief.given(sample=29).marginal("rationality").mode()
    {'rationality': 0.005}
    """

    model: GoalLQR = field(default_factory=paper_agent)
    rationalities: tuple[float, ...] = SWITCHING_RATIONALITIES
    rationality_prior: tuple[float, ...] | None = None

    def __post_init__(self) -> None:
        for value in self.rationalities:
            require_range("a rationality", value, 0.0, LARGEST, open_low=True)
        if not self.rationalities or len(set(self.rationalities)) != len(self.rationalities):
            raise ModelError(f"rationalities must be at least one, all different; got {self.rationalities}")
        prior = self.rationality_prior
        if prior is not None and (
            len(prior) != len(self.rationalities)
            or not all(np.isfinite(p) and p >= 0 for p in prior)
            or sum(prior) <= 0
        ):
            raise ModelError(
                f"rationality_prior must hold {len(self.rationalities)} finite probabilities, not negative and not all "
                f"zero; got {prior}"
            )

    @property
    def axis(self) -> Axis:
        """The axis ``rationality``."""
        return Axis("rationality", [float(value) for value in self.rationalities])

    @cached_property
    def log_prior(self) -> Float[np.ndarray, " rationality"]:
        """Log prior probabilities of the rationalities."""
        prior = self.rationality_prior or (1.0,) * len(self.rationalities)
        logs: np.ndarray = log_priors(np.ones((1, len(prior)), dtype=bool), prior)[0]
        return logs

    def at(self, rationality: float) -> GoalLQR:
        """Return the model of the goal alone at one rationality (1/cost); it can simulate."""
        if self.model.agent is not None:
            return replace(self.model, agent=replace(self.model.agent, rationality=rationality))
        return replace(self.model, rationality=rationality)

    def log_peaks(self, agent: NoisilyRational) -> Float[np.ndarray, " rationality"]:
        """Return, for each rationality, the log density of the best control of an agent that is otherwise like this."""
        ratio = np.asarray(self.rationalities, dtype=np.float64) / agent.rationality
        peaks: np.ndarray = log_peak(agent) + 0.5 * agent.dynamics.controls * np.log(ratio)
        return peaks

    def log_likelihood(self, evidence: GoalEvidence) -> Factor:
        """Return log L_t(theta, beta), a Factor over (sample, goal, rationality); 0 where a sample tells nothing."""
        squares, agent, motion = self.model.squared_residuals(evidence)
        whole = [
            self.model.evidence_of(squares.copy(), motion.informative, replace(agent, rationality=value))
            for value in self.rationalities
        ]
        log_values = np.stack(whole, axis=2)
        log_values[~evidence.goal_present[evidence.row_of_sample]] = -np.inf
        return Factor((evidence.sample_axis, evidence.goal_axis, self.axis), log_values)

    def infer(self, evidence: GoalEvidence, *, mode: Mode = "filter", prior: Any = None) -> Distribution:
        """Return the belief over goal and rationality at every sample, all rows in one array program.

        Parameters
        ----------
        evidence : GoalEvidence
            The agent's motion. Each row begins with the prior, of the rationality too.
        mode : {"filter", "smooth"}
            Given the samples so far, or given the whole row.
        prior : (goal,) or (row, goal) array of float, optional
            Probabilities of the goals at the start of each row; default: even over the goals present.

        Returns
        -------
        Distribution
            Random in ``goal`` and ``rationality``, one for each ``sample``.

        Raises
        ------
        ImpossibleEvidenceError
            Where everything is ruled out.
        ModelError
            Where the mode is unknown, the prior does not fit, or rows continue one another.
        """
        if mode not in ("filter", "smooth"):
            raise ModelError(f"unknown mode {mode!r}: expected 'filter' or 'smooth'")
        if evidence.continues is not None and evidence.continues.any():
            raise ModelError(
                "a belief over goal and rationality restarts at every row, but the evidence has rows that continue "
                "others: pass dataclasses.replace(evidence, continues=None)"
            )
        goals = log_priors(evidence.goal_present, prior, name_row=evidence.row_name)
        log_prior = goals[:, :, None] + self.log_prior
        if self.model.stay == 1.0 and self.model.is_cumulative and mode == "filter":
            log_belief = self._cumulative(evidence, log_prior)
        else:
            log_belief = self._filtered(evidence, log_prior, goals, mode)
        axes = (evidence.sample_axis, evidence.goal_axis, self.axis)
        return Distribution._sound(axes, log_belief, ("batch", "random", "random"))

    def _cumulative(
        self, evidence: GoalEvidence, log_prior: Float[np.ndarray, "row goal rationality"]
    ) -> Float[np.ndarray, "sample goal rationality"]:
        """Return the filtered belief by sums that restart at each row: the same ones for every rationality.

        log b_t(theta, beta) = const - beta sum e' S e + n_t log p_max(beta) + log b_0, after n_t informative samples.
        """
        squares, agent, motion = self.model.squared_residuals(evidence)
        told = np.column_stack([squares, motion.informative])
        sums = Ragged(told, evidence.row_size).cumsum().values
        beta = np.asarray(self.rationalities, dtype=np.float64)
        log_weights = (-self.model.tempering) * sums[:, :-1, None] * beta
        log_weights += (self.model.tempering * sums[:, -1:] * self.log_peaks(agent))[:, None, :]
        log_weights += log_prior[evidence.row_of_sample]
        log_belief, _ = log_normalise(log_weights, (1, 2))
        return log_belief

    def _filtered(
        self,
        evidence: GoalEvidence,
        log_prior: Float[np.ndarray, "row goal rationality"],
        goals: Float[np.ndarray, "row goal"],
        mode: Mode,
    ) -> Float[np.ndarray, "sample goal rationality"]:
        """Return the belief by filtering over all pairs of goal and rationality, of which only the goal changes."""
        log_likelihood = self.log_likelihood(evidence).log_values
        log_transition = which = None
        if self.model.stay != 1.0:
            between_goals, which = row_transitions(
                goals, evidence.goal_present, self.model.stay, memoryless=False
            )
            log_transition = _with_constant(between_goals, len(self.rationalities))
        run = forward_filter if mode == "filter" else smooth
        pairs = run(
            log_likelihood.reshape(len(log_likelihood), -1),
            evidence.row_size,
            log_prior.reshape(len(log_prior), -1),
            log_transition,
            which,
            describe=evidence.describe_sample,
        )
        return pairs.reshape(log_likelihood.shape)


def _with_constant(
    log_transition: Float[np.ndarray, "kind goal goal"], values: int
) -> Float[np.ndarray, "kind pair pair"]:
    """Return the transition of pairs (goal, value) whose value stays."""
    kinds, goals, _ = log_transition.shape
    same: Bool[np.ndarray, "values values"] = np.eye(values, dtype=bool)
    pairs = np.where(same[:, None, :], log_transition[:, :, None, :, None], -np.inf)
    return np.ascontiguousarray(pairs).reshape(kinds, goals * values, goals * values)
