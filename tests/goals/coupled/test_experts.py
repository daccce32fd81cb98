"""Every expert obeys the laws, alone and as a factor of the product."""

from __future__ import annotations

import pytest

from ppinfer.goals import GoalCoupled
from ppinfer.goals.coupled import EXPERTS
from ppinfer.testing import check_expert, check_likelihood


@pytest.mark.parametrize("name", list(EXPERTS))
def test_every_expert_obeys_the_laws(name):
    check_expert(EXPERTS[name](), examples=6)


def test_their_product_obeys_the_laws():
    check_likelihood(GoalCoupled(), examples=6, twin=False)


def test_the_product_of_all_obeys_the_laws():
    every = tuple(expert() for expert in EXPERTS.values())
    check_likelihood(GoalCoupled(experts=every), examples=6, twin=False)
