"""Motion of whole histories read as evidence: the same numbers as replan by replan, without a loop over replans."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from jaxtyping import Bool, Float, Int

from ppinfer.coordination.equilibria import coordination_equilibria
from ppinfer.coordination.evidence import PlayEvidence
from ppinfer.coordination.reading import Reading
from ppinfer.distributions import Ragged, expand

if TYPE_CHECKING:
    from ppinfer.coordination.personality_model import PersonalityModel


class Samples:
    """The samples that count at each replan, padded to the longest.

    Attributes
    ----------
    sample : (replan, time) int64
        Over all trials.
    step : (replan, time) int64
        Steps since the anchor that led there; non-decreasing.
    valid : (replan, time) bool
        False for padding.
    """

    def __init__(self, reading: Reading, evidence: PlayEvidence) -> None:
        rows = len(evidence.replans)
        start = evidence.sample[np.maximum(np.arange(rows) - 1, 0)]
        begins = evidence.first == np.arange(rows)
        second = np.zeros(rows, np.bool_)
        second[1:] = begins[:-1]
        start, stop = np.where(begins, evidence.sample, start), evidence.sample
        # what is read whole holds the trial's first sample too
        early = (second & ~begins & (reading.every is None)).astype(np.int64)
        size = np.where(begins, 0, stop - start + early)
        flat = expand(start + 1 - early, size)
        row = np.repeat(np.arange(rows), size)
        moved = np.ones(len(flat), np.bool_) if reading.every is None else ~evidence.history.held[flat]
        counts = Ragged(moved.astype(np.int64), size)
        step = counts.cumsum().values - (early[row] if reading.every is None else 0)
        total = np.bincount(row, weights=counts.values, minlength=rows).astype(np.int64) - early * (size > 0)
        if reading.every is not None:
            stride = reading.stride(evidence.history.dt)
            short = (total[row] < stride) & (step == total[row])
            chosen = (counts.values > 0) & ((step % stride == 0) | short)
        else:
            chosen = np.ones(len(flat), np.bool_)
        if not reading.reanchor:
            before = np.cumsum(total) - total
            step = step + (before - before[evidence.first])[row]
        flat, row, step = flat[chosen], row[chosen], step[chosen]
        count = np.bincount(row, minlength=rows)
        place = np.arange(len(row)) - (np.cumsum(count) - count)[row]
        longest = max(1, int(count.max(initial=0)))
        self.sample = np.zeros((rows, longest), np.int64)
        self.step = np.zeros((rows, longest), np.int64)
        self.valid = np.arange(longest) < count[:, None]
        self.sample[row, place] = flat
        self.step[row, place] = step
        # times of one plan never decrease
        self.step = np.maximum.accumulate(self.step, axis=1)


def history_log_likelihood(
    model: PersonalityModel, reading: Reading, evidence: PlayEvidence
) -> Float[np.ndarray, "replan theta"]:
    """Return the likelihood of each theta at every replan of a history."""
    rows = len(evidence.replans)
    theta = model.theta(evidence.history.agents)
    result = np.zeros((rows, len(theta)))
    samples = Samples(reading, evidence)
    row = np.arange(rows)
    if reading.reanchor:
        row = row[evidence.first != row]
        anchor = row - 1
    else:
        anchor = evidence.first
    for chosen, size in evidence.by_size(anchor):
        these, anchors = row[chosen], anchor[chosen]
        games, which = np.unique(anchors, return_inverse=True)
        game = evidence.game(games, size)
        among = coordination_equilibria(game, model.dominance).log_values > -np.inf
        classes = model.favoured(game.costs.transpose(1, 0, *range(2, game.costs.ndim)), among)
        squared: list[Float[np.ndarray, "replan _"] | None] = []
        seen = np.zeros(len(these), np.bool_)
        watched = reading.watched(len(size), evidence.player)
        for agent in range(len(size)):
            if agent not in watched:
                squared.append(None)
                continue
            far, known = squared_distances(reading, evidence, samples, these, anchors, agent)
            if not reading.reanchor:
                trials = np.unique(evidence.first[these], return_counts=True)[1]
                far = Ragged(far, trials).cumsum().values
            squared.append(far)
            seen |= known
        result[these] = reading.log_likelihood(squared, classes[:, which], among[which], ~seen)
    return result


def squared_distances(
    reading: Reading,
    evidence: PlayEvidence,
    samples: Samples,
    rows: Int[np.ndarray, " replan"],
    anchors: Int[np.ndarray, " replan"],
    agent: int,
) -> tuple[Float[np.ndarray, "replan plan"], Bool[np.ndarray, " replan"]]:
    """Return how far an agent's motion up to each replan was from its plans of the anchors, and where it was seen."""
    history = evidence.history
    every_plan = np.arange(history.plan_row_size[evidence.replans[anchors[0]], agent])
    where, speed = planned(
        evidence, samples, rows, anchors, agent, np.broadcast_to(every_plan, (len(rows), len(every_plan)))
    )
    seen = samples.sample[rows]
    state = history.position[seen, agent]
    known = samples.valid[rows] & ~np.isnan(state).any(axis=2)
    mask = known[:, None, :, None]
    difference = np.where(mask, where - state[:, None], 0.0)
    squared = np.einsum("rptj,rptj->rp", difference, difference)
    if reading.velocities:
        difference = np.where(mask, speed - history.velocity[seen, agent][:, None], 0.0)
        squared = squared + np.einsum("rptj,rptj->rp", difference, difference)
    return squared, known.any(axis=1)


def planned(
    evidence: PlayEvidence,
    samples: Samples,
    rows: Int[np.ndarray, " replan"],
    anchors: Int[np.ndarray, " replan"],
    agent: int,
    plans: Int[np.ndarray, "replan plan"],
) -> tuple[Float[np.ndarray, "replan plan time joint"], Float[np.ndarray, "replan plan time joint"]]:
    """Return where some of an agent's plans of the anchors are, and how fast they move, at the samples that count."""
    from ppinfer.coordination.scans import sample_plans

    history = evidence.history
    plan = (history.plan_start[evidence.replans[anchors], agent][:, None] + plans).ravel()
    count = plans.shape[1]
    when = np.repeat(samples.step[rows] * history.dt, count, axis=0)
    where, speed = sample_plans(
        history.waypoint_start[plan],
        history.waypoint_row_size[plan],
        history.waypoint_time,
        history.waypoint_position,
        when,
    )
    shape = (len(rows), count, when.shape[1], where.shape[-1])
    return where.reshape(shape), speed.reshape(shape)
