"""Each law of norms, personalities and policies by itself, for one trial or situation."""

from __future__ import annotations

from typing import Any

import numpy as np
from jaxtyping import Float

from ppinfer.coordination import (
    Decision,
    Norm,
    PersonalityModel,
    PlayHistory,
    Policy,
    Situation,
    coordination_equilibria,
    infer_personality,
)
from ppinfer.distributions import Axis, Distribution, Factor
from ppinfer.errors import ImpossibleEvidenceError
from ppinfer.games import Game
from ppinfer.testing.laws import check_normalisation

Trial = list[Situation]

_CLOSE = 1e-9
_SAME = 1e-10


def check_decisions(policy: Policy, trial: Trial) -> None:
    """Check every decision of a policy through a trial."""
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


def check_plan_order(policy: Policy, trial: Trial) -> None:
    """Check that plans may be listed in another order."""
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


def check_norm_in(norm: Norm, situation: Situation) -> None:
    """Check a norm in the game of one situation, and in several such games at once."""
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


def check_beliefs(model: PersonalityModel, trials: list[Trial]) -> None:
    """Check a personality on some trials, online and offline."""
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


def check_plan_order_of_beliefs(model: PersonalityModel, trials: list[Trial]) -> None:
    """Check that plans may be listed in another order."""
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
