"""The laws that every expert of goal-coupled obeys, to be run on one's own."""

from __future__ import annotations

import numpy as np

from ppinfer.distributions import Factor
from ppinfer.goals import GoalEvidence
from ppinfer.goals.coupled import Expert, GoalCoupled
from ppinfer.testing.goals import check_likelihood


def check_expert(expert: Expert, *, examples: int = 40) -> None:
    """Hold an expert to the laws, alone and as a factor; a broken one fails with the smallest evidence that shows it.

    The laws are those of `check_likelihood` for the model that the expert makes by itself (nothing from later samples;
    goals in any order; rows apart; absent goals change nothing; online equals offline), and: it is a factor over
    (sample, goal), finite exactly where a goal is present, that says nothing at dropouts if it gathers evidence; its
    parameters can be written down, and each that may be fitted has a scale that there is.

    Parameters
    ----------
    expert : Expert
        The expert.
    examples : int
        How many pieces of evidence to try on each law.

    Raises
    ------
    AssertionError
        Naming the law.

    Examples
    --------
    >>> from ppinfer.goals.coupled import Distance
    >>> check_expert(Distance(), examples=3)
    """
    from ppinfer.goals.fitting import SCALES

    unknown = set(expert.fitted) - set(expert.parameters)
    assert not unknown, f"fitted names {sorted(unknown)}, which the expert does not have"
    for name, scale in expert.fitted.items():
        assert scale in SCALES, f"{name} is fitted on a scale {scale!r}; expected one of {', '.join(SCALES)}"
    assert type(expert)(**expert.parameters) == expert, "the parameters do not say what the expert is"
    check_likelihood(GoalCoupled(experts=(expert,)), examples=examples, twin=False)
    check_relative_weights(expert, examples=examples)


def check_relative_weights(expert: Expert, *, examples: int = 40) -> None:
    """Check that the factor has the right axes, and is finite exactly where a goal is present.

    Examples
    --------
    >>> from ppinfer.goals.coupled import Lead
    >>> check_relative_weights(Lead(), examples=3)
    """
    from hypothesis import HealthCheck, given, settings

    from ppinfer.testing.evidence_strategies import goal_evidences

    @settings(
        derandomize=True,
        deadline=None,
        database=None,
        max_examples=examples,
        suppress_health_check=list(HealthCheck),
    )
    @given(evidence=goal_evidences(partners=2 if expert.needs_partner else 0))
    def holds(evidence: GoalEvidence) -> None:
        factor = expert.log_factor(evidence)
        assert isinstance(factor, Factor), f"log_factor returned {type(factor).__name__}, not a Factor"
        assert factor.axes == (evidence.sample_axis, evidence.goal_axis), (
            "a factor over (sample, goal) is expected"
        )
        present = evidence.goal_present[evidence.row_of_sample]
        assert (np.isfinite(factor.log_values) == present).all(), (
            "absent goals, and no others, are impossible"
        )
        if expert.gathers:
            silent = present & ~evidence.seen[:, None]
            assert (factor.log_values[silent] == 0).all(), (
                "an expert that gathers must say nothing at dropouts"
            )

    holds()
