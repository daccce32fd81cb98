"""The laws that norms, personalities and policies obey, to be run on one's own."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from ppinfer.coordination import (
    Norm,
    PersonalityModel,
    PlayDesign,
    PlayHistory,
    Policy,
    infer_personality,
)
from ppinfer.errors import PPInferError
from ppinfer.testing.coordination_laws import (
    check_beliefs,
    check_decisions,
    check_norm_in,
    check_plan_order,
    check_plan_order_of_beliefs,
)
from ppinfer.testing.example_play import example_trial

if TYPE_CHECKING:
    from hypothesis.strategies import SearchStrategy


def check_policy(
    policy: Policy, *, examples: int = 40, agents: Sequence[int] = (2, 3), relabelling: bool = True
) -> None:
    """Hold a policy to the laws; a broken one fails with the smallest trial that shows it.

    The laws, for every ego through whole trials, with plans that tie, sets of one plan, games in which everybody
    collides, and agents who have left: the plan is one of ego's and has a probability above zero; the distribution is
    over the profiles or over ego's plans and sums to one; beliefs sum to one; the same situation and memory give the
    same decision, and neither is changed; a policy that is given its memory needs nothing else. With `relabelling`,
    listing plans in another order permutes the distribution and nothing else.

    Parameters
    ----------
    policy : Policy
        The policy.
    examples : int
        How many trials to try on each law.
    agents : sequence of int
        How many agents there may be.
    relabelling : bool
        False for a policy that draws plans by their numbers.

    Raises
    ------
    AssertionError
        Saying which law; the note that Hypothesis adds shows the trial, shrunk.
    PPInferError
        Where Hypothesis is not installed (``pip install 'ppinfer[test]'``).

    Examples
    --------
    >>> from ppinfer.coordination import Selfish
    >>> check_policy(Selfish(), examples=5)
    """
    from ppinfer.testing.play_strategies import play_trials

    trials = play_trials(agents=tuple(agents))
    _run(lambda trial: check_decisions(policy, trial), trials, examples)
    if relabelling:
        _run(lambda trial: check_plan_order(policy, trial), trials, examples)


def check_norm(norm: Norm, *, examples: int = 40, agents: Sequence[int] = (2, 3)) -> None:
    """Hold a norm to the laws; a broken one fails with the smallest situation that shows it.

    The laws: its distribution sums to one and is zero outside the profiles to choose among; many games at once give
    what each gives alone; listing plans in another order permutes it and nothing else.

    Parameters
    ----------
    norm : Norm
        The norm.
    examples : int
        How many situations to try.
    agents : sequence of int
        How many agents there may be.

    Raises
    ------
    AssertionError
        Saying which law; the note that Hypothesis adds shows the situation, shrunk.
    PPInferError
        Where Hypothesis is not installed (``pip install 'ppinfer[test]'``).

    Examples
    --------
    >>> from ppinfer.coordination import MinNorm
    >>> check_norm(MinNorm(), examples=5)
    """
    from ppinfer.testing.play_strategies import situations

    _run(lambda situation: check_norm_in(norm, situation), situations(agents=tuple(agents)), examples)


def check_personality(
    model: PersonalityModel,
    *,
    examples: int = 30,
    agents: Sequence[int] = (2, 3),
    relabelling: bool = True,
    twin: bool = True,
    seed: int = 0,
) -> None:
    """Hold a model of personality to the laws; a broken one fails with the smallest history that shows it.

    The laws: beliefs sum to one; what is believed replan by replan is what is inferred from the whole history, to
    1e-10, so that nothing later counts; trials do not touch each other; p_alpha sums to one over the equilibria. With
    `relabelling`, the order in which plans are listed does not matter. With `twin`, motion that the model itself
    simulates is judged with calibrated probabilities.

    Parameters
    ----------
    model : PersonalityModel
        The model.
    examples : int
        How many histories to try on each law.
    agents : sequence of int
        How many agents there may be.
    relabelling : bool
        False for a model that draws plans by their numbers.
    twin : bool
        Whether the model claims to be generative: false for one that has no `simulate`.
    seed : int
        For the simulation.

    Raises
    ------
    AssertionError
        Saying which law; the note that Hypothesis adds shows the history, shrunk.
    PPInferError
        Where Hypothesis is not installed (``pip install 'ppinfer[test]'``).

    Examples
    --------
    >>> from ppinfer.coordination import Personality
    >>> check_personality(Personality(), examples=5, twin=False)
    """
    from hypothesis import strategies as st

    from ppinfer.testing.play_strategies import play_trials

    alike = st.sampled_from(list(agents)).flatmap(
        lambda count: st.lists(play_trials(agents=(count,)), min_size=1, max_size=3)
    )
    _run(lambda trials: check_beliefs(model, trials), alike, examples)
    if relabelling:
        _run(lambda trials: check_plan_order_of_beliefs(model, trials), alike, examples)
    if twin:
        check_personality_twin(model, np.random.default_rng(seed))


def check_personality_twin(
    model: PersonalityModel, rng: np.random.Generator, *, trials: int = 300, replans: int = 6
) -> None:
    """Check that a model of personality judges its own simulations with calibrated probabilities.

    Where theta is drawn evenly, moves by the model's own transition, and motion is drawn from the model, the
    probability b(true theta) has the mean of sum b^2, whatever the games; their difference is compared with its own
    standard error (5 of them), at a few replans of the trial.

    Parameters
    ----------
    model : PersonalityModel
        Whose evidence is generated with theta even at first.
    rng : numpy.random.Generator
        The source of randomness.
    trials, replans : int
        How many.

    Raises
    ------
    AssertionError
        Where the difference is too large.

    Examples
    --------
    >>> from ppinfer.coordination import Personality
    >>> check_personality_twin(Personality(), np.random.default_rng(0), trials=100)
    """
    history = PlayHistory.from_situations(
        [example_trial(rng, replans=replans, plans=(5, 5), colliding=0.6, held=0.0) for _ in range(trials)],
        "robot",
    )
    evidence = history.seen_by("robot")
    count = len(model.theta(history.agents))
    theta = rng.integers(count, size=(trials, replans))
    for replan in range(1, replans):
        moves = rng.random(trials) >= model.stay if model.accumulates() else np.zeros(trials, bool)
        other = (theta[:, replan - 1] + rng.integers(1, count, trials)) % count
        theta[:, replan] = np.where(moves, other, theta[:, replan - 1])
    try:
        seen = model.simulate(PlayDesign(evidence, theta.ravel()), rng)
    except NotImplementedError:
        raise AssertionError(
            "the model has no simulate; check_personality(model, twin=False) leaves it out"
        ) from None
    belief = np.exp(infer_personality(model, seen.history, "robot").log_values).reshape(
        trials, replans, count
    )
    for replan in (1, replans // 2, replans - 1):
        # what was seen last before a replan speaks of how the others acted since the one before
        acting = theta[:, replan - 1]
        held = belief[:, replan]
        surplus = held[np.arange(trials), acting] - (held**2).sum(axis=1)
        error = surplus.std(ddof=1) / np.sqrt(trials)
        assert abs(surplus.mean()) <= 5 * error + 1e-9, (
            f"at replan {replan} of trials simulated by the model, the true personality has probability "
            f"{surplus.mean():+.4f} away from what calibration asks for (standard error {error:.4f}): log_likelihood "
            "and simulate do not describe the same agent"
        )


def _run(law: Callable[[Any], None], strategy: SearchStrategy[Any], examples: int) -> None:
    """Try a law on what a strategy draws, the same every time."""
    try:
        from hypothesis import HealthCheck, given, settings
    except ImportError as error:
        raise PPInferError("the laws of coordination need Hypothesis: pip install 'ppinfer[test]'") from error
    quiet = settings(
        derandomize=True,
        deadline=None,
        database=None,
        max_examples=examples,
        suppress_health_check=list(HealthCheck),
    )

    def holds(drawn: Any) -> None:
        law(drawn)

    quiet(given(drawn=strategy)(holds))()
