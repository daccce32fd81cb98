"""The generative twin of the personality models: motion of agents who play equilibria of their class, with noise."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
from jaxtyping import Bool, Float, Int

from ppinfer.coordination.design import PlayDesign
from ppinfer.coordination.equilibria import coordination_equilibria
from ppinfer.coordination.evidence import PlayEvidence
from ppinfer.coordination.personality_model import PersonalityModel
from ppinfer.coordination.reading import Reading
from ppinfer.coordination.reading_histories import Samples, planned
from ppinfer.errors import ModelError

Played = Callable[[Int[np.ndarray, " replan"]], Int[np.ndarray, "replan agent"]]


def simulate_motion(
    model: PersonalityModel,
    reading: Reading,
    design: PlayDesign,
    rng: np.random.Generator,
    played: Played | None = None,
) -> PlayEvidence:
    """Return the design with the motion of the agents that are watched drawn from the model.

    1. Everybody plays, from each anchor on, an equilibrium drawn evenly from the class of its theta (8); with the
       probability of contamination, of a class drawn evenly. Where the class is empty, so is one of the others.
    2. The states that count lie about the plans with a density proportional to exp(-rationality f_dist): a direction
       drawn evenly, at a distance that follows the gamma distribution of as many degrees as there are numbers. Between
       them the agents are on their plans.

    A model whose agents choose otherwise than in 1. gives `played`, which is asked for each agent's plan from some
    anchors on.

    So what the model makes of the result is calibrated: see the tests. With the sums of (9) in place of means it is so
    if the classes are as probable as they are large.

    Raises
    ------
    ModelError
        If the model's rationality is 0: then any motion at all is as likely as any other.
    """
    if reading.rationality == 0.0:
        raise ModelError(
            "motion cannot be drawn with rationality 0: all motions are as likely; give it a positive one"
        )
    evidence, history = design.evidence, design.evidence.history
    watched = reading.watched(len(history.agents), evidence.player)
    position, velocity = history.position.copy(), history.velocity.copy()
    row = np.arange(len(evidence.replans))
    if reading.reanchor:
        row = row[evidence.first != row]
        anchor = row - 1
    else:
        anchor = evidence.first
    chosen = _played(model, reading, design, anchor, rng) if played is None else played(anchor)
    every_step = reading if reading.every is None else replace(reading, every=history.dt)
    samples = Samples(every_step, evidence)
    for agent in watched:
        where, speed = planned(evidence, samples, row, anchor, agent, chosen[:, agent, None])
        valid = samples.valid[row]
        left = np.isnan(position[samples.sample[row], agent]).any(axis=2)
        moved = valid & ~left
        position[samples.sample[row][moved], agent] = where[:, 0][moved]
        velocity[samples.sample[row][moved], agent] = speed[:, 0][moved]
    _add_noise(reading, evidence, row, watched, position, velocity, rng)
    return PlayEvidence(replace(history, position=position, velocity=velocity), evidence.ego)


def _played(
    model: PersonalityModel,
    reading: Reading,
    design: PlayDesign,
    anchor: Int[np.ndarray, " replan"],
    rng: np.random.Generator,
) -> Int[np.ndarray, "replan agent"]:
    """Return each agent's plan in the profile played from each anchor on."""
    evidence = design.evidence
    played = np.zeros((len(anchor), len(evidence.history.agents)), np.int64)
    for place, size in evidence.by_size(anchor):
        anchors, which = np.unique(anchor[place], return_inverse=True)
        game = evidence.game(anchors, size)
        among = coordination_equilibria(game, model.dominance).log_values > -np.inf
        classes = model.favoured(game.costs.transpose(1, 0, *range(2, game.costs.ndim)), among)
        flat = classes.reshape(len(classes), len(anchors), -1)
        theta = design.theta[anchors]
        astray = rng.random(len(anchors)) < reading.contamination
        theta = np.where(astray, rng.integers(len(classes), size=len(anchors)), theta)
        empty = np.logical_not(flat.any(axis=2))
        # of the classes that are not empty, the one that a random key ranks first
        key = np.where(empty, -1.0, rng.random(empty.shape))
        theta = np.where(empty[theta, np.arange(len(anchors))], key.argmax(axis=0), theta)
        able = flat[theta, np.arange(len(anchors))]
        able = np.where(able.any(axis=1, keepdims=True), able, True)
        profile = np.where(able, rng.random(able.shape), -1.0).argmax(axis=1)
        played[place] = np.stack(np.unravel_index(profile, size), axis=1)[which]
    return played


def _add_noise(
    reading: Reading,
    evidence: PlayEvidence,
    row: Int[np.ndarray, " replan"],
    watched: list[int],
    position: Float[np.ndarray, "sample agent joint"],
    velocity: Float[np.ndarray, "sample agent joint"],
    rng: np.random.Generator,
) -> None:
    """Move the states that count off the plans, in place."""
    samples = Samples(reading, evidence)
    sample = samples.sample[row]
    joints = position.shape[2]
    numbers = joints * (2 if reading.velocities else 1)
    noise = rng.standard_normal((*sample.shape, len(watched), numbers))
    left: Bool[np.ndarray, "replan time agent"] = np.isnan(position[sample][:, :, watched]).any(axis=3)
    counts = samples.valid[row][:, :, None] & ~left
    noise[~counts] = 0.0
    # what is drawn together: an interval, or where nothing is anchored anew a whole trial
    unit = row if reading.reanchor else evidence.first[row]
    unit = np.unique(unit, return_inverse=True)[1]
    degrees = np.bincount(unit, counts.sum(axis=(1, 2)) * numbers)
    norm = np.sqrt(np.bincount(unit, np.einsum("rtan,rtan->r", noise, noise)))
    radius = rng.gamma(np.maximum(degrees, 1.0), 1.0 / reading.rationality)
    noise *= (radius / np.where(norm > 0.0, norm, 1.0))[unit][:, None, None, None]
    place = np.nonzero(counts)
    agent = np.asarray(watched)[place[2]]
    position[sample[place[:2]], agent] += noise[place][:, :joints]
    if reading.velocities:
        velocity[sample[place[:2]], agent] += noise[place][:, joints:]
