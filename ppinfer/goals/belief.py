"""Beliefs over goals at every sample of a log: Bayes' rule (27), with goals that may change."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Literal, Protocol, runtime_checkable

import numpy as np
from jaxtyping import Bool, Float, Int

from ppinfer.distributions import Distribution, forward_filter, smooth
from ppinfer.errors import ImpossibleEvidenceError, ModelError
from ppinfer.goals.evidence import GoalEvidence
from ppinfer.goals.model import GoalModel
from ppinfer.goals.priors import log_priors
from ppinfer.goals.switching import row_transitions

Mode = Literal["filter", "smooth"]


@runtime_checkable
class CumulativeModel(Protocol):
    """A model whose filtered belief, for goals that never switch, needs sums over a row and no recursion."""

    @property
    def is_cumulative(self) -> bool:
        """Whether these parameters allow the cumulative form."""

    def cumulative_log_posterior(
        self, evidence: GoalEvidence, log_prior: Float[np.ndarray, "row goal"]
    ) -> Float[np.ndarray, "sample goal"]:
        """Return the log belief at every sample."""

    def describe_source(self, evidence: GoalEvidence) -> str:
        """Return how states and controls were obtained."""


@dataclass(frozen=True, eq=False)
class GoalBelief:
    """The belief over goals at every sample, with what a reader should know of how it came about.

    Parameters
    ----------
    distribution : Distribution
        Random in `goal`, one for each `sample`.
    state_source : str
        How velocities and controls were obtained.
    outliers : (sample,) bool or None
        Samples that a model set aside as outliers.
    """

    distribution: Distribution
    state_source: str
    outliers: Bool[np.ndarray, " sample"] | None = None

    @property
    def log_posterior(self) -> Float[np.ndarray, "sample goal"]:
        """Log probabilities, -inf for goals that are absent."""
        return self.distribution.log_values


def infer_goals(
    model: GoalModel,
    evidence: GoalEvidence,
    *,
    mode: Mode = "filter",
    prior: Any = None,
) -> GoalBelief:
    """Return the belief over goals at every sample of the evidence, all rows in one array program.

    Parameters
    ----------
    model : GoalModel
        The likelihood; its ``stay`` is the probability per sample that a goal stays what it is.
    evidence : GoalEvidence
        Rows restart exactly, except those that `evidence.continues` marks: they begin with the last belief of the row
        before them, carried over goal by goal.
    mode : {"filter", "smooth"}
        Given the samples so far (what a robot knows at that instant), or given the whole row. What a model makes of
        each instant by itself (`Assessment`) multiplies the filtered or the smoothed belief alike.
    prior : (goal,) or (row, goal) array of float, optional
        Probabilities at the start of each row; default: even over the goals present.

    Raises
    ------
    ImpossibleEvidenceError
        Where every goal is ruled out; the message names trial and sample.
    ModelError
        Where the mode is unknown, a prior is not a distribution over the goals present, or the model needs other
        agents and the evidence has none.

    Examples
    --------
    >>> from ppinfer.goals import GoalDesign, GoalLQR
    >>> model = GoalLQR(rationality=2.0)
    >>> rng = np.random.default_rng(0)
    >>> evidence = model.simulate(GoalDesign.random(rng, rows=5), rng)
    >>> infer_goals(model, evidence).distribution.random
    ('goal',)
    """
    if mode not in ("filter", "smooth"):
        raise ModelError(f"unknown mode {mode!r}: expected 'filter' or 'smooth'")
    log_prior = log_priors(evidence.goal_present, prior, name_row=evidence.row_name)
    carried = evidence.continues is not None and bool(evidence.continues.any())
    plain = model.stay == 1.0 and not model.memoryless
    outliers = None
    if (
        isinstance(model, CumulativeModel)
        and plain
        and model.is_cumulative
        and mode == "filter"
        and not carried
    ):
        log_posterior = model.cumulative_log_posterior(evidence, log_prior)
        source = model.describe_source(evidence)
    else:
        if model.needs_partner and not evidence.partners:
            raise ModelError(lacks_partner(model, evidence.agent))
        assessment = model.assess(evidence)
        source, outliers = assessment.state_source, assessment.outliers
        rows = _Rows.of(evidence)
        log_transition = which = None
        if carried or not plain:
            log_transition, which = row_transitions(
                log_prior[rows.origin],
                evidence.goal_present[rows.origin],
                model.stay,
                memoryless=model.memoryless,
                redraws=model.redraws,
                appeared=rows.appeared,
            )
        run = forward_filter if mode == "filter" else smooth
        log_posterior = run(
            assessment.log_likelihood.log_values,
            rows.row_size,
            log_prior[rows.origin],
            log_transition,
            which,
            rows.continues,
            describe=evidence.describe_sample,
        )
        if assessment.instant is not None:
            from ppinfer.goals.coupled.scans import weigh

            lost = weigh(log_posterior, assessment.instant.log_values)
            if lost >= 0:
                raise ImpossibleEvidenceError(f"{evidence.describe_sample(lost)}: every goal is ruled out")
    axes = (evidence.sample_axis, evidence.goal_axis)
    belief = Distribution._sound(axes, log_posterior, ("batch", "random"))
    return GoalBelief(belief, source, outliers)


def lacks_partner(model: GoalModel, agent: str) -> str:
    """Return what to tell somebody whose evidence is about one agent alone."""
    return (
        f"model {model.name!r} looks at what other agents do, and the evidence is of {agent!r} alone: give it a "
        "partner, or leave out what needs one (goal-coupled: --set experts=motion,distance)"
    )


@dataclass(frozen=True, eq=False)
class _Rows:
    """The rows of a filter: the evidence's, the first sample apart where a goal appears in a carried row."""

    row_size: Int[np.ndarray, " row"]
    continues: Bool[np.ndarray, " row"] | None
    origin: Int[np.ndarray, " row"]
    appeared: Bool[np.ndarray, "row goal"] | None

    @classmethod
    def of(cls, evidence: GoalEvidence) -> _Rows:
        carried = evidence.continues
        if carried is None or not carried.any():
            return cls(evidence.row_size, None, np.arange(evidence.rows), None)
        present = evidence.goal_present
        before = np.concatenate([present[:1], present[:-1]])
        new = present & ~before & carried[:, None]
        # the transition into a row is not the one within it, so its first sample becomes a row of its own
        apart = new.any(axis=1) & (evidence.row_size > 1)
        origin = np.repeat(np.arange(evidence.rows), 1 + apart)
        second = np.concatenate([[False], origin[1:] == origin[:-1]])
        first_apart = apart[origin] & ~second
        row_size = np.where(first_apart, 1, evidence.row_size[origin] - second)
        return cls(row_size, carried[origin] | second, origin, new[origin] & ~second[:, None])
