"""The laws that every goal model obeys, to be run on one's own."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np
from jaxtyping import Float

from ppinfer.distributions import Factor
from ppinfer.errors import PPInferError
from ppinfer.goals import GoalDesign, GoalEvidence, GoalModel, Observation, OnlineGoalBelief, infer_goals
from ppinfer.testing.laws import check_normalisation

if TYPE_CHECKING:
    Law = Callable[[GoalModel, GoalEvidence], None]

DT = 0.1
_RELATIVE = 1e-9


def check_likelihood(model: GoalModel, *, examples: int = 40, twin: bool = True, seed: int = 0) -> None:
    """Hold a goal model to the laws; a broken one fails with the smallest evidence that shows it.

    The laws: the answer is a factor over (sample, goal) that is zero (in log) at dropouts and impossible exactly where
    a goal is absent; no sample depends on a later one; goals may be listed in any order; rows do not touch each other;
    an absent goal changes nothing for the others; beliefs are normalised; the online belief equals the offline one at
    every sample. With `twin`, data simulated by the model itself are predicted with calibrated probabilities.

    Parameters
    ----------
    model : GoalModel
        The model.
    examples : int
        How many pieces of evidence to try on each law.
    twin : bool
        Whether the model claims to be generative: false for one that is tempered, whose goals switch, or that has no
        `simulate`.
    seed : int
        For the simulation.

    Raises
    ------
    AssertionError
        Naming the law; the note that Hypothesis adds shows the evidence, shrunk.
    PPInferError
        Where Hypothesis is not installed (``pip install 'ppinfer[test]'``).

    Examples
    --------
    >>> from ppinfer.goals import NearestGoal
    >>> check_likelihood(NearestGoal(scale=2.0), examples=5)
    """
    try:
        from hypothesis import HealthCheck, Phase, given, settings
    except ImportError as error:
        raise PPInferError("check_likelihood needs Hypothesis: pip install 'ppinfer[test]'") from error
    from ppinfer.testing.evidence_strategies import goal_evidences

    quiet = settings(
        derandomize=True,
        deadline=None,
        database=None,
        max_examples=examples,
        # which parts of a counter-example do not matter is not worth the time it takes
        phases=[Phase.explicit, Phase.generate, Phase.shrink],
        suppress_health_check=list(HealthCheck),
    )
    for law in LAWS:

        def holds(evidence: GoalEvidence) -> None:
            law(model, evidence)  # noqa: B023 - called within this turn of the loop

        quiet(given(evidence=goal_evidences(partners=2 if model.needs_partner else 0))(holds))()
    if twin:
        check_generative_twin(model, np.random.default_rng(seed))


def check_factor(model: GoalModel, evidence: GoalEvidence) -> None:
    """Check axes, zeros at dropouts, and -inf exactly where a goal is absent.

    Examples
    --------
    >>> from ppinfer.goals import NearestGoal
    >>> check_factor(NearestGoal(), example_evidence())
    """
    factor = model.log_likelihood(evidence)
    assert isinstance(factor, Factor), f"log_likelihood returned {type(factor).__name__}, not a Factor"
    assert factor.axes == (evidence.sample_axis, evidence.goal_axis), (
        f"log_likelihood is a factor over {[axis.name for axis in factor.axes]} with shape {factor.shape}; expected "
        f"(sample, goal) with the evidence's labels"
    )
    present = evidence.goal_present[evidence.row_of_sample]
    values = factor.log_values
    instant = model.assess(evidence).instant
    if instant is not None:
        assert instant.axes == factor.axes, (
            "what holds at an instant must be a factor over (sample, goal) too"
        )
        possible = np.isfinite(instant.log_values)
        assert (possible == present).all(), "an instant may rule out absent goals, all of them, and no others"
    assert (values[~present] == -np.inf).all(), "an absent goal must be impossible (-inf)"
    assert np.isfinite(values[present]).all(), "a goal that is present must not be impossible (-inf) or NaN"
    silent = present & ~evidence.seen[:, None]
    assert (values[silent] == 0).all(), "a dropout must tell nothing (log likelihood 0)"


def check_causality(model: GoalModel, evidence: GoalEvidence) -> None:
    """Check that what a sample tells does not change when the samples after it are taken away.

    Examples
    --------
    >>> from ppinfer.goals import NearestGoal
    >>> check_causality(NearestGoal(), example_evidence())
    """
    whole = model.assess(evidence)
    cut = np.maximum(1, evidence.row_size // 2)
    index = np.arange(evidence.samples) - evidence.row_start[evidence.row_of_sample]
    kept = index < cut[evidence.row_of_sample]
    early = model.assess(evidence.take_beginnings(cut))
    _assert_close(
        early.log_likelihood.log_values,
        whole.log_likelihood.log_values[kept],
        "a sample's likelihood depends on later samples",
    )
    if early.instant is not None and whole.instant is not None:
        _assert_close(
            early.instant.log_values,
            whole.instant.log_values[kept],
            "what holds at an instant depends on later samples",
        )


def check_goal_order(model: GoalModel, evidence: GoalEvidence) -> None:
    """Check that listing the goals in another order permutes the belief and changes nothing else.

    Examples
    --------
    >>> from ppinfer.goals import NearestGoal
    >>> check_goal_order(NearestGoal(), example_evidence())
    """
    order = np.arange(len(evidence.goal_labels))[::-1]
    turned = replace(
        evidence,
        goals=evidence.goals[:, order],
        present=None if evidence.present is None else evidence.present[:, order],
        goal_labels=tuple(evidence.goal_labels[goal] for goal in order),
    )
    for mode in ("filter", "smooth"):
        _assert_close(
            infer_goals(model, turned, mode=mode).log_posterior,
            infer_goals(model, evidence, mode=mode).log_posterior[:, order],
            f"the {mode}ed belief depends on the order in which goals are listed",
        )


def check_rows_apart(model: GoalModel, evidence: GoalEvidence) -> None:
    """Check that many rows at once give what each row gives alone.

    Examples
    --------
    >>> from ppinfer.goals import NearestGoal
    >>> check_rows_apart(NearestGoal(), example_evidence())
    """
    together = infer_goals(model, evidence).log_posterior
    alone = [
        infer_goals(model, evidence.take_rows(np.array([row]))).log_posterior for row in range(evidence.rows)
    ]
    _assert_close(np.concatenate(alone), together, "a row's belief depends on the rows beside it")


def check_absent_goals(model: GoalModel, evidence: GoalEvidence) -> None:
    """Check that a goal that is absent throughout might as well not be listed.

    Examples
    --------
    >>> from ppinfer.goals import NearestGoal
    >>> check_absent_goals(NearestGoal(), example_evidence())
    """
    anywhere = np.append(np.ones(len(evidence.goal_labels), dtype=bool), False)
    widened = replace(
        evidence,
        goals=np.concatenate([evidence.goals, np.full_like(evidence.goals[:, :1], 3.0)], axis=1),
        present=np.concatenate([evidence.goal_present, np.zeros((evidence.rows, 1), dtype=bool)], axis=1),
        goal_labels=(*evidence.goal_labels, "never there"),
    )
    belief = infer_goals(model, widened).log_posterior
    assert (belief[:, -1] == -np.inf).all(), "an absent goal has probability above zero"
    _assert_close(
        belief[:, anywhere],
        infer_goals(model, evidence).log_posterior,
        "an absent goal changes the belief in the others",
    )


def check_belief(model: GoalModel, evidence: GoalEvidence) -> None:
    """Check that filtered and smoothed beliefs are normalised, and agree at the end of every row.

    Examples
    --------
    >>> from ppinfer.goals import NearestGoal
    >>> check_belief(NearestGoal(), example_evidence())
    """
    filtered, smoothed = (
        infer_goals(model, evidence, mode=mode).distribution for mode in ("filter", "smooth")
    )
    for belief in (filtered, smoothed):
        check_normalisation(belief)
    last = evidence.row_start + evidence.row_size - 1
    _assert_close(
        smoothed.log_values[last], filtered.log_values[last], "filter and smoother differ at the end of a row"
    )


def check_online(model: GoalModel, evidence: GoalEvidence) -> None:
    """Check that the belief a robot holds, one observation at a time, equals the offline one at every sample.

    Examples
    --------
    >>> from ppinfer.goals import NearestGoal
    >>> check_online(NearestGoal(), example_evidence())
    """
    offline = infer_goals(model, evidence).log_posterior
    belief = OnlineGoalBelief(model, dt=evidence.dt, labels=evidence.goal_labels)
    online = np.empty_like(offline)
    for row, (start, size) in enumerate(zip(evidence.row_start, evidence.row_size, strict=True)):
        belief.restart(evidence.goals[row], present=evidence.goal_present[row])
        for sample in range(start, start + size):
            online[sample] = belief.observe(
                float(evidence.time[sample]),
                evidence.position[sample] if evidence.seen[sample] else None,
                velocity=None if evidence.velocity is None else evidence.velocity[sample],
                control=None if evidence.control is None else evidence.control[sample],
                control_order=evidence.control_order,
                partners=partners_at(evidence, sample),
            ).log_values
    _assert_close(online, offline, "the online belief differs from the offline one")


def partners_at(evidence: GoalEvidence, sample: int) -> tuple[Observation, ...]:
    """Return what was seen of the partners at a sample, as an online belief takes it.

    Examples
    --------
    >>> partners_at(example_evidence(), 0)
    ()
    """
    return tuple(
        Observation(
            float(evidence.time[sample]),
            partner.position[sample] if partner.seen[sample] else None,
            None if partner.velocity is None else partner.velocity[sample],
            None if partner.control is None else partner.control[sample],
            partner.control_order,
        )
        for partner in evidence.partners
    )


def check_generative_twin(
    model: GoalModel, rng: np.random.Generator, *, rows: int = 400, samples: int = 12
) -> None:
    """Check that the model predicts its own simulations with calibrated probabilities.

    Where goals are drawn from the prior and motion from the model, the probability b(goal pursued) has the mean of
    sum_g b(g)^2, whatever the motion; their difference is compared with its own standard error (5 of them), after a few
    samples and at the end. A scale that is off by a tenth or so does not show; by a half, it does.

    Raises
    ------
    AssertionError
        Where the difference is too large.

    Examples
    --------
    >>> from ppinfer.goals import NearestGoal
    >>> check_generative_twin(NearestGoal(scale=2.0), np.random.default_rng(0))
    """
    design = GoalDesign.random(rng, rows=rows, goals=3, samples=samples, dt=DT)
    try:
        evidence = model.simulate(design, rng)
    except NotImplementedError:
        raise AssertionError(
            "the model has no simulate; check_likelihood(model, twin=False) leaves it out"
        ) from None
    probability = np.exp(infer_goals(model, evidence).log_posterior)
    for after in (2, samples // 2, samples):
        belief = probability[evidence.row_start + after - 1]
        surplus = belief[np.arange(rows), design.true_goal] - (belief**2).sum(axis=1)
        error = surplus.std(ddof=1) / np.sqrt(rows)
        assert abs(surplus.mean()) <= 5 * error + 1e-9, (
            f"after {after} samples simulated by the model, the goal pursued has probability "
            f"{surplus.mean():+.4f} away from what calibration asks for (standard error {error:.4f}): log_likelihood "
            "and simulate do not describe the same agent"
        )


LAWS: Sequence[Law] = (
    check_factor,
    check_rows_apart,
    check_causality,
    check_goal_order,
    check_absent_goals,
    check_belief,
    check_online,
)


def example_evidence() -> GoalEvidence:
    """Return a little evidence: one row of three samples, two goals, seen throughout.

    Examples
    --------
    >>> example_evidence().samples
    3
    """
    return GoalEvidence(
        time=np.arange(3) * DT,
        position=np.array([[0.0, 0.0], [0.1, 0.0], [0.3, 0.1]]),
        goals=np.array([[[2.0, 0.0], [0.0, 2.0]]]),
        row_size=np.array([3]),
        goal_labels=("cup", "bowl"),
        time_step=DT,
    )


def _assert_close(
    ours: Float[np.ndarray, "*shape"], theirs: Float[np.ndarray, "*shape"], message: str
) -> None:
    assert ours.shape == theirs.shape, f"{message} (shapes {ours.shape} and {theirs.shape})"
    possible = np.isfinite(theirs)
    assert (np.isfinite(ours) == possible).all(), f"{message}: what is possible differs"
    if not possible.any():
        return
    scale = 1.0 + float(np.abs(theirs[possible]).max())
    gap = np.where(possible, np.abs(np.where(possible, ours, 0.0) - np.where(possible, theirs, 0.0)), 0.0)
    sample, goal = (int(i) for i in np.unravel_index(int(gap.argmax()), gap.shape))
    mine, other = float(ours[sample, goal]), float(theirs[sample, goal])
    assert gap.max() <= _RELATIVE * scale, (
        f"{message}: {mine!r} against {other!r} at sample {sample}, goal {goal}"
    )
