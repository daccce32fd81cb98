"""What was seen, planned and costed in many trials, as flat arrays: what personalities are inferred from offline."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
from jaxtyping import Bool, Float, Int, Shaped

from ppinfer.coordination.plans import PlanSet
from ppinfer.coordination.situation import Motion, Situation
from ppinfer.distributions import row_starts
from ppinfer.errors import ModelError
from ppinfer.games import Game

if TYPE_CHECKING:
    from ppinfer.coordination.evidence import PlayEvidence


@dataclass(frozen=True, eq=False)
class PlayHistory:
    """Motion, plans and costs of many trials, everything end to end: in trial, replan, agent and plan order.

    Parameters
    ----------
    agents : tuple of str
        In the order of the agent dimension.
    row_size : (trial,) int64
        Samples of each trial.
    position, velocity : (sample, agent, joint) float64
        Joint angles, rad, and their rates, rad/s; NaN where an agent has left.
    held : (sample,) bool
        Whether a safety stop held everybody in the step that led to the sample.
    replan_row_size : (trial,) int64
        Replans of each trial, of all agents' views.
    replan_sample : (replan,) int64
        The sample, counted within its trial, at which each replan was made.
    replan_time : (replan,) float64
        Seconds since the trial began.
    replan_agent : (replan,) str
        Whose view it is: who sampled these plans and decides.
    replan_seed : (replan,) int64
        From which the deciding policy draws.
    plan_row_size : (replan, agent) int64
        Plans of each agent.
    static_plan, committed_plan : (replan, agent) int64
        Which of them does not move, and which is the rest of the one being executed; -1: none.
    waypoint_row_size : (plan,) int64
        Waypoints of each plan.
    waypoint_time : (waypoint,) float64
        Seconds from the replan.
    waypoint_position : (waypoint, joint) float64
        Joint angles, rad.
    cost : (profile, agent) float64
        Seconds, inf for a collision; the profiles of each replan in C order of the agents.
    contact_time : (profile,) float64, optional
        Seconds until first contact, inf for never.
    dt : float
        Seconds between samples.

    Raises
    ------
    ModelError
        If the arrays do not fit each other; the message says which.

    See Also
    --------
    infer_personality : what it is for.

    Examples
    --------
    >>> robot = PlanSet("robot", [2, 1], [0.0, 2.0, 0.0], [[0.0], [1.0], [0.0]], static=1)
    >>> human = PlanSet("human", [2, 1], [0.0, 4.0, 0.0], [[0.0], [1.0], [0.0]], static=1)
    >>> situation = Situation.from_contacts([robot, human], [[1.5, np.inf], [np.inf, np.inf]])
    >>> history = PlayHistory.from_situations([[situation]], "robot")
    >>> history.situation(0, 0).game == situation.game
    True
    """

    agents: tuple[str, ...]
    row_size: Int[np.ndarray, " trial"]
    position: Float[np.ndarray, "sample agent joint"]
    velocity: Float[np.ndarray, "sample agent joint"]
    held: Bool[np.ndarray, " sample"]
    replan_row_size: Int[np.ndarray, " trial"]
    replan_sample: Int[np.ndarray, " replan"]
    replan_time: Float[np.ndarray, " replan"]
    replan_agent: Shaped[np.ndarray, " replan"]
    replan_seed: Int[np.ndarray, " replan"]
    plan_row_size: Int[np.ndarray, "replan agent"]
    static_plan: Int[np.ndarray, "replan agent"]
    committed_plan: Int[np.ndarray, "replan agent"]
    waypoint_row_size: Int[np.ndarray, " plan"]
    waypoint_time: Float[np.ndarray, " waypoint"]
    waypoint_position: Float[np.ndarray, "waypoint joint"]
    cost: Float[np.ndarray, "profile agent"]
    contact_time: Float[np.ndarray, " profile"] | None = None
    dt: float = 0.1

    def __post_init__(self) -> None:
        object.__setattr__(self, "agents", tuple(self.agents))
        samples, replans = len(self.position), len(self.replan_sample)
        plans, waypoints = len(self.waypoint_row_size), len(self.waypoint_time)
        profiles, agents = len(self.cost), len(self.agents)
        joints = self.position.shape[-1]
        shapes = {
            "row_size": (len(self.row_size),),
            "position": (samples, agents, joints),
            "velocity": (samples, agents, joints),
            "held": (samples,),
            "replan_row_size": (len(self.row_size),),
            "replan_sample": (replans,),
            "replan_time": (replans,),
            "replan_agent": (replans,),
            "replan_seed": (replans,),
            "plan_row_size": (replans, agents),
            "static_plan": (replans, agents),
            "committed_plan": (replans, agents),
            "waypoint_row_size": (plans,),
            "waypoint_time": (waypoints,),
            "waypoint_position": (waypoints, joints),
            "cost": (profiles, agents),
        } | ({} if self.contact_time is None else {"contact_time": (profiles,)})
        faults = [
            f"{name} has shape {getattr(self, name).shape}, not {shape}"
            for name, shape in shapes.items()
            if getattr(self, name).shape != shape
        ]
        if not faults:
            sums = (
                ("row_size", self.row_size, "samples", samples),
                ("replan_row_size", self.replan_row_size, "replans", replans),
                ("plan_row_size", self.plan_row_size, "plans", plans),
                (
                    "the product of plan_row_size over agents",
                    self.plan_row_size.prod(axis=1),
                    "profiles",
                    profiles,
                ),
                ("waypoint_row_size", self.waypoint_row_size, "waypoints", waypoints),
            )
            faults = [
                f"{name} sums to {sizes.sum()}, but there are {count} {what}"
                for name, sizes, what, count in sums
                if sizes.sum() != count or (sizes < 0).any()
            ]
        if not faults and replans:
            within = self.row_size[self.trial_of_replan]
            if ((self.replan_sample < 0) | (self.replan_sample >= within)).any():
                faults.append("replan_sample points outside its trial's samples")
            if (self.plan_row_size < 1).any():
                faults.append("plan_row_size is 0 somewhere: every agent has at least one plan")
        if faults:
            raise ModelError("a history of play does not fit together: " + "; ".join(faults))

    @classmethod
    def from_situations(cls, trials: Sequence[Sequence[Situation]], ego: str) -> PlayHistory:
        """Lay the situations that one agent saw, in some trials, end to end.

        Parameters
        ----------
        trials : sequence of sequences of Situation
            The situations of each trial in order, at least one; all but the first of each carry the motion since the
            one before, from the same sample on that the motion before ended with.
        ego : str
            Whose view it is.
        """
        every = [situation for trial in trials for situation in trial]
        if not every or not all(len(trial) for trial in trials):
            raise ModelError("a history needs at least one trial, and each trial at least one situation")
        motions = [_motion_of(trial) for trial in trials]
        after = [[one.motion for one in trial[1:] if one.motion is not None] for trial in trials]
        sets = [plans for situation in every for plans in situation.plans]
        players = len(every[0].plans)

        def numbers(values: Sequence[int | None]) -> Int[np.ndarray, "replan agent"]:
            return np.array([-1 if one is None else one for one in values], np.int64).reshape(-1, players)

        contacts = [situation.contact_time for situation in every]
        return cls(
            agents=every[0].agents,
            row_size=np.array([len(motion.position) for motion in motions], np.int64),
            position=np.concatenate([motion.position for motion in motions]),
            velocity=np.concatenate([motion.velocity for motion in motions]),
            held=np.concatenate([motion.held for motion in motions]),
            replan_row_size=np.array([len(trial) for trial in trials], np.int64),
            replan_sample=np.concatenate(
                [np.cumsum([0, *(len(motion.position) - 1 for motion in trial)]) for trial in after]
            ).astype(np.int64),
            replan_time=np.array([situation.time for situation in every], np.float64),
            replan_agent=np.array([ego] * len(every), object),
            replan_seed=np.array([situation.seed for situation in every], np.int64),
            plan_row_size=numbers([len(plans) for plans in sets]),
            static_plan=numbers([plans.static for plans in sets]),
            committed_plan=numbers([plans.committed for plans in sets]),
            waypoint_row_size=np.concatenate([plans.row_size for plans in sets]),
            waypoint_time=np.concatenate([plans.time for plans in sets]),
            waypoint_position=np.concatenate([plans.position for plans in sets]),
            cost=np.concatenate([one.game.costs.reshape(players, -1).T for one in every]),
            contact_time=None
            if any(contact is None for contact in contacts)
            else np.concatenate([np.ravel(contact) for contact in contacts if contact is not None]),
            dt=motions[0].dt,
        )

    def seen_by(self, ego: str) -> PlayEvidence:
        """Return what an agent saw: its own replans, and the motion of everybody between them."""
        from ppinfer.coordination.evidence import PlayEvidence

        return PlayEvidence(self, ego)

    def situation(self, trial: int, replan: int) -> Situation:
        """Return one replan of a trial as the policy saw it; replans are counted within the trial, of all agents.

        Raises
        ------
        ModelError
            If there is no such trial or replan.
        """
        if not 0 <= trial < len(self.row_size) or not 0 <= replan < self.replan_row_size[trial]:
            replans = self.replan_row_size[trial] if 0 <= trial < len(self.row_size) else 0
            raise ModelError(
                f"there is no replan {replan} in trial {trial}: there are {len(self.row_size)} trials, and {replans} "
                "replans in that one"
            )
        row = int(self.replan_start[trial]) + replan
        plans = tuple(self._plan_set(row, agent) for agent in range(len(self.agents)))
        shape = tuple(len(one) for one in plans)
        start = self.profile_start[row]
        stop = start + int(np.prod(shape))
        game = Game(
            self.cost[start:stop].T.reshape(len(shape), *shape), self.agents, [one.axis for one in plans]
        )
        contact = None if self.contact_time is None else self.contact_time[start:stop].reshape(shape)
        return Situation(
            plans,
            game,
            contact,
            self._motion(trial, row),
            float(self.replan_time[row]),
            int(self.replan_seed[row]),
        )

    def _plan_set(self, row: int, agent: int) -> PlanSet:
        first = int(self.plan_start[row, agent])
        last = first + int(self.plan_row_size[row, agent])
        start = int(self.waypoint_start[first])
        stop = start + int(self.waypoint_row_size[first:last].sum())
        static, committed = int(self.static_plan[row, agent]), int(self.committed_plan[row, agent])
        return PlanSet(
            self.agents[agent],
            self.waypoint_row_size[first:last],
            self.waypoint_time[start:stop],
            self.waypoint_position[start:stop],
            static=None if static < 0 else static,
            committed=None if committed < 0 else committed,
        )

    def _motion(self, trial: int, row: int) -> Motion | None:
        first = int(self.replan_start[trial])
        own = np.flatnonzero(self.replan_agent[first:row] == self.replan_agent[row])
        if not len(own):
            return None
        start = int(self.row_start[trial] + self.replan_sample[first + own[-1]])
        stop = int(self.row_start[trial] + self.replan_sample[row]) + 1
        held = self.held[start:stop].copy()
        held[:1] = False
        return Motion(self.position[start:stop], self.velocity[start:stop], held, self.dt)

    # where things begin

    @cached_property
    def row_start(self) -> Int[np.ndarray, " trial"]:
        """The first sample of each trial."""
        return np.asarray(row_starts(self.row_size))

    @cached_property
    def replan_start(self) -> Int[np.ndarray, " trial"]:
        """The first replan of each trial."""
        return np.asarray(row_starts(self.replan_row_size))

    @cached_property
    def trial_of_replan(self) -> Int[np.ndarray, " replan"]:
        """The trial of each replan."""
        return np.repeat(np.arange(len(self.row_size)), self.replan_row_size)

    @cached_property
    def plan_start(self) -> Int[np.ndarray, "replan agent"]:
        """The first plan of each agent at each replan."""
        return np.asarray(row_starts(self.plan_row_size.ravel()).reshape(self.plan_row_size.shape))

    @cached_property
    def waypoint_start(self) -> Int[np.ndarray, " plan"]:
        """The first waypoint of each plan."""
        return np.asarray(row_starts(self.waypoint_row_size))

    @cached_property
    def profile_start(self) -> Int[np.ndarray, " replan"]:
        """The first profile of each replan."""
        return np.asarray(row_starts(self.plan_row_size.prod(axis=1)))


def _motion_of(trial: Sequence[Situation]) -> Motion:
    """Return the motion of a whole trial, its pieces joined."""
    pieces = [situation.motion for situation in trial[1:]]
    if any(piece is None for piece in pieces):
        raise ModelError("every situation of a trial but the first needs the motion since the one before")
    moved = [piece for piece in pieces if piece is not None]
    if not moved:
        start = np.stack([plans.position[0] for plans in trial[0].plans])[None]
        return Motion(start, np.zeros_like(start), np.zeros(1, np.bool_))
    first = moved[0]
    return Motion(
        np.concatenate([first.position[:1], *(piece.position[1:] for piece in moved)]),
        np.concatenate([first.velocity[:1], *(piece.velocity[1:] for piece in moved)]),
        np.concatenate([np.zeros(1, np.bool_), *(piece.held[1:] for piece in moved)]),
        first.dt,
    )
