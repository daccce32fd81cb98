"""Examples for learned prediction: what simulated humans do next, again and again, given a plan of the robot."""

from __future__ import annotations

import math
import os
from dataclasses import asdict, dataclass, field
from functools import cached_property

import numpy as np
from jaxtyping import Bool, Float, Int

from ppinfer.goals.learned import PredictionExamples
from ppinfer.goals.learned.nominal import nominal_plans
from ppinfer.studies.prediction_examples import ExampleHeader, ExampleWriter, StoredExamples
from ppinfer.studies.progress import ProgressCallback, silent
from ppsim.errors import SimulationError
from ppsim.reaching.many_games import KINDS, GameRules, ManyGames
from ppsim.reaching.movement import Movement
from ppsim.reaching.rules import Rules
from ppsim.reaching.world import goals_reached
from ppsim.seeds import batch_rng
from ppsim.workers import in_order

_FASTEST = 1e6


@dataclass(frozen=True)
class ExampleStudy:
    """All that a set of examples is, its seed included: batch i is a function of this and of i.

    1. In a game the robot follows its nominal plan (LQR) to some goal. Every `every` seconds it thinks anew: with
       probability `keep` it keeps its goal, else it draws any.
    2. Each of these instants is an example: the motion so far, and the plan it now has.
    3. From there the game goes on `continuations` times with the robot following that plan, until the human is at a
       goal: how often it was which is the example's frequency. Continuations differ by the disturbance of the human's
       motion only. In one that ends before the human is at any goal, that nearest to it then counts.
    4. The game itself goes on with a disturbance of its own to the next instant. Where both are at distinct goals
       they score, and goals are drawn anew.

    Parameters
    ----------
    seed : int
        Of the study.
    goals : tuple of int
        How many goals a game has, drawn from these.
    humans : tuple of {"waiting", "moving", "stubborn"}
        Kinds of simulated humans, drawn from these for each game.
    noise : float
        Standard deviation of the disturbance of the human's velocity, per dimension and step (m/s).
    past, horizon : int
        Steps of motion so far, the present one included, and of the plan.
    continuations : int
        How often each example goes on.
    limit : float
        Longest continuation (s).
    games, instants : int
        Games a batch, and examples a game.
    every, keep : float
        Seconds between the examples of a game, and the probability that the robot then keeps its goal.
    movement : Movement
        Of both agents.

    Raises
    ------
    SimulationError
        Where a value is out of its range.

    Examples
    --------
    >>> study = ExampleStudy(seed=1, games=2, instants=3, continuations=2)
    >>> study.batch(0).examples.frequency.sum(axis=1)
    array([1., 1., 1., 1., 1., 1.], dtype=float32)
    """

    seed: int = 0
    goals: tuple[int, ...] = (3, 4, 5)
    humans: tuple[str, ...] = KINDS
    noise: float = 0.5
    past: int = 10
    horizon: int = 20
    continuations: int = 8
    limit: float = 10.0
    games: int = 100
    instants: int = 10
    every: float = 1.0
    keep: float = 0.5
    movement: Movement = field(default_factory=Movement)

    def __post_init__(self) -> None:
        for name in ("past", "horizon", "continuations", "games", "instants"):
            if getattr(self, name) < 1:
                raise SimulationError(f"{name} must be at least 1; got {getattr(self, name)}")
        if self.seed < 0:
            raise SimulationError(f"seed must not be negative; got {self.seed}")
        # examples are in single precision
        if not 0 <= self.noise <= _FASTEST:
            raise SimulationError(
                f"noise must be finite and not negative, at most {_FASTEST:g} (m/s); got {self.noise!r}"
            )
        if not 0 <= self.keep <= 1:
            raise SimulationError(f"keep must be a probability; got {self.keep!r}")
        for name in ("every", "limit"):
            if not (math.isfinite(getattr(self, name)) and getattr(self, name) >= self.movement.dt):
                raise SimulationError(f"{name} must be at least one step of {self.movement.dt:g} s")
        unknown = [kind for kind in self.humans if kind not in KINDS]
        if unknown or not self.humans:
            raise SimulationError(
                f"humans must be some of {', '.join(KINDS)}; got {', '.join(unknown) or 'none'}"
            )
        if not self.goals or min(self.goals) < 2:
            raise SimulationError(f"goals must be at least 2, for two agents; got {self.goals}")
        for count in self.goals:
            _ = Rules(goals=count)

    def header(self) -> ExampleHeader:
        """Return what a store of these examples says once."""
        told = asdict(self)
        for name in ("past", "horizon", "movement"):
            del told[name]
        return ExampleHeader(
            past=self.past,
            horizon=self.horizon,
            goals=max(self.goals),
            states=4,
            dynamics="double-integrator",
            dt=self.movement.dt,
            state_weight=self.movement.state_weight,
            control_weight=self.movement.control_weight,
            kinds=KINDS,
            batch=self.batch_size,
            configuration={"world": "reaching", **told, "human_rationality": self.movement.rationality},
        )

    @property
    def batch_size(self) -> int:
        """Examples of a batch."""
        return self.games * self.instants

    def batch(self, index: int) -> StoredExamples:
        """Return the examples of one batch, those of a game side by side."""
        rng = batch_rng(self.seed, index)
        games, rules = self._start(rng)
        agents = np.stack([games.human, games.robot], axis=1)
        seen = np.repeat(agents[None], self.past, axis=0)
        robot_goal = _any_goal(rng, games.present)
        found = []
        for instant in range(self.instants):
            if instant:
                other = _any_goal(rng, games.present)
                robot_goal = np.where(rng.random(self.games) < self.keep, robot_goal, other)
            found.append(self._examples(games, seen, robot_goal, rng))
            for _ in range(round(self.every / self.movement.dt)):
                games = self._rules.step(games, robot_goal, rng.standard_normal((self.games, 2)))
                games, robot_goal = _scored(games, robot_goal, rules, rng)
                seen = np.concatenate([seen[1:], np.stack([games.human, games.robot], axis=1)[None]])
        # from instants of all games to games with all their instants
        order = np.arange(self.batch_size).reshape(self.instants, self.games).T.reshape(-1)
        examples = PredictionExamples.concatenate([each.examples for each in found]).take(order)
        kind, interaction = (
            np.concatenate([getattr(each, name) for each in found])[order] for name in ("kind", "interaction")
        )
        return StoredExamples(examples, kind, interaction)

    @cached_property
    def _rules(self) -> GameRules:
        return GameRules(self.movement, self.noise)

    def _start(self, rng: np.random.Generator) -> tuple[ManyGames, list[Rules]]:
        rules = [Rules(goals=count) for count in rng.choice(self.goals, self.games).tolist()]
        kind = rng.choice([KINDS.index(name) for name in self.humans], self.games)
        starts = np.stack([each.draw_starts(rng, 2) for each in rules])
        goals = np.zeros((self.games, max(self.goals), 2))
        present = np.zeros(goals.shape[:2], dtype=bool)
        for game, each in enumerate(rules):
            goals[game, : each.goals] = each.draw_goals(rng, starts[game])
            present[game, : each.goals] = True
        states = self.movement.dynamics.goal_states(starts)
        return ManyGames.start(states[:, 0], states[:, 1], goals, present, kind), rules

    def _examples(
        self,
        games: ManyGames,
        seen: Float[np.ndarray, "past game 2 4"],
        robot_goal: Int[np.ndarray, " game"],
        rng: np.random.Generator,
    ) -> StoredExamples:
        target = games.goals[np.arange(self.games), robot_goal]
        plan = nominal_plans(self.movement.agent, games.robot, target, self.horizon)
        frequency, steps = self._continue(games, robot_goal, rng)
        past = np.swapaxes(seen, 0, 1).astype(np.float32)
        examples = PredictionExamples(
            human=past[:, :, 0],
            robot=past[:, :, 1],
            plan=plan.astype(np.float32),
            goals=games.goals.astype(np.float32),
            present=games.present,
            frequency=frequency.astype(np.float32),
            robot_goal=robot_goal,
        )
        interaction = (self.movement.dt * steps + self.every).astype(np.float32)
        return StoredExamples(examples, games.kind, interaction)

    def _continue(
        self, games: ManyGames, robot_goal: Int[np.ndarray, " game"], rng: np.random.Generator
    ) -> tuple[Float[np.ndarray, "game goal"], Int[np.ndarray, " game"]]:
        """Return how often each goal was reached first, and the steps that all continuations took together."""
        game = np.repeat(np.arange(self.games), self.continuations)
        going, row = games.take(game), np.arange(len(game))
        reached = np.full(len(game), -1)
        steps = np.zeros(len(game), dtype=np.int64)
        radius = Rules.pick_radius
        for step in range(round(self.limit / self.movement.dt) + 1):
            distance = going.distance(going.human)
            nearest = distance.argmin(axis=1)
            there = distance[np.arange(len(row)), nearest] <= radius
            reached[row[there]], steps[row[there]] = nearest[there], step
            left = ~there
            going, row, nearest = going.take(np.flatnonzero(left)), row[left], nearest[left]
            if not len(row):
                break
            reached[row], steps[row] = nearest, step
            # as many draws as there are continuations, so that one that ends leaves the others as they were
            drawn = rng.standard_normal((len(game), 2))[row]
            going = self._rules.step(going, robot_goal[game[row]], drawn)
        counts = np.zeros(games.goals.shape[:2])
        np.add.at(counts, (game, reached), 1.0)
        return counts / self.continuations, np.bincount(game, weights=steps, minlength=self.games).astype(
            np.int64
        )


def _any_goal(rng: np.random.Generator, present: Bool[np.ndarray, "game goal"]) -> Int[np.ndarray, " game"]:
    drawn: np.ndarray = rng.integers(present.sum(axis=1))
    return drawn


def _scored(
    games: ManyGames, robot_goal: Int[np.ndarray, " game"], rules: list[Rules], rng: np.random.Generator
) -> tuple[ManyGames, Int[np.ndarray, " game"]]:
    """Return the games with new goals where both agents are at distinct ones, and a new goal for the robot there."""
    radius = Rules.pick_radius
    near = (games.distance(games.human).min(axis=1) <= radius) & (
        games.distance(games.robot).min(axis=1) <= radius
    )
    for game in np.flatnonzero(near).tolist():
        position = np.stack([games.human[game, [0, 2]], games.robot[game, [0, 2]]])
        at = goals_reached(position, games.goals[game, games.present[game]], radius)
        if at[0] != at[1]:
            games = games.with_goals(game, rules[game].draw_goals(rng, position))
            robot_goal = robot_goal.copy()
            robot_goal[game] = rng.integers(rules[game].goals)
    return games, robot_goal


def record_examples(
    study: ExampleStudy,
    examples: int,
    target: str | os.PathLike[str],
    *,
    workers: int = 1,
    progress: ProgressCallback = silent,
) -> int:
    """Generate examples and append them to a store as they come; return how many were there already.

    The first n examples of a study are the same however many are asked for, whoever of the workers made them. A store
    that an interrupted run left, or a shorter one of the same study, is continued; memory does not grow with it.

    Parameters
    ----------
    study : ExampleStudy
        What to generate.
    examples : int
        How many there are to be in the end.
    target : path
        The store, a ``.zarr`` folder.
    workers : int
        Processes.
    progress : callable
        Told how many examples are done, of how many.

    Raises
    ------
    SimulationError
        Where none are asked for, there are no workers, or the store holds more already.
    LogError
        Where something else is there, or examples that were made otherwise.

    Examples
    --------
    >>> study = ExampleStudy(games=2, instants=2, continuations=1, limit=0.5)
    >>> record_examples(study, 6, "few.zarr"), record_examples(study, 9, "few.zarr")
    (0, 6)
    """
    for name, count in (("examples", examples), ("workers", workers)):
        if count < 1:
            raise SimulationError(f"{name} must be at least 1; got {count}")
    writer = ExampleWriter(target, study.header())
    resumed = writer.complete
    if resumed > examples:
        raise SimulationError(
            f"{target}: already holds {resumed} examples, more than the {examples} asked for; ask for as many, or "
            "remove it"
        )
    progress(resumed, examples)
    if resumed == examples:
        return resumed
    size = study.batch_size
    first, last = resumed // size, -(-examples // size)
    batches = in_order(study.batch, range(first, last), workers=workers)
    for index, batch in zip(range(first, last), batches, strict=True):
        start, stop = max(0, resumed - index * size), min(size, examples - index * size)
        writer.append(batch.take(slice(start, stop)))
        progress(writer.complete, examples)
    return resumed
