"""Learning the weights: mean squared error from how often goals were reached, Adam, and stopping early."""

from __future__ import annotations

import copy
import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from ppinfer.errors import ModelError
from ppinfer.goals.dynamics import Dynamics
from ppinfer.goals.learned.configuration import NetworkConfiguration
from ppinfer.goals.learned.examples import ExampleRange, ExampleSource, PredictionExamples
from ppinfer.goals.learned.extra import require_torch, threads
from ppinfer.goals.learned.features import features_of, random_turns, scales_of
from ppinfer.goals.learned.network import build_network, log_probabilities
from ppinfer.goals.learned.predictor import GoalPredictor
from ppinfer.goals.model import LARGEST, require_range

# examples that are in memory, and shuffled, at a time
_POOL = 16384
# few examples in large batches are a handful of steps: training would end before it has begun
_STEPS, _LEAST_BATCH = 32, 8


@dataclass(frozen=True)
class Training:
    """How weights are learned.

    Parameters
    ----------
    epochs : int
        How often every example is seen, at most.
    patience : int
        Epochs without a better validation loss after which it stops; the best weights are kept.
    batch : int
        Examples a step of Adam, at most: where there are few, so many fewer that an epoch has about 32 steps.
    learning_rate : float
        Of Adam; it falls to nothing along half a cosine over the epochs.
    validation : float
        Share of the examples, the last ones, that training does not see and that decides when to stop; of whole games
        (see `train`), so that it may be more.
    turned : bool
        Whether every example is seen rotated or mirrored anew each time: a plane looks the same in every direction.
    seed : int
        Draws the first weights, the order of the examples and the rotations.
    threads : int
        Threads of PyTorch. The same number gives the same weights; another number may differ in the last digits.

    Raises
    ------
    ModelError
        Where a value is out of its range.

    Examples
    --------
    >>> Training(epochs=5).patience
    8
    """

    epochs: int = 40
    patience: int = 8
    batch: int = 128
    learning_rate: float = 2e-3
    validation: float = 0.1
    turned: bool = True
    seed: int = 0
    threads: int = 1

    def __post_init__(self) -> None:
        for name in ("epochs", "patience", "batch", "threads"):
            if getattr(self, name) < 1:
                raise ModelError(f"{name} must be at least 1; got {getattr(self, name)}")
        if self.seed < 0:
            raise ModelError(f"seed must not be negative; got {self.seed}")
        require_range("learning_rate", self.learning_rate, 0.0, LARGEST, open_low=True)
        require_range("validation", self.validation, 0.0, 0.9, open_low=True)


@dataclass(frozen=True, eq=False)
class Trained:
    """What came out: the predictor, and the losses on the way.

    Parameters
    ----------
    predictor : GoalPredictor
        With the weights of the best epoch.
    training_loss, validation_loss : tuple of float
        Mean squared error in each epoch: of the examples as they were seen, and of those held out.
    best_epoch : int
        From 0; the first one with the least validation loss.
    """

    predictor: GoalPredictor
    training_loss: tuple[float, ...]
    validation_loss: tuple[float, ...]
    best_epoch: int


def train(
    source: ExampleSource,
    configuration: NetworkConfiguration,
    training: Training | None = None,
    *,
    validation: ExampleSource | None = None,
    game: int = 1,
    progress: Callable[[int, int], None] | None = None,
) -> Trained:
    """Learn the weights of a network from examples (Appendix II).

    Parameters
    ----------
    source : ExampleSource
        The examples; those of one game belong side by side, as a generator writes them.
    configuration : NetworkConfiguration
        Sizes; the units are taken from the examples.
    training : Training, optional
        How.
    validation : ExampleSource, optional
        Examples that decide when to stop; default: the last ones of the source, which are then not trained on.
    game : int
        Examples of one game, side by side from the first one on: none of a game that is trained on decides when to
        stop, unless there is but one.
    progress : callable, optional
        Told how many epochs are done, of how many at most.

    Raises
    ------
    ModelError
        Where the extra is missing, there are fewer than two examples, they do not fit the network, or a game has none.
    """
    torch = require_torch()
    training = training or Training()
    if game < 1:
        raise ModelError(f"game must be at least 1, examples side by side; got {game}")
    if validation is None:
        held = max(1, round(training.validation * len(source)))
        if len(source) < 2:
            raise ModelError(
                f"{len(source)} examples are too few to learn from and to validate by; 2 at least"
            )
        cut = len(source) - held
        if len(source) > game:
            cut = max(game, cut // game * game)
        validation = ExampleRange(source, cut, len(source))
        source = ExampleRange(source, 0, cut)
    first = source.read(0, min(_POOL, len(source)))
    length, speed = scales_of(first, Dynamics.named(configuration.dynamics, configuration.dt))
    configuration = replace(configuration, length_scale=length, speed_scale=speed)
    order_rng, turn_rng = (
        np.random.default_rng(each) for each in np.random.SeedSequence(training.seed).spawn(2)
    )
    with threads(training.threads):
        network = build_network(configuration, training.seed)
        optimiser = torch.optim.Adam(network.parameters(), lr=training.learning_rate)
        batch_size = min(training.batch, max(_LEAST_BATCH, len(source) // _STEPS))
        steps = training.epochs * max(1, math.ceil(len(source) / batch_size))
        schedule = torch.optim.lr_scheduler.CosineAnnealingLR(optimiser, steps)
        training_loss: list[float] = []
        validation_loss: list[float] = []
        best, best_weights = -1, copy.deepcopy(network.state_dict())
        for epoch in range(training.epochs):
            total = 0.0
            for batch in _batches(source, batch_size, order_rng):
                turn = random_turns(len(batch), turn_rng) if training.turned else None
                loss = _loss(network, batch, configuration, turn)
                optimiser.zero_grad()
                loss.backward()
                torch.nn.utils.clip_grad_norm_(network.parameters(), 1.0)
                optimiser.step()
                schedule.step()
                total += float(loss.detach()) * len(batch)
            training_loss.append(total / len(source))
            validation_loss.append(_mean_loss(network, validation, configuration))
            if best < 0 or validation_loss[-1] < validation_loss[best]:
                best, best_weights = epoch, copy.deepcopy(network.state_dict())
            if progress is not None:
                progress(epoch + 1, training.epochs)
            if epoch - best >= training.patience:
                break
        network.load_state_dict(best_weights)
    return Trained(GoalPredictor(configuration, network), tuple(training_loss), tuple(validation_loss), best)


def _batches(source: ExampleSource, size: int, rng: np.random.Generator) -> Iterator[PredictionExamples]:
    """Yield every example once, in an order drawn anew; of a source on disk only a pool is in memory."""
    starts = np.arange(0, len(source), _POOL)
    for start in rng.permutation(starts).tolist():
        pool = source.read(start, min(start + _POOL, len(source)))
        order = rng.permutation(len(pool))
        for low in range(0, len(pool), size):
            yield pool.take(order[low : low + size])


def _loss(network: Any, examples: PredictionExamples, configuration: NetworkConfiguration, turn: Any) -> Any:
    torch = require_torch()
    found = log_probabilities(network, features_of(examples, configuration, turn), configuration.hidden).exp()
    present = torch.from_numpy(examples.present)
    error = (found - torch.from_numpy(examples.frequency)) ** 2
    return (error.sum(dim=1) / present.sum(dim=1)).mean()


def _mean_loss(network: Any, source: ExampleSource, configuration: NetworkConfiguration) -> float:
    torch = require_torch()
    total = 0.0
    with torch.inference_mode():
        for start in range(0, len(source), 1024):
            part = source.read(start, min(start + 1024, len(source)))
            total += float(_loss(network, part, configuration, None)) * len(part)
    return total / len(source)
