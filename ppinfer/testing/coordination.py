"""The laws that norms, personalities and policies obey, to be run on one's own."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from jaxtyping import Float

from ppinfer.coordination import (
    Decision,
    Norm,
    PersonalityModel,
    PlayDesign,
    PlayHistory,
    Policy,
    Situation,
    coordination_equilibria,
    infer_personality,
)
from ppinfer.distributions import Axis, Distribution, Factor
from ppinfer.errors import ImpossibleEvidenceError, PPInferError
from ppinfer.games import Game
from ppinfer.testing.example_play import example_trial
from ppinfer.testing.laws import check_normalisation

if TYPE_CHECKING:
    from hypothesis.strategies import SearchStrategy

Trial = list[Situation]

_CLOSE = 1e-9
_SAME = 1e-10


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
    _run(lambda trial: _check_decisions(policy, trial), trials, examples)
    if relabelling:
        _run(lambda trial: _check_plan_order(policy, trial), trials, examples)


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

    _run(lambda situation: _check_norm(norm, situation), situations(agents=tuple(agents)), examples)


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
    _run(lambda trials: _check_beliefs(model, trials), alike, examples)
    if relabelling:
        _run(lambda trials: _check_plan_order_of_beliefs(model, trials), alike, examples)
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
        [example_trial(rng, replans=replans, plans=(5, 5), colliding=0.6, held=0.0) for _ in range(trials)], "robot"
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


# policies


def _check_decisions(policy: Policy, trial: Trial) -> None:
    for ego in trial[0].agents[:2]:
        memory: Any = None
        for situation in trial:
            before = _fingerprint(situation)
            decision = policy.decide(situation, ego, memory)
            again = policy.decide(situation, ego, memory)
            _check_decision(decision, situation, ego)
            assert (decision.plan, decision.profile) == (again.plan, again.profile), (
                f"{policy.name}: the same situation and memory gave {decision} and then {again}: decide must be a pure "
                "function, and what it learns travels in Decision.memory"
            )
            assert decision.distribution == again.distribution, (
                f"{policy.name}: the same situation and memory gave two distributions: decide must be a pure function"
            )
            assert _fingerprint(situation) == before, f"{policy.name} changed the situation that it was given"
            memory = decision.memory


def _check_decision(decision: Decision, situation: Situation, ego: str) -> None:
    player = situation.player(ego)
    own = situation.plans[player]
    assert isinstance(decision.plan, int), f"the plan is {decision.plan!r}, not an int"
    assert 0 <= decision.plan < len(own), f"plan {decision.plan} is none of {ego}'s {len(own)} plans"
    distribution = decision.distribution
    assert isinstance(distribution, Distribution), f"the distribution is a {type(distribution).__name__}"
    allowed = ({own.axis}, set(situation.game.plans))
    assert set(distribution.axes) in allowed, (
        f"the distribution is over {', '.join(distribution.names)}; expected the plan axes of the game, or ego's own"
    )
    check_normalisation(distribution)
    probability = distribution.prob(**{own.axis.name: decision.plan})
    assert np.all(np.asarray(probability) > 0.0), (
        f"plan {decision.plan} was chosen, but the distribution gives it no probability"
    )
    if decision.profile is not None:
        sizes = [len(one) for one in situation.plans]
        fits = (
            len(decision.profile) == len(sizes)
            and all(0 <= plan < size for plan, size in zip(decision.profile, sizes, strict=True))
            and decision.profile[player] == decision.plan
        )
        assert fits, (
            f"profile {decision.profile} does not fit plan {decision.plan} of {ego} among {sizes} plans"
        )
    for belief in (decision.belief, decision.predictive):
        if belief is not None:
            check_normalisation(belief)


def _check_plan_order(policy: Policy, trial: Trial) -> None:
    turned = _turned(trial)
    for ego in trial[0].agents[:2]:
        memory: Any = None
        other_memory: Any = None
        for situation, other in zip(trial, turned, strict=True):
            decision = policy.decide(situation, ego, memory)
            permuted = policy.decide(other, ego, other_memory)
            back = {f"{own.agent}_plan": _order(len(own)) for own in situation.plans}
            expected = decision.distribution
            for name in expected.names:
                expected = _reordered(expected, name, back[name])
            _assert_close(
                permuted.distribution.values,
                expected.values,
                f"{policy.name}: plans listed in another order give another distribution",
            )
            memory, other_memory = decision.memory, permuted.memory


def _reordered(distribution: Distribution, name: str, order: list[int]) -> Distribution:
    axis = distribution.names.index(name)
    values = distribution.log_values.take(order, axis=axis)
    return Distribution(distribution.axes, values)


def _order(count: int) -> list[int]:
    """Return a fixed order of some plans, which moves each of them if there are several."""
    return [*range(1, count), 0]


def _turned(trial: Trial) -> Trial:
    """Return the same trial with every agent's plans in another order."""
    return [
        situation.restrict({own.agent: _order(len(own)) for own in situation.plans}) for situation in trial
    ]


def _fingerprint(situation: Situation) -> tuple[bytes, ...]:
    arrays = [situation.game.costs]
    for own in situation.plans:
        arrays += [own.row_size, own.time, own.position]
    if situation.motion is not None:
        arrays += [situation.motion.position, situation.motion.velocity, situation.motion.held]
    return tuple(np.ascontiguousarray(array).tobytes() for array in arrays)


# norms


def _check_norm(norm: Norm, situation: Situation) -> None:
    game = situation.game
    among = coordination_equilibria(game)
    if not (among.log_values > -np.inf).any():
        try:
            norm.probabilities(game, among)
        except ImpossibleEvidenceError:
            return
        raise AssertionError(
            "a game without equilibria has no distribution: expected an ImpossibleEvidenceError"
        )
    p = norm.probabilities(game, among)
    check_normalisation(p)
    assert p.axes == game.axes, (
        f"the norm's distribution is over {p.names}; expected {[a.name for a in game.axes]}"
    )
    outside = (among.log_values == -np.inf) & (p.log_values > -np.inf)
    assert not outside.any(), "a profile that is not to be chosen has a probability above zero"
    turned = situation.restrict({own.agent: _order(len(own)) for own in situation.plans}).game
    expected = p
    for axis in game.plans:
        expected = _reordered(expected, axis.name, _order(len(axis)))
    _assert_close(
        norm.probabilities(turned, coordination_equilibria(turned)).values,
        expected.values,
        "plans listed in another order give another distribution",
    )
    # the same game with other plans' costs, beside it
    dearer = game.costs + 1.0
    batch = Axis("game", 3)
    several = Game(np.stack([game.costs, dearer, game.costs]), game.players, game.plans, [batch])
    together = norm.probabilities(several, coordination_equilibria(several))
    beside = Game(dearer, game.players, game.plans)
    alone = norm.probabilities(beside, coordination_equilibria(beside))
    _assert_close(
        together.values,
        np.stack([p.values, alone.values, p.values]),
        "many games at once give other distributions than each of them alone",
    )


# personalities


def _check_beliefs(model: PersonalityModel, trials: list[Trial]) -> None:
    for ego in trials[0][0].agents[:2]:
        history = PlayHistory.from_situations(trials, ego)
        likelihood = model.log_likelihood(history.seen_by(ego))
        assert isinstance(likelihood, Factor), (
            f"log_likelihood returned a {type(likelihood).__name__}, not a Factor"
        )
        axes = {history.seen_by(ego).replan_axis, model.theta(history.agents)}
        assert set(likelihood.axes) == axes, (
            f"log_likelihood is a factor over {likelihood.names}; expected (replan, theta) with the evidence's labels"
        )
        offline = infer_personality(model, history, ego)
        check_normalisation(offline)
        online = []
        for trial in trials:
            state = None
            for situation in trial:
                state = model.observe(situation, ego, state)
                online.append(state.log_belief)
                if state.equilibria.any():
                    check_normalisation(state.p_alpha)
        _assert_close(
            np.stack(online), offline.log_values, "what is believed online differs from offline", _SAME
        )
        alone = [
            infer_personality(model, PlayHistory.from_situations([trial], ego), ego).log_values
            for trial in trials
        ]
        _assert_close(
            np.concatenate(alone), offline.log_values, "a trial's belief depends on the trials beside it"
        )


def _check_plan_order_of_beliefs(model: PersonalityModel, trials: list[Trial]) -> None:
    plain, turned = (
        infer_personality(model, PlayHistory.from_situations(some, "robot"), "robot").log_values
        for some in (trials, [_turned(trial) for trial in trials])
    )
    _assert_close(turned, plain, "plans listed in another order give another belief")


def _assert_close(
    ours: Float[np.ndarray, "..."], theirs: Float[np.ndarray, "..."], message: str, tolerance: float = _CLOSE
) -> None:
    assert ours.shape == theirs.shape, f"{message} (shapes {ours.shape} and {theirs.shape})"
    # equal infinities are no difference
    with np.errstate(invalid="ignore"):
        gap = np.where(ours == theirs, 0.0, np.abs(ours - theirs))
    worst = np.unravel_index(int(np.argmax(np.nan_to_num(gap, nan=np.inf))), gap.shape)
    assert gap[worst] <= tolerance, (
        f"{message}: {ours[worst]!r} against {theirs[worst]!r} at {tuple(map(int, worst))}"
    )
