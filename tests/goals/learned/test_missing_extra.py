"""Without the extra everything else works, and what needs it says in one line what to install."""

import sys

import pytest

from ppinfer.cli import main
from ppinfer.errors import ModelError
from ppinfer.goals.learned import NetworkConfiguration, read_predictor, train
from ppinfer.testing.prediction_examples import example_predictions, example_store

LINE = "learned prediction needs PyTorch and safetensors: pip install 'ppinfer[learned]'"


@pytest.fixture(params=["torch", "safetensors.numpy"])
def _hidden(request, monkeypatch):
    monkeypatch.setitem(sys.modules, request.param, None)


@pytest.mark.usefixtures("_hidden")
def test_training_and_reading_name_what_to_install(tmp_path):
    for attempt in (
        lambda: train(example_predictions(5), NetworkConfiguration(past=4, horizon=8)),
        lambda: read_predictor(tmp_path / "m.safetensors"),
    ):
        with pytest.raises(ModelError) as refused:
            attempt()
        assert str(refused.value) == LINE


@pytest.mark.usefixtures("_hidden")
def test_the_command_names_what_to_install_in_one_line_and_writes_nothing(tmp_path, capsys):
    example_store(tmp_path / "examples.zarr", 20)
    target = tmp_path / "m.safetensors"
    assert main(["learn", str(tmp_path / "examples.zarr"), "-o", str(target)]) == 1
    assert capsys.readouterr().err == f"ppinfer learn: {LINE}\n"
    assert not target.exists()
