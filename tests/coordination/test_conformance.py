"""Every norm, personality and policy that is shipped obeys the laws; broken ones are told which they break."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import pytest

from ppinfer.coordination import (
    NORMS,
    POLICIES,
    BayesNash,
    Decision,
    Defensive,
    LiteralPersonality,
    MinNorm,
    MixtureNorm,
    Norm,
    NormNash,
    OracleNash,
    Personality,
    PersonalityModel,
    Policy,
    RiskDominant,
    Selfish,
    Utilitarian,
)
from ppinfer.distributions import Distribution
from ppinfer.testing import check_norm, check_personality, check_personality_twin, check_policy

FEW = 5
CUSTOM = [
    NormNash(norm=RiskDominant(), dominance="strict"),
    BayesNash(
        norm=MixtureNorm([MinNorm(), Utilitarian()], [0.5, 0.5]), personality=Personality(fair_within=1.0)
    ),
    BayesNash(personality=Personality(reanchor=False, average=False, ties=False, observed="all")),
    OracleNash(other=Selfish()),
    OracleNash(other=Defensive()),
    OracleNash(other=BayesNash()),
]
PERSONALITIES = [
    Personality(),
    Personality(fair_within=1.0),
    Personality(stay=1.0, contamination=0.0, every=0.5),
    Personality(reanchor=False),
]


@pytest.mark.parametrize("name", [name for name in POLICIES if name != "bayes-risk"])
def test_every_policy_obeys_the_laws(name):
    policy = POLICIES[name]()
    assert policy.name == name
    check_policy(policy, examples=FEW)


@pytest.mark.parametrize("policy", CUSTOM, ids=lambda policy: repr(policy)[:60])
def test_policies_with_other_parts_obey_the_laws(policy):
    check_policy(policy, examples=FEW)


def test_the_policy_that_draws_sub_games_by_number_obeys_all_laws_but_relabelling():
    check_policy(POLICIES["bayes-risk"](), examples=6, agents=(2,), relabelling=False)


@pytest.mark.parametrize("name", NORMS)
def test_every_norm_obeys_the_laws(name):
    assert NORMS[name]().name == name
    check_norm(NORMS[name](), examples=FEW)


def test_a_mixture_of_norms_obeys_the_laws():
    check_norm(MixtureNorm([MinNorm(), RiskDominant()], [0.3, 0.7]), examples=FEW)


@pytest.mark.parametrize("model", PERSONALITIES, ids=lambda model: repr(model)[:80])
def test_every_personality_obeys_the_laws_and_is_calibrated_on_its_own_simulations(model):
    check_personality(model, examples=FEW, twin=False)
    check_personality_twin(model, np.random.default_rng(0), trials=100, replans=4)


@pytest.mark.parametrize(
    "model",
    [
        LiteralPersonality(),
        LiteralPersonality(dominance="strict"),
        Personality(average=False, skip_empty=False, ties=False, velocities=True, observed="all"),
    ],
    ids=lambda model: repr(model)[:80],
)
def test_personalities_that_weigh_classes_by_their_size_obey_the_laws(model):
    check_personality(model, examples=FEW, twin=False)


# broken ones


@dataclass(frozen=True)
class Restless(Policy):
    """Does something else each time it is asked."""

    def decide(self, situation, ego, memory=None):
        object.__setattr__(self, "turn", getattr(self, "turn", 0) + 1)
        own = situation.plans[situation.player(ego)]
        return Decision(self.turn % len(own), Distribution.uniform(own.axis))


@dataclass(frozen=True)
class Hopeful(Policy):
    """Takes a plan that its distribution rules out."""

    def decide(self, situation, ego, memory=None):
        own = situation.plans[situation.player(ego)]
        sure = np.zeros(len(own))
        sure[0] = 1.0
        return Decision(len(own) - 1, Distribution.from_probabilities([own.axis], sure))


@pytest.mark.parametrize(
    ("policy", "law"),
    [(Restless(), "pure function"), (Hopeful(), "no probability")],
)
def test_a_broken_policy_is_told_which_law_it_breaks(policy, law):
    with pytest.raises(AssertionError, match=law):
        check_policy(policy, examples=20, agents=(2,))


@dataclass(frozen=True)
class FirstPlan(Norm):
    """Looks at numbers of plans."""

    def log_weights(self, costs, among):
        return -np.broadcast_to(np.arange(among.shape[-1], dtype=float), among.shape)


def test_a_broken_norm_is_told_which_law_it_breaks():
    with pytest.raises(AssertionError, match="another order"):
        check_norm(FirstPlan(), agents=(2,))


@dataclass(frozen=True)
class LooksAhead(PersonalityModel):
    """Judges every replan by where the trial ends."""

    def log_likelihood(self, evidence):
        last = np.repeat(evidence.sample[np.cumsum(evidence.row_size) - 1], evidence.row_size)
        end = np.nan_to_num(evidence.history.position[last])[..., 0]
        return evidence.likelihood_factor(self.theta(evidence.history.agents), end)

    def simulate(self, design, rng):
        raise NotImplementedError


def test_a_personality_that_looks_ahead_is_told_so():
    with pytest.raises(AssertionError, match="online differs from offline"):
        check_personality(LooksAhead(), examples=10, agents=(2,), twin=False)


def test_a_personality_without_a_twin_is_told_how_to_leave_it_out():
    with pytest.raises(AssertionError, match="twin=False"):
        check_personality_twin(LooksAhead(), np.random.default_rng(0), trials=3)


@dataclass(frozen=True)
class Overconfident(Personality):
    """Believes that motion is less noisy than it is when it simulates."""

    def simulate(self, design, rng):
        return replace(Personality(), rationality=self.rationality / 20).simulate(design, rng)


def test_a_personality_that_simulates_other_agents_than_it_infers_is_told_so():
    with pytest.raises(AssertionError, match="not describe the same agent"):
        check_personality_twin(
            Overconfident(contamination=0.0), np.random.default_rng(0), trials=200, replans=4
        )


@dataclass(frozen=True)
class Busy(PersonalityModel):
    """A user's own: whoever has moved further since the last replan is favoured."""

    stay: float = 0.9

    def log_likelihood(self, evidence):
        position = np.nan_to_num(evidence.history.position[evidence.sample])
        moved = np.zeros((len(position), len(evidence.history.agents)))
        moved[1:] = np.linalg.norm(position[1:] - position[:-1], axis=-1)
        moved[evidence.first] = 0.0
        return evidence.likelihood_factor(self.theta(evidence.history.agents), moved)

    def simulate(self, design, rng):
        raise NotImplementedError


def test_a_users_own_personality_is_one_class_and_sits_in_the_policy():
    check_personality(Busy(), examples=FEW, twin=False)
    check_policy(BayesNash(personality=Busy()), examples=FEW)
