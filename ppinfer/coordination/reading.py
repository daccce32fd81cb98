"""How motion is read as evidence: against the plans of which replan, at which samples, of whom."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np
from jaxtyping import Bool, Float, Int

from ppinfer.coordination.classes import log_class_likelihood
from ppinfer.coordination.plans import PlanSet
from ppinfer.coordination.situation import Motion

Observed = Literal["others", "all"]
"""Whose motion is compared with the plans: the other agents', or everybody's."""


@dataclass(frozen=True)
class Reading:
    """How distances between motion and plans become a likelihood over theta.

    Parameters
    ----------
    rationality : float
        lambda_alpha of (6), 1/rad.
    every : float or None
        Seconds between the samples that count, in executed steps; None: every sample, held or not.
    observed : {"others", "all"}
        Whose motion counts.
    velocities : bool
        Whether a state is position and velocity, or position alone.
    reanchor : bool
        Whether motion is compared with the plans of the last replan, or with those of the trial's first.
    average, skip_empty : bool
        See `log_class_likelihood`.
    contamination : float
        See `log_class_likelihood`.
    """

    rationality: float
    every: float | None
    observed: Observed
    velocities: bool
    reanchor: bool
    average: bool
    skip_empty: bool
    contamination: float

    def stride(self, dt: float) -> int:
        """Return how many steps lie between samples that count."""
        return 1 if self.every is None else max(1, round(self.every / dt))

    def counted(
        self, motion: Motion, *, first: bool
    ) -> tuple[Int[np.ndarray, " counted"], Int[np.ndarray, " counted"], int]:
        """Return the samples of a motion that count, the steps that led to each, and all steps.

        Steps are executed ones: a step that a safety stop held moves nobody along a plan. Samples count every `every`
        seconds; if the motion ended before, its last executed sample does. With `every` None all samples count, and
        the clock goes on in held steps too; the sample of the last replan counts only at the trial's first.
        """
        if self.every is None:
            index = np.arange(0 if first else 1, len(motion.held))
            return index, index, len(motion.held) - 1
        executed = np.flatnonzero(~motion.held[1:]) + 1
        stride = self.stride(motion.dt)
        if len(executed) < stride:
            return executed[-1:], np.full(min(len(executed), 1), len(executed)), len(executed)
        return executed[stride - 1 :: stride], np.arange(stride, len(executed) + 1, stride), len(executed)

    def watched(self, agents: int, ego: int) -> list[int]:
        """Return the agents whose motion counts."""
        return [agent for agent in range(agents) if agent != ego or self.observed == "all"]

    def log_likelihood(
        self,
        squared: Sequence[Float[np.ndarray, "replan _"] | None],
        classes: Bool[np.ndarray, "theta replan ..."],
        among: Bool[np.ndarray, "replan ..."],
        silent: Bool[np.ndarray, " replan"],
    ) -> Float[np.ndarray, "replan theta"]:
        """Return the likelihood of each theta from squared distances of each agent's motion to its plans.

        Parameters
        ----------
        squared : for each agent (replan, plan) float64, or None
            Squared Euclidean distance over the samples that count; None for an agent whose motion does not.
        classes, among : bool
            Of the games whose plans these are.
        silent : (replan,) bool
            Where nothing was seen.
        """
        replans, grid = len(among), among.ndim - 1
        total: Float[np.ndarray, "..."] | None = None
        for agent, of_plan in enumerate(squared):
            if of_plan is None:
                continue
            shape = (replans, *(of_plan.shape[1] if axis == agent else 1 for axis in range(grid)))
            total = of_plan.reshape(shape) if total is None else total + of_plan.reshape(shape)
        log_profile = np.zeros(among.shape)
        if total is not None:
            log_profile -= self.rationality * np.sqrt(total)
        likelihood = log_class_likelihood(
            log_profile.reshape(replans, -1),
            classes.reshape(len(classes), replans, -1),
            among.reshape(replans, -1),
            average=self.average,
            skip_empty=self.skip_empty,
            contamination=self.contamination,
        )
        if self.reanchor and silent.any():
            likelihood[silent] = 0.0
        return likelihood


@dataclass(frozen=True, eq=False)
class Anchor:
    """The plans that motion is compared with, and how far it has been from them since.

    Parameters
    ----------
    plans : sequence of PlanSet
        Of every agent.
    classes, equilibria : bool
        Of their game.
    squared : for each agent (plan,) float64, or None
        Squared distance so far of the agent's motion to each of its plans.
    steps : int
        Steps since.
    """

    plans: tuple[PlanSet, ...]
    classes: Bool[np.ndarray, "theta ..."]
    equilibria: Bool[np.ndarray, "..."]
    squared: tuple[Float[np.ndarray, "_"] | None, ...]
    steps: int = 0

    def after(self, motion: Motion, reading: Reading) -> tuple[Anchor, bool]:
        """Return the same plans after more motion, and whether anybody was seen in it."""
        sample, step, steps = reading.counted(motion, first=self.steps == 0)
        times = (self.steps + step) * motion.dt
        squared, seen = [], False
        for agent, far in enumerate(self.squared):
            if far is None or not len(sample):
                squared.append(far)
                continue
            state, when, these = motion.position[sample, agent], times, sample
            if np.isnan(state.sum()):
                known = ~np.isnan(state).any(axis=1)
                state, when, these = state[known], times[known], sample[known]
            if not len(when):
                squared.append(far)
                continue
            seen = True
            where, speed = self.plans[agent]._sampled(when)
            further = squared_norm(where - state)
            if reading.velocities:
                further = further + squared_norm(speed - motion.velocity[these, agent])
            squared.append(far + further)
        return replace(self, squared=tuple(squared), steps=self.steps + steps), seen


def squared_norm(difference: Float[np.ndarray, "plan time joint"]) -> Float[np.ndarray, " plan"]:
    """Return the sum of squares over times and joints."""
    flat = difference.reshape(len(difference), -1)
    result: np.ndarray = np.einsum("ij,ij->i", flat, flat)
    return result
