"""Models, learned weights, stores of examples, and games."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from .case import Case, made

GAME = """NFG 1 R "Backward bend" { "Player 1" "Player 2" }

{ { "1" "2" }
{ "1" "2" }
}
"A comment"

{
{ "11" 6, 7 }
{ "12" 6, 7 }
{ "21" 7.32, 6 }
{ "22" 1, 4/3 }
}
1 3 2 4
"""
PAYOFFS = 'NFG 1 D "Three" { "a" "b" "c" } { 2 2 1 }\n\n1 2 3 4.5 5 6 7/2 8 9 10 11 -12\n'


def models() -> list[Case]:
    """Models as TOML, learned weights, stores of examples, and games."""
    from ppinfer.games import read_nfg
    from ppinfer.goals import GoalLQR
    from ppinfer.goals.configuration import read_model, write_model
    from ppinfer.studies.prediction_examples import ExampleStore
    from ppinfer.testing.prediction_examples import example_store

    def store(path: Path) -> Any:
        found = ExampleStore(path)
        examples = found.read(0, len(found))
        parts = [
            found.kinds(0, len(found)),
            examples.human,
            examples.plan,
            examples.goals,
            examples.frequency,
        ]
        return str(found.header), found.interaction(0, len(found)), [part.tolist() for part in parts]

    def game(path: Path) -> Any:
        found = read_nfg(path)
        return found.players, [(axis.name, axis.labels) for axis in found.plans], found.costs.tolist()

    cases = [
        Case(
            "read_model", made(lambda folder: write_model(GoalLQR(), folder / "model.toml", {})), read_model
        ),
        Case("ExampleStore", made(lambda folder: example_store(folder / "e.zarr", 6)), store, "e.zarr"),
        Case("read_nfg outcomes", {"bend.nfg": GAME.encode()}, game),
        Case("read_nfg payoffs", {"three.nfg": PAYOFFS.encode()}, game),
    ]
    try:
        import safetensors  # noqa: F401
        import torch
    except ImportError:
        return cases
    from ppinfer.goals.learned import GoalPredictor, NetworkConfiguration, read_predictor, write_predictor
    from ppinfer.goals.learned.network import build_network, weights_of

    configuration = NetworkConfiguration(past=4, horizon=8, hidden=8)
    torch.manual_seed(0)
    predictor = GoalPredictor(configuration, build_network(configuration))

    def weights(path: Path) -> Any:
        found = read_predictor(path)
        return found.configuration, {
            name: array.tolist() for name, array in weights_of(found.network).items()
        }

    files = made(lambda folder: write_predictor(predictor, folder / "w.safetensors"))
    return [*cases, Case("read_predictor", files, weights, None, {"signed": True})]
