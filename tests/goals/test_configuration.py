"""Models by name and parameters, from text and from files."""

import re

import pytest

from ppinfer.errors import ModelError
from ppinfer.goals import MODELS, GoalLQR
from ppinfer.goals.configuration import make_model, parameters_of, read_model, write_model


@pytest.mark.parametrize("name", list(MODELS))
def test_every_model_survives_the_way_to_a_file_and_back(name, tmp_path):
    model = make_model(name, {})
    write_model(model, tmp_path / "m.toml", {"fit": {"value": 1.5}})
    assert read_model(tmp_path / "m.toml") == model
    assert parameters_of(model)


def test_text_becomes_numbers():
    model = make_model("goal-lqr", {"rationality": "0.25", "stay": "0.9", "dynamics": "double-integrator"})
    assert model == GoalLQR(rationality=0.25, stay=0.9, dynamics="double-integrator")


@pytest.mark.parametrize(
    ("name", "parameters", "message"),
    [
        ("goal-lqrr", {}, "unknown model 'goal-lqrr'.*did you mean 'goal-lqr'"),
        ("goal-lqr", {"rationalty": 1}, "no parameter 'rationalty'.*did you mean 'rationality'"),
        ("goal-lqr", {"rationality": "high"}, "rationality must be a number; got 'high'"),
        ("goal-lqr", {"rationality": "-1"}, "rationality must lie in"),
        ("goal-lqr", {"rationality": "nan"}, "rationality must lie in"),
        ("goal-lqr", {"stay": 1.5}, r"stay must lie in \[0, 1\]"),
        ("goal-lqr", {"agent": "me"}, "no parameter 'agent'"),
        ("goal-lqr", {"dynamics": "triple"}, "unknown dynamics 'triple'"),
        ("goal-kalman", {"reacquire_after": "2.5"}, "reacquire_after must be a whole number"),
    ],
)
def test_what_does_not_fit_is_refused_with_what_would(name, parameters, message):
    with pytest.raises(ModelError, match=message):
        make_model(name, parameters)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("model = ", "not valid TOML"),
        ("parameters = {}", 'expected model = "NAME"'),
        ('model = "goal-lqr"\nformat_version = 99', "format_version 99"),
        ('model = "nearest"\n[parameters]\nscael = 2.0', "did you mean 'scale'"),
    ],
)
def test_a_bad_file_is_named(tmp_path, text, message):
    path = tmp_path / "m.toml"
    path.write_text(text)
    with pytest.raises(ModelError, match=f"{re.escape(str(path))}: .*{message}"):
        read_model(path)


def test_bytes_that_are_no_text_are_refused(tmp_path):
    path = tmp_path / "m.toml"
    path.write_bytes(b"\xff\xfe\x00")
    with pytest.raises(ModelError, match="not a text file"):
        read_model(path)


def test_nothing_is_left_behind_where_a_model_cannot_be_written(tmp_path):
    with pytest.raises(ModelError, match="no folder"):
        write_model(make_model("nearest", {}), tmp_path / "nowhere" / "m.toml", {})
    with pytest.raises(TypeError):
        write_model(make_model("nearest", {}), tmp_path / "m.toml", {"fit": object()})
    assert list(tmp_path.iterdir()) == []
