"""One trial of two arms: both plan, decide and move, until both have finished."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float

from ppinfer.coordination import Decision, Motion, PlanSet, Policy, Situation
from ppinfer.errors import PPInferError
from ppsim.arms.contacts import contact_tables
from ppsim.arms.execution import NEAR, PLAN_SETS, Execution
from ppsim.arms.following import Follower
from ppsim.arms.plans import Rest, sample_plans, straight_plan
from ppsim.arms.scene import Scene
from ppsim.arms.world import STEP, ArmsWorld
from ppsim.errors import SimulationError


@dataclass(frozen=True, eq=False)
class Replanned:
    """One replan as the robot saw it: when, what, and what it decided."""

    sample: int
    situation: Situation
    decision: Decision


@dataclass(frozen=True, eq=False)
class Played:
    """What happened in a trial.

    Parameters
    ----------
    position, velocity : (sample, agent, joint) float64
        rad and rad/s; NaN once an agent has finished and left.
    held : (sample,) bool
        Whether a safety stop held both in the step that led to the sample.
    finish_time : (agent,) float64
        Seconds; NaN for whoever did not finish.
    replans : tuple of Replanned
        The robot's.
    contacts : int
        Contacts of the arms in the physical world. The safety stop looks at poses half a step apart, which leaves room
        for arms that brush each other in between.
    """

    position: Float[np.ndarray, "sample agent joint"]
    velocity: Float[np.ndarray, "sample agent joint"]
    held: Bool[np.ndarray, " sample"]
    finish_time: Float[np.ndarray, " agent"]
    replans: tuple[Replanned, ...]
    contacts: int

    @property
    def stops(self) -> int:
        """How many safety stops there were: steps that were held."""
        return int(self.held.sum())

    @property
    def stop_episodes(self) -> int:
        """How many episodes of stops; a gap over 0.8 s begins a new one."""
        when = np.flatnonzero(self.held)
        return int(len(when) > 0) + int((np.diff(when) > round(0.8 / STEP)).sum())


def play(
    scene: Scene,
    policies: Mapping[str, Policy],
    *,
    seed: int,
    plan_sets: str = "shared",
    execution: Execution | None = None,
) -> Played:
    """Play one trial.

    1. Every 0.8 s, and after every safety stop, both agents sample plans, look at the situation and decide. With
       shared plan sets both look at the same plans; with independent ones each samples its own view of both agents.
    2. Before each step of 0.1 s the next pose and the one half way there are checked: if the arms would collide, both
       hold for that step, which is one safety stop. After five in a row a coin sends one arm home for 2.4 s.
    3. An arm that comes to its pick grasps, one that then comes to its place has finished, and leaves.

    Parameters
    ----------
    scene : Scene
        The arms and what each has to do.
    policies : mapping from agent to Policy
        The first of the scene's agents is the robot.
    seed : int
        Of all plans and coins. Plans do not depend on the policies, so that trials of one scene and seed are paired.
    plan_sets : {"shared", "independent"}
        Whose plans they are.
    execution : Execution, optional
        How plans are judged and carried out.

    Raises
    ------
    SimulationError
        If the plan sets are called otherwise, an agent has no policy, or a policy chose a plan that is not there.

    Examples
    --------
    >>> from ppinfer.coordination import NormNash, Selfish
    >>> scene = Scene.random(np.random.default_rng(1))
    >>> played = play(scene, {"robot": NormNash(), "human": Selfish()}, seed=1)
    >>> played.finish_time.shape, played.replans[0].decision.plan < 8
    ((2,), True)
    """
    if plan_sets not in PLAN_SETS:
        raise SimulationError(f"plan sets are {' or '.join(PLAN_SETS)}; got {plan_sets!r}")
    missing = [agent for agent in scene.agents if agent not in policies]
    if missing:
        raise SimulationError(f"{missing[0]} has no policy")
    return _Trial(scene, policies, seed, plan_sets == "shared", execution or Execution()).play()


#: plans, times of collision, and times of contact
_View = tuple[tuple[PlanSet, ...], Float[np.ndarray, "one two"], Float[np.ndarray, "one two"]]

#: spawn keys that keep apart the seeds of plans, of what policies draw, and of coins
_PLANS, _CHANCE, _COINS = 0, 1, 2


class _Trial:
    """A trial while it is played."""

    def __init__(
        self, scene: Scene, policies: Mapping[str, Policy], seed: int, shared: bool, execution: Execution
    ) -> None:
        self.scene, self.seed, self.shared, self.execution = scene, seed, shared, execution
        self.world = ArmsWorld(scene)
        self.agents = scene.agents
        self.seats = {agent: Follower(agent, policies[agent]) for agent in self.agents}
        self.finish = dict.fromkeys(self.agents, np.nan)
        self.positions: list[Float[np.ndarray, "agent joint"]] = []
        self.velocities: list[Float[np.ndarray, "agent joint"]] = []
        self.held: list[bool] = []
        self.replans: list[Replanned] = []
        self.count = 0
        self.coins = self._rng(_COINS)
        every = round(execution.replan_every / STEP)
        # as far as anybody may have to know where it is to be before it decides again
        self.half_steps = np.arange(2 * every + 1) * (STEP / 2)
        self.every = every

    def play(self) -> Played:
        self._log(held=False)
        last = round(self.execution.timeout / STEP)
        in_a_row, since = 0, self.every
        while self.active and len(self.held) <= last:
            if since >= self.every:
                self._replan()
                since = 0
            poses = {agent: self.seats[agent].next_poses() for agent in self.active}
            if any(
                self.world.would_collide({agent: two[half] for agent, two in poses.items()})
                for half in (0, 1)
            ):
                self.world.hold()
                self._log(held=True)
                self._count_down()
                in_a_row, since = in_a_row + 1, self.every
                if in_a_row == self.execution.stops_in_a_row:
                    self._send_home()
                    in_a_row = 0
                continue
            self.world.step({agent: two[1] for agent, two in poses.items()})
            for agent in self.active:
                self.seats[agent].advance()
            in_a_row, since = 0, since + 1
            self._log(held=False)
            self._arrive()
            if self._count_down():
                # who came back from home has nothing to follow
                since = self.every
        return Played(
            position=np.array(self.positions),
            velocity=np.array(self.velocities),
            held=np.array(self.held),
            finish_time=np.array([self.finish[agent] for agent in self.agents]),
            replans=tuple(self.replans),
            contacts=self.world.contacts,
        )

    @property
    def active(self) -> list[str]:
        """Those who have not finished."""
        return [agent for agent in self.agents if np.isnan(self.finish[agent])]

    def _replan(self) -> None:
        here = {agent: self.world.position(agent) for agent in self.agents if agent in self.active}
        rests = {
            agent: self.seats[agent].rest(where) if self.seats[agent].policy.commits else None
            for agent, where in here.items()
        }
        count = max(self.seats[agent].policy.samples for agent in self.active)
        shared = self._plans(0, here, rests, count) if self.shared else None
        seen: dict[int, _View] = {}
        for viewer, agent in enumerate(self.agents):
            seat = self.seats[agent]
            if agent not in here or seat.retreat:
                continue
            want = seat.policy.samples
            if shared is None:
                view = self._view(self._plans(viewer, here, {agent: rests[agent]}, want), want)
            else:
                # who wants as many plans looks at the same
                view = seen[want] if want in seen else self._view(shared, want)
                seen[want] = view
            situation = self._situation(view, seat)
            decision = self._decision(seat, situation)
            plans = situation.plans[viewer]
            if viewer == 0:
                self.replans.append(Replanned(len(self.held) - 1, situation, decision))
            seat.begin(plans, decision, self.half_steps)
            seat.replanned = len(self.held) - 1
        self.count += 1

    def _decision(self, seat: Follower, situation: Situation) -> Decision:
        """Return what a policy decides; one that fails is named, since it may be anybody's."""
        who = f"policy {seat.policy.name!r} of {seat.agent}, {situation.time:.1f} s into the trial"
        try:
            decision: object = seat.policy.decide(situation, seat.agent, seat.memory)
        except PPInferError as error:
            raise SimulationError(f"{who}: {error}") from error
        except Exception as error:
            raise SimulationError(f"{who}: raised {type(error).__name__}: {error}") from error
        if not isinstance(decision, Decision):
            raise SimulationError(f"{who}: returned a {type(decision).__name__}; expected a Decision")
        plans = situation.plans[situation.player(seat.agent)]
        if not isinstance(decision.plan, int | np.integer) or not 0 <= decision.plan < len(plans):
            raise SimulationError(f"{who}: decided on plan {decision.plan!r}; there are {len(plans)}")
        return decision

    def _plans(
        self,
        viewer: int,
        here: Mapping[str, Float[np.ndarray, " joint"]],
        rests: Mapping[str, Rest | None],
        count: int,
    ) -> tuple[PlanSet, ...]:
        """Return what everybody might do, as one viewer imagines it."""
        plans = []
        for player, agent in enumerate(self.agents):
            if agent not in here:
                plans.append(PlanSet.holding(agent, self.scene.tasks[agent].place_joints[0]))
                continue
            plans.append(
                sample_plans(
                    self.scene.arms[agent],
                    agent,
                    here[agent],
                    self.scene.tasks[agent].goals(holding=self.seats[agent].holding),
                    seed=self._seed(_PLANS, self.count, viewer, player),
                    count=count,
                    planner=self.execution.planner,
                    committed=rests.get(agent),
                )
            )
        return tuple(plans)

    def _view(self, plans: tuple[PlanSet, ...], want: int) -> _View:
        """Return as many of the plans as somebody wants to look at, and when they come into contact."""
        if any(len(own) > want + 1 for own in plans):
            # shared sets are as large as the more curious of the two wants them
            plans = tuple(own.restrict([*range(min(want, len(own) - 1)), len(own) - 1]) for own in plans)
        gone = [agent for agent in self.agents if agent not in self.active]
        if gone:
            shape = tuple(len(own) for own in plans)
            collision = contact = np.full(shape, np.inf)
        else:
            collision, contact = contact_tables(
                [self.scene.arms[agent] for agent in self.agents],
                plans,
                stride=self.execution.collision_stride,
                clearance=self.execution.clearance,
            )
        return plans, collision, contact

    def _situation(self, view: _View, seat: Follower) -> Situation:
        plans, collision, contact = view
        motion = None
        if seat.replanned is not None:
            held = np.array(self.held[seat.replanned :])
            # the step that led to the last replan was told then
            held[0] = False
            motion = Motion(
                np.array(self.positions[seat.replanned :]),
                np.array(self.velocities[seat.replanned :]),
                held,
                STEP,
            )
        return Situation.from_contacts(
            plans,
            collision,
            contact_time=contact,
            motion=motion,
            time=(len(self.held) - 1) * STEP,
            seed=self._seed(_CHANCE, self.count, self.agents.index(seat.agent)),
        )

    def _log(self, *, held: bool) -> None:
        position, velocity = np.full((2, len(self.agents), 2), np.nan)
        for player, agent in enumerate(self.agents):
            if agent in self.active:
                position[player], velocity[player] = self.world.position(agent), self.world.velocity(agent)
        self.positions.append(position)
        self.velocities.append(velocity)
        self.held.append(held)

    def _arrive(self) -> None:
        """Let arms grasp, and let them finish."""
        for agent in self.active:
            seat, task = self.seats[agent], self.scene.tasks[agent]
            tip = self.world.end_effector(agent)
            if not seat.holding and np.linalg.norm(tip - task.pick) <= NEAR:
                seat.holding = True
                self.world.grasp(agent)
            elif seat.holding and np.linalg.norm(tip - task.place) <= NEAR:
                self.finish[agent] = (len(self.held) - 1) * STEP
                self.world.remove(agent)

    def _count_down(self) -> bool:
        """Return whether somebody's time at home, or on the way there, is over."""
        retreating = [self.seats[agent] for agent in self.active if self.seats[agent].retreat]
        return sum(seat.count_down() for seat in retreating) > 0

    def _send_home(self) -> None:
        agent = self.active[int(self.coins.integers(len(self.active)))]
        home = straight_plan(
            self.scene.arms[agent], agent, self.world.position(agent), self.scene.arms[agent].home
        )
        self.seats[agent].go_home(home, round(self.execution.retreat / STEP))

    def _rng(self, *key: int) -> np.random.Generator:
        return np.random.default_rng(np.random.SeedSequence(self.seed, spawn_key=key))

    def _seed(self, *key: int) -> int:
        # a log can hold it
        return int(
            np.random.SeedSequence(self.seed, spawn_key=key).generate_state(1, np.uint64)[0] >> np.uint64(1)
        )
