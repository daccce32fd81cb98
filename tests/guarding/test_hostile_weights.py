"""Weights that claim a network that they do not hold are refused before it is built."""

from __future__ import annotations

import json
import os

import numpy as np
import pytest

from ppinfer.errors import ModelError
from ppinfer.goals.learned.configuration import NetworkConfiguration

pytest.importorskip("torch", reason="needs the extra 'learned'")
safetensors = pytest.importorskip("safetensors.numpy", reason="needs the extra 'learned'")


def weights(path, told):
    path.write_bytes(safetensors.save({"x": np.zeros(3, np.float32)}, metadata={"ppinfer": told}))
    return path


def described(**changed):
    plain = json.loads(NetworkConfiguration(past=10, horizon=30).to_json()) | changed
    return json.dumps({"format": "ppinfer goal predictor", "version": 1, "configuration": plain})


@pytest.mark.parametrize(
    ("told", "message"),
    [
        (described(hidden=4096), "describes a network of more than 67108864 bytes, but is smaller"),
        (described(hidden=10**12), "hidden must be a whole number"),
        ("[" * 100_000, "not one that 'ppinfer learn' wrote"),
        (described(note="x" * 2_000_000), "has a header of [0-9]+ bytes"),
    ],
    ids=["large", "absurd", "nested", "long"],
)
def test_weights_that_claim_too_much_are_refused(tmp_path, told, message):
    from ppinfer.goals.learned.weights import read_predictor

    with pytest.raises(ModelError, match=message):
        read_predictor(weights(tmp_path / "model.safetensors", told))


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="this system has no named pipes")
def test_weights_are_no_pipe(tmp_path):
    from ppinfer.goals.learned.weights import read_predictor

    os.mkfifo(tmp_path / "model.safetensors")
    with pytest.raises(ModelError, match="is a pipe"):
        read_predictor(tmp_path / "model.safetensors")
