"""How much data learned prediction needs to match the model: trained on growing shares, scored on the same examples."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ppinfer.errors import LogError
from ppinfer.goals.learned import NetworkConfiguration, PredictionExamples, Trained, Training, train
from ppinfer.goals.learned.examples import ExampleRange
from ppinfer.studies.model_prediction import ModelPrediction, fit_model_prediction
from ppinfer.studies.prediction_examples import ExampleStore
from ppinfer.studies.prediction_scores import PredictionScore, score_predictions
from ppinfer.studies.progress import ProgressCallback, silent

# examples held in memory for scores, and for fitting the model
_MOST_SCORED, _MOST_FITTED = 20_000, 1000


@dataclass(frozen=True)
class LearningRow:
    """One predictor's scores on the examples held out.

    Parameters
    ----------
    prediction : {"learned", "model", "model fitted", "even"}
        The network; the softmax with its default weights; with weights fitted to examples; the same for all goals.
    examples : int
        What it was trained or fitted on; 0 for none.
    interaction_hours : float
        Interaction that was simulated for these examples, every continuation counted.
    epochs : int
        Epochs until training stopped; 0 where nothing was trained.
    validation_loss : float
        Of the best epoch, on the training examples set aside for that; NaN where nothing was trained.
    score : PredictionScore
        On the examples held out.
    """

    prediction: str
    examples: int
    interaction_hours: float
    epochs: int
    validation_loss: float
    score: PredictionScore

    def to_json(self) -> dict[str, str | int | float]:
        """Return what ``ppinfer learn --json`` prints of it."""
        return {
            "prediction": self.prediction,
            "trained_on": self.examples,
            "interaction_hours": self.interaction_hours,
            "epochs": self.epochs,
            "validation_loss": self.validation_loss,
            **self.score.to_json(),
        }


@dataclass(frozen=True, eq=False)
class LearningStudy:
    """What came out: a row for each amount of data, those of the model, and the last predictor with its losses."""

    rows: tuple[LearningRow, ...]
    trained: Trained
    fitted: ModelPrediction
    held_out: int


def study_learning(
    store: ExampleStore,
    *,
    sizes: Sequence[int] = (),
    hidden: int = 32,
    training: Training | None = None,
    held_out: float = 0.2,
    progress: ProgressCallback = silent,
) -> LearningStudy:
    """Train on growing numbers of examples and score every network, and the model, on the same examples held out.

    1. The last share of the store is held out; examples of one game stay on one side.
    2. The model predicts these as it is, and with weights fitted to the same numbers of training examples as networks
       are trained on, but at most 1000.
    3. For each size n a network is trained on the first n of the training examples, a share of which decides when to
       stop.

    Parameters
    ----------
    store : ExampleStore
        The examples.
    sizes : sequence of int
        How many to train on; default: all that are not held out.
    hidden : int
        Width of the network.
    training : Training, optional
        How it is trained.
    held_out : float
        Share of the examples that is held out.
    progress : callable
        Told how many epochs are done, of how many at most.

    Raises
    ------
    LogError
        Where there are too few examples for that.
    ModelError
        Where the extra is missing, or an option is out of its range.
    """
    training = training or Training()
    split = split_of(store, held_out)
    sizes = sorted(set(sizes)) or [split]
    for size in sizes:
        if not 2 <= size <= split:
            raise LogError(
                f"{store.path}: sizes must be from 2 to the {split} examples that are not held out; got {size}; "
                "generate more with 'ppsim examples', or hold out fewer"
            )
    scored = store.read(split, min(len(store), split + _MOST_SCORED))
    rows = [_even(scored)]
    model = ModelPrediction(
        state_weight=store.header.state_weight,
        control_weight=store.header.control_weight,
        dynamics=store.header.dynamics,
        dt=store.header.dt,
    )
    rows.append(_model_row("model", 0, 0.0, model, scored))
    fitted = model
    for count in sorted({min(size, _MOST_FITTED) for size in sizes}):
        fitted = fit_model_prediction(model, store.read(0, count))
        rows.append(_model_row("model fitted", count, store.interaction(0, count) / 3600, fitted, scored))
    configuration = configuration_for(store, hidden)
    trained: Trained | None = None
    for index, size in enumerate(sizes):
        before = index * training.epochs

        def tell(done: int, total: int, before: int = before) -> None:
            progress(before + done, training.epochs * len(sizes))

        trained = train(
            ExampleRange(store, 0, size), configuration, training, game=_game_of(store), progress=tell
        )
        found = trained.predictor.log_probabilities_of(scored)
        rows.append(
            LearningRow(
                "learned",
                size,
                store.interaction(0, size) / 3600,
                len(trained.validation_loss),
                trained.validation_loss[trained.best_epoch],
                score_predictions(found, scored.frequency, scored.present),
            )
        )
    assert trained is not None
    return LearningStudy(tuple(rows), trained, fitted, len(scored))


def configuration_for(store: ExampleStore, hidden: int) -> NetworkConfiguration:
    """Return the configuration of a network that takes the examples of a store."""
    header = store.header
    return NetworkConfiguration(
        past=header.past,
        horizon=header.horizon,
        hidden=hidden,
        dynamics=header.dynamics,
        dt=header.dt,
        state_weight=header.state_weight,
        control_weight=header.control_weight,
    )


def split_of(store: ExampleStore, held_out: float) -> int:
    """Return how many examples of a store may be trained on: the others, a share of about `held_out`, are held out.

    Examples of one game are alike, so none of a game trained on is held out: the bound is one of batches, or in a store
    of one or two batches one of games.

    Raises
    ------
    LogError
        Where there are too few examples for that.

    Examples
    --------
    >>> from ppinfer.testing.prediction_examples import example_store
    >>> split_of(example_store("split.zarr", 40), 0.25)
    30
    """
    if not 0 < held_out < 1:
        raise LogError(f"the share held out must be above 0 and below 1; got {held_out:g}")
    examples, batch = len(store), store.header.batch
    unit = batch if examples > 2 * batch else _game_of(store)
    split = round(examples * (1 - held_out))
    if examples > unit:
        split = max(unit, split // unit * unit)
    if split < 2 or split >= examples:
        raise LogError(f"{examples} examples are too few to hold out a share of {held_out:g}")
    return split


def _game_of(store: ExampleStore) -> int:
    # a generator that says how many examples it takes of a game writes them side by side
    return int(store.header.configuration.get("instants", 1))


def _even(scored: PredictionExamples) -> LearningRow:
    with np.errstate(divide="ignore"):
        even = np.log(scored.present / scored.present.sum(axis=1, keepdims=True))
    return LearningRow(
        "even", 0, 0.0, 0, float("nan"), score_predictions(even, scored.frequency, scored.present)
    )


def _model_row(
    name: str, examples: int, hours: float, model: ModelPrediction, scored: PredictionExamples
) -> LearningRow:
    found = score_predictions(model.log_probabilities(scored), scored.frequency, scored.present)
    return LearningRow(name, examples, hours, 0, float("nan"), found)
