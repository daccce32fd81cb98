"""Which seed makes which trial: a function of the study's seed and the trial's number, and of nothing else."""

from __future__ import annotations

import numpy as np

# spawn keys that keep the streams of trials, participants and parts of a trial apart
_TRIALS, _PARTICIPANTS, _BATCHES = 0, 1, 2


def trial_seed(study_seed: int, index: int) -> int:
    """Return the seed of one trial, a whole number below 2^63 that a log can hold.

    Examples
    --------
    >>> trial_seed(7, 0) == trial_seed(7, 0), trial_seed(7, 0) == trial_seed(7, 1)
    (True, False)
    """
    sequence = np.random.SeedSequence(study_seed, spawn_key=(_TRIALS, index))
    return int(sequence.generate_state(1, np.uint64)[0] >> np.uint64(1))


def participant_rng(study_seed: int, index: int) -> np.random.Generator:
    """Return the generator that draws what one participant is like.

    Examples
    --------
    >>> float(participant_rng(7, 0).random()) == float(participant_rng(7, 0).random())
    True
    """
    return np.random.default_rng(np.random.SeedSequence(study_seed, spawn_key=(_PARTICIPANTS, index)))


def batch_rng(study_seed: int, index: int) -> np.random.Generator:
    """Return the generator that draws all of one batch of games that are simulated side by side.

    Examples
    --------
    >>> float(batch_rng(7, 0).random()) == float(batch_rng(7, 1).random())
    False
    """
    return np.random.default_rng(np.random.SeedSequence(study_seed, spawn_key=(_BATCHES, index)))


def streams(seed: int, count: int) -> list[np.random.Generator]:
    """Return independent generators for the parts of one trial.

    Examples
    --------
    >>> world, human = streams(3, 2)
    >>> float(world.random()) == float(human.random())
    False
    """
    return [np.random.default_rng(one) for one in np.random.SeedSequence(seed).spawn(count)]
