"""goal-lqr: the goal posterior of a noisily rational LQR agent (22)-(27)."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache
from typing import ClassVar

import numpy as np
from jaxtyping import Bool, Float

from ppinfer.distributions import Factor
from ppinfer.errors import ModelError
from ppinfer.goals.dynamics import Dynamics
from ppinfer.goals.evidence import GoalEvidence
from ppinfer.goals.model import (
    LARGEST,
    Assessment,
    GoalDesign,
    GoalModel,
    OnlineLikelihood,
    require_range,
)
from ppinfer.goals.motion import Motion, causal_motion
from ppinfer.goals.noisily_rational import NoisilyRational
from ppinfer.goals.rollout import roll_out

# samples of one pass over the cache: scores and weights of a few goals stay in the second-level cache
BLOCK_SAMPLES = 4096


@dataclass(frozen=True)
class GoalLQR(GoalModel):
    """A noisily rational LQR agent that pursues one of the goals.

    The evidence of a sample is the tempered likelihood of its control,

        log L_t(theta) = tempering * log p(u_t | x_t, theta),

    with log p of (22). With an evidence floor f > 0 it is log[(1 - f) (p / p_max)^tempering + f] + tempering log p_max:
    no single sample, however odd, counts for more than -log f between two goals.

    Parameters
    ----------
    dynamics : {"single-integrator", "double-integrator"}
        What the agent controls: its velocity or its acceleration.
    control_weight : float
        R = control_weight I. Against `state_weight` it sets how briskly a goal is approached: for the single integrator
        the speed is about distance * sqrt(state_weight / control_weight) per second.
    state_weight : float
        Q = state_weight I.
    rationality : float
        Inverse temperature beta, in 1/cost.
    tempering : float
        Exponent on the likelihood, for evidence that is not independent from sample to sample.
    stay : float
        Probability per sample that the goal stays what it is; 1 is the paper's.
    evidence_floor : float
        f above, in [0, 1); 0 is the paper's.
    agent : NoisilyRational, optional
        Any (A, B, Q, R, beta) of one's own, in place of the five parameters above.

    Raises
    ------
    ModelError
        Where a parameter is out of its range.

    Examples
    --------
    >>> from ppinfer.goals import GoalDesign, infer_goals
    >>> model = GoalLQR(control_weight=4.64, rationality=0.5)
    >>> rng = np.random.default_rng(1)
    >>> evidence = model.simulate(GoalDesign.random(rng, rows=2, samples=30), rng)
    >>> belief = infer_goals(model, evidence)
    >>> belief.log_posterior.shape
    (60, 3)
    """

    name: ClassVar[str] = "goal-lqr"
    fitted: ClassVar[dict[str, str]] = {
        "control_weight": "log",
        "rationality": "log",
        "stay": "logit",
        "evidence_floor": "logit",
    }

    dynamics: str = "single-integrator"
    control_weight: float = 10.0
    state_weight: float = 1.0
    rationality: float = 0.002
    tempering: float = 1.0
    stay: float = 1.0
    evidence_floor: float = 0.0
    agent: NoisilyRational | None = None

    def __post_init__(self) -> None:
        for name in ("control_weight", "state_weight", "rationality", "tempering"):
            require_range(name, getattr(self, name), 0.0, LARGEST, open_low=True)
        require_range("stay", self.stay, 0.0, 1.0)
        require_range("evidence_floor", self.evidence_floor, 0.0, 1.0, open_high=True)
        if self.agent is None:
            Dynamics.named(self.dynamics, 1.0)

    def agent_at(self, dt: float, dimensions: int = 2) -> NoisilyRational:
        """Return the agent for samples `dt` seconds apart.

        Raises
        ------
        ModelError
            Where dt is not positive and finite (a log whose rows hold one sample each has none).
        """
        if self.agent is not None:
            return self.agent
        return _agent(self.dynamics, dt, dimensions, self.state_weight, self.control_weight, self.rationality)

    def log_likelihood(self, evidence: GoalEvidence) -> Factor:
        """Return log L_t(theta) for every sample, zero where a sample tells nothing."""
        return self.assess(evidence).log_likelihood

    def assess(self, evidence: GoalEvidence) -> Assessment:
        """Return the likelihood, and how states and controls were obtained."""
        squares, agent, motion = self.squared_residuals(evidence)
        log_likelihood = self.evidence_of(squares, motion.informative, agent)
        return Assessment(evidence.likelihood_factor(log_likelihood), _describe(motion))

    def squared_residuals(
        self, evidence: GoalEvidence
    ) -> tuple[Float[np.ndarray, "sample goal"], NoisilyRational, Motion]:
        """Return e' S e, e being the control less the best one towards each goal, with the agent and its motion.

        They are zero where a sample tells nothing, and the same for every rationality.
        """
        from ppinfer.goals.scans import squared_residuals

        agent, motion = self._agent_and_motion(evidence)
        squares = np.empty((evidence.samples, len(evidence.goal_labels)))
        squared_residuals(
            motion.control + motion.state @ agent.K.T,
            motion.informative,
            evidence.row_size,
            _best_offsets(agent, evidence),
            agent.S,
            squares,
        )
        return squares, agent, motion

    def evidence_of(
        self,
        squares: Float[np.ndarray, "*sample goal"],
        informative: Bool[np.ndarray, "*sample"],
        agent: NoisilyRational,
    ) -> Float[np.ndarray, "*sample goal"]:
        """Return the log evidence for squared residuals e' S e under an agent; 0 where not informative."""
        exponent = squares * (-agent.rationality * self.tempering)
        floor = self.evidence_floor
        if floor > 0:
            # beside the floor nothing is left of exp(log f - 50); exponentials that underflow would take long
            np.maximum(exponent, math.log(floor) - 50.0, out=exponent)
            np.exp(exponent, out=exponent)
            exponent *= 1.0 - floor
            exponent += floor
            np.log(exponent, out=exponent)
        exponent += self.tempering * log_peak(agent)
        if not informative.all():
            exponent[~informative] = 0.0
        return exponent

    @property
    def is_cumulative(self) -> bool:
        """Whether the belief is a function of sums over the row: no evidence floor."""
        return self.evidence_floor == 0.0

    def describe_source(self, evidence: GoalEvidence) -> str:
        """Return how states and controls are obtained from this evidence."""
        return _describe(self._agent_and_motion(evidence.take_rows(np.array([0])), dt=evidence.dt)[1])

    def cumulative_log_posterior(
        self, evidence: GoalEvidence, log_prior: Float[np.ndarray, "row goal"]
    ) -> Float[np.ndarray, "sample goal"]:
        """Return the log belief (27) at every sample by sums that restart at each row, without a recursion.

        With z_t = u_t + K x_t, a = K theta and Z_t the sum of z over the t informative samples so far,

            log b_t(theta) = const + 2 beta Z_t' S a - beta t a' S a + log b_0(theta).

        z and a are taken relative to the mean goal of the row, which changes no belief and keeps the digits of logs
        whose origin is far away.
        """
        from ppinfer.goals.scans import cumulative_scores, normalise_rows

        agent, motion = self._agent_and_motion(evidence)
        best = _best_offsets(agent, evidence)
        reference = best.mean(axis=1)
        relative = best - reference[:, None]
        beta = self.tempering * agent.rationality
        slope = np.ascontiguousarray(2 * beta * (relative @ agent.S))
        price = 0.5 * np.einsum("rgm,rgm->rg", slope, relative)
        log_posterior = np.empty((evidence.samples, len(evidence.goal_labels)))
        weights = np.empty((BLOCK_SAMPLES, log_posterior.shape[1]))
        carried = np.zeros(2 + agent.dynamics.controls)
        row_stop = evidence.row_start + evidence.row_size
        for start in range(0, evidence.samples, BLOCK_SAMPLES):
            scores = log_posterior[start : start + BLOCK_SAMPLES]
            block = weights[: len(scores)]
            cumulative_scores(
                motion.state, motion.control, motion.informative, start, start + len(scores), row_stop,
                agent.K, slope, price, log_prior, reference, carried, scores, block,
            )  # fmt: skip
            np.exp(block, out=block)
            normalise_rows(scores, block)
        return log_posterior

    def online(self, dt: float) -> OnlineLikelihood:
        """Return the likelihood of one observation at a time."""
        from ppinfer.goals.lqr_online import OnlineLQR

        return OnlineLQR(self, dt)

    def simulate(self, design: GoalDesign, rng: np.random.Generator) -> GoalEvidence:
        """Return motion of the agent itself, states and controls logged; it starts at rest.

        Tempering, stay and the evidence floor correct how evidence is weighed; they have no part in the simulation.
        """
        agent = self.agent_at(design.dt, design.start.shape[1])
        dynamics = agent.dynamics
        state, control = roll_out(agent, dynamics.goal_states(design.start), design, rng)
        velocity = state[:, list(dynamics.velocity_index)] if dynamics.velocity_index else None
        return GoalEvidence(
            time=design.time,
            position=state[:, list(dynamics.position_index)],
            goals=design.goals,
            row_size=design.row_size,
            goal_labels=design.labels,
            velocity=velocity,
            control=control,
            control_order=dynamics.order,
            time_step=design.dt,
        )

    def _agent_and_motion(
        self, evidence: GoalEvidence, dt: float | None = None
    ) -> tuple[NoisilyRational, Motion]:
        step = evidence.dt if dt is None else dt
        if math.isnan(step):
            raise ModelError(
                "no row holds two samples, so the time step is unknown; give the evidence its time_step"
            )
        agent = self.agent_at(step, evidence.position.shape[1])
        return agent, causal_motion(evidence, agent.dynamics)


def _best_offsets(agent: NoisilyRational, evidence: GoalEvidence) -> Float[np.ndarray, "row goal m"]:
    """Return goal_gain theta for every goal; absent ones, whose positions may be anything, sit amid the others."""
    positions = evidence.goals
    present = evidence.goal_present
    if not present.all():
        there = present[..., None]
        middle = np.where(there, positions, 0.0).sum(axis=1) / present.sum(axis=1, keepdims=True)
        positions = np.where(there, positions, middle[:, None])
    best: np.ndarray = agent.dynamics.goal_states(positions) @ agent.goal_gain.T
    return best


def log_peak(agent: NoisilyRational) -> float:
    """Return the log of the density (22) at the best control."""
    _, log_determinant = np.linalg.slogdet(2 * agent.rationality * agent.S)
    return 0.5 * (float(log_determinant) - agent.dynamics.controls * math.log(2 * math.pi))


def _describe(motion: Motion) -> str:
    return f"velocity: {motion.velocity_source}; control: {motion.control_source}"


@lru_cache(maxsize=256)
def _agent(
    name: str, dt: float, dimensions: int, state_weight: float, control_weight: float, rationality: float
) -> NoisilyRational:
    dynamics = Dynamics.named(name, dt, dimensions=dimensions)
    return NoisilyRational.lqr(
        dynamics, state_weight=state_weight, control_weight=control_weight, rationality=rationality
    )
