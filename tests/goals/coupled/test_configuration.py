"""goal-coupled as text: which experts, with which parameters."""

from __future__ import annotations

import re

import pytest

from ppinfer.errors import ModelError
from ppinfer.goals import GoalCoupled
from ppinfer.goals.configuration import make_model, parameters_of, read_model, write_model
from ppinfer.goals.coupled import Conditional, Distance, LqrMotion, Motion


def test_experts_and_their_parameters_are_text():
    model = make_model("goal-coupled", {"experts": "lqr,distance", "stay": "0.9", "distance.weight": "0.5"})
    assert model == GoalCoupled(experts=(LqrMotion(), Distance(weight=0.5)), stay=0.9)


@pytest.mark.parametrize(
    "model",
    [
        GoalCoupled(),
        GoalCoupled(experts=(Conditional(stay_weight=0.3), Motion(outliers=0.2)), stay=0.5),
        GoalCoupled().without("motion"),
    ],
)
def test_every_choice_of_experts_survives_the_way_to_a_file_and_back(model, tmp_path):
    write_model(model, tmp_path / "m.toml", {})
    assert read_model(tmp_path / "m.toml") == model
    assert make_model("goal-coupled", parameters_of(model)) == model


@pytest.mark.parametrize(
    ("parameters", "message"),
    [
        ({"experts": "motion,distnce"}, "no expert 'distnce'.*did you mean 'distance'"),
        ({"experts": "motion,motion"}, "'motion' is named twice"),
        ({"experts": " , "}, "experts names none"),
        ({"motion.concentratoin": "2"}, "did you mean 'motion.concentration'"),
        ({"experts": "motion", "lead.cap": "2"}, "no parameter 'lead.cap'"),
        ({"distance.weight": "near"}, "distance.weight must be a number; got 'near'"),
        ({"motion.outliers": "1.5"}, re.escape("motion.outliers must lie in [0, 1]")),
        ({"experts": "lqr", "lqr.evidence_floor": "1"}, "evidence_floor must lie in"),
        ({"stay": "-1"}, "stay must lie in"),
    ],
)
def test_what_does_not_fit_is_refused_with_what_would(parameters, message):
    with pytest.raises(ModelError, match=message):
        make_model("goal-coupled", parameters)


def test_a_product_of_nothing_is_refused():
    with pytest.raises(ModelError, match="some experts, each kind once; got none"):
        GoalCoupled(experts=())
