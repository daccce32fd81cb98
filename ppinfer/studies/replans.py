"""Replans of a trial: what an agent saw when it decided, and all of a trial's replans as flat arrays."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields
from typing import Any

import numpy as np
from jaxtyping import Float, Int, Shaped

from ppinfer.coordination.plans import PlanSet
from ppinfer.coordination.policy import Decision
from ppinfer.coordination.situation import Situation
from ppinfer.errors import LogError


@dataclass(frozen=True, eq=False)
class Replan:
    """One replan, as the agent that made it saw it.

    Parameters
    ----------
    time : float
        Seconds, the time of `sample`.
    sample : int
        The sample of the trial at which it was made.
    agent : str
        Who replanned.
    plans : sequence of PlanSet
        Of every agent that is still there.
    cost : (agent, plan, ...) float64
        Seconds, of every profile of `plans` and for every agent of `plans`; inf where agents collide.
    contact_time : (plan, ...) float64
        Seconds until agents first touch in every profile; inf where they never do.
    decision : sequence of int
        The profile chosen, a plan of each of `plans`; -1 for others where none was chosen for them.
    live_log_posterior : (theta,) float64, optional
        Log p(theta) that the agent held; None where it held none.
    theta : sequence of str, optional
        The labels that it held it over, some or all of the log's in any order; by default all in the log's order.
    seed : int
        Of the plans.

    Examples
    --------
    >>> plans = PlanSet("robot", [2, 1], [0.0, 2.0, 0.0], [[0.0], [1.0], [0.0]], static=1)
    >>> Replan(0.0, 0, "robot", [plans], plans.cost[None], np.full(2, np.inf), [0]).decision
    [0]
    """

    time: float
    sample: int
    agent: str
    plans: Sequence[PlanSet]
    cost: Float[np.ndarray, "..."]
    contact_time: Float[np.ndarray, "..."]
    decision: Sequence[int]
    live_log_posterior: Float[np.ndarray, " theta"] | None = None
    seed: int = 0
    theta: Sequence[str] | None = None

    @classmethod
    def of(cls, situation: Situation, agent: str, sample: int, decision: Decision) -> Replan:
        """Return the replan that a policy's decision in a situation makes.

        Parameters
        ----------
        situation : Situation
            What the agent saw.
        agent : str
            Who it is.
        sample : int
            The sample of the trial at which it was.
        decision : Decision
            What it decided; its belief over ``theta``, if any, is the live posterior.

        Raises
        ------
        LogError
            If the belief is over anything else, or the situation has no times of contact.

        Examples
        --------
        >>> from ppinfer import Axis, Distribution
        >>> plans = PlanSet("robot", [2, 1], [0.0, 2.0, 0.0], [[0.0], [1.0], [0.0]], static=1)
        >>> situation = Situation.from_contacts([plans], np.full(2, np.inf))
        >>> decision = Decision(0, Distribution.uniform(plans.axis))
        >>> Replan.of(situation, "robot", 0, decision).decision
        (0,)
        """
        player = situation.player(agent)
        profile = [-1] * len(situation.plans) if decision.profile is None else list(decision.profile)
        profile[player] = decision.plan
        belief, theta = None, None
        if decision.belief is not None:
            axes = tuple(axis.name for axis in decision.belief.axes)
            if axes != ("theta",):
                raise LogError(f"a live posterior is over theta alone; {agent!r} holds one over {axes}")
            theta = tuple(str(label) for label in decision.belief.axes[0].labels)
            belief = np.asarray(decision.belief.log_values, np.float64)
        if situation.contact_time is None:
            raise LogError("the situation has no contact_time; give it (inf where agents never touch)")
        return cls(
            time=situation.time,
            sample=sample,
            agent=agent,
            plans=situation.plans,
            cost=situation.game.costs,
            contact_time=situation.contact_time,
            decision=tuple(profile),
            live_log_posterior=belief,
            seed=situation.seed,
            theta=theta,
        )


@dataclass(frozen=True, eq=False)
class ReplanTable:
    """Replans laid end to end, in the arrays of the study log.

    The fields are the log's variables (see ``docs/log-format.md``): plans lie end to end in the order of replans and
    agents, waypoints in that of plans, and ``cost`` and ``contact_time`` run over the grid of each replan in C order.

    Examples
    --------
    >>> ReplanTable.of([], agents=("robot",), space=1, theta=()).sizes
    {'replan': 0, 'plan': 0, 'waypoint': 0, 'profile': 0}
    """

    replan_time: Float[np.ndarray, " replan"]
    replan_sample: Int[np.ndarray, " replan"]
    replan_agent: Shaped[np.ndarray, " replan"]
    replan_seed: Int[np.ndarray, " replan"]
    plan_row_size: Int[np.ndarray, "replan agent"]
    static_plan: Int[np.ndarray, "replan agent"]
    committed_plan: Int[np.ndarray, "replan agent"]
    waypoint_row_size: Int[np.ndarray, " plan"]
    waypoint_time: Float[np.ndarray, " waypoint"]
    waypoint_position: Float[np.ndarray, "waypoint space"]
    cost: Float[np.ndarray, "profile agent"]
    contact_time: Float[np.ndarray, " profile"]
    decision: Int[np.ndarray, "replan agent"]
    live_log_posterior: Float[np.ndarray, "replan theta"]

    @property
    def sizes(self) -> dict[str, int]:
        """How many replans, plans, waypoints and profiles there are."""
        return {
            "replan": len(self.replan_time),
            "plan": len(self.waypoint_row_size),
            "waypoint": len(self.waypoint_time),
            "profile": len(self.contact_time),
        }

    @classmethod
    def of(
        cls, replans: Sequence[Replan], *, agents: Sequence[str], space: int, theta: Sequence[str]
    ) -> ReplanTable:
        """Lay replans end to end.

        Parameters
        ----------
        replans : sequence of Replan
            In the order in which they were made.
        agents : sequence of str
            All agents of the log, in its order; one without plans has left.
        space : int
            How many coordinates a position has.
        theta : sequence of str
            The log's labels of theta; of those that an agent did not think of, it thought none possible.

        Raises
        ------
        LogError
            If plans, costs or beliefs of a replan do not fit each other.
        """
        at = {agent: index for index, agent in enumerate(agents)}
        n, shape = len(replans), (len(replans), len(agents))
        row_size = np.zeros(shape, np.int64)
        static, committed, decision = (np.full(shape, -1, np.int64) for _ in range(3))
        belief = np.full((n, len(theta)), np.nan)
        waypoints: list[tuple[Any, Any, Any]] = [(np.zeros(0, np.int64), np.zeros(0), np.zeros((0, space)))]
        grids: list[tuple[Any, Any]] = [(np.zeros((0, len(agents))), np.zeros(0))]
        for number, replan in enumerate(replans):
            where = f"replan {number} (at {replan.time:g} s, of {replan.agent!r})"
            unknown = sorted({plans.agent for plans in replan.plans} - set(at))
            if unknown or len({plans.agent for plans in replan.plans}) < len(replan.plans):
                raise LogError(
                    f"{where}: plans of {[plans.agent for plans in replan.plans]}; the log's agents are {list(agents)}"
                )
            if len(replan.decision) != len(replan.plans):
                raise LogError(
                    f"{where}: the decision has {len(replan.decision)} plans for {len(replan.plans)} agents"
                )
            # plans, and the axes of the grid, go in the order of the log's agents
            order = sorted(range(len(replan.plans)), key=lambda index: at[replan.plans[index].agent])
            for index in order:
                plans = replan.plans[index]
                column = at[plans.agent]
                if plans.position.shape[1] != space:
                    raise LogError(
                        f"{where}: plans of {plans.agent!r} have {plans.position.shape[1]} coordinates; the "
                        f"log has {space}"
                    )
                row_size[number, column] = len(plans)
                static[number, column] = -1 if plans.static is None else plans.static
                committed[number, column] = -1 if plans.committed is None else plans.committed
                decision[number, column] = replan.decision[index]
                waypoints.append((plans.row_size, plans.time, plans.position))
            grids.append(
                _grid(replan, order, [at[replan.plans[index].agent] for index in order], len(agents), where)
            )
            if replan.live_log_posterior is not None:
                belief[number] = _belief(replan, theta, where)
        sizes, times, places = (np.concatenate(parts) for parts in zip(*waypoints, strict=True))
        costs, contacts = (np.concatenate(parts) for parts in zip(*grids, strict=True))
        return cls(
            replan_time=np.array([replan.time for replan in replans], np.float64),
            replan_sample=np.array([replan.sample for replan in replans], np.int64),
            replan_agent=np.array([replan.agent for replan in replans], object),
            replan_seed=np.array([replan.seed for replan in replans], np.int64),
            plan_row_size=row_size,
            static_plan=static,
            committed_plan=committed,
            waypoint_row_size=sizes,
            waypoint_time=times,
            waypoint_position=places,
            cost=costs,
            contact_time=contacts,
            decision=decision,
            live_log_posterior=belief,
        )

    @classmethod
    def end_to_end(cls, tables: Sequence[ReplanTable]) -> ReplanTable:
        """Return the replans of several trials as one table, at least one."""
        try:
            return cls(
                **{
                    item.name: np.concatenate([getattr(table, item.name) for table in tables])
                    for item in fields(cls)
                }
            )
        except ValueError as error:
            raise LogError(f"replans of trials that do not belong together: {error}") from error


def _belief(replan: Replan, theta: Sequence[str], where: str) -> Float[np.ndarray, " theta"]:
    held = np.asarray(replan.live_log_posterior, np.float64)
    labels = list(theta) if replan.theta is None else list(replan.theta)
    if held.shape != (len(labels),):
        raise LogError(f"{where}: live_log_posterior has shape {held.shape}; theta has {len(labels)} labels")
    unknown = [label for label in labels if label not in theta]
    if unknown:
        raise LogError(
            f"{where}: the belief is over theta {labels}, the log's theta is {list(theta)}; give the log all labels"
        )
    out = np.full(len(theta), -np.inf)
    out[[list(theta).index(label) for label in labels]] = held
    return out


def _grid(
    replan: Replan, order: list[int], columns: list[int], agents: int, where: str
) -> tuple[Float[np.ndarray, "profile agent"], Float[np.ndarray, " profile"]]:
    shape = tuple(len(plans) for plans in replan.plans)
    cost, contact = np.asarray(replan.cost, np.float64), np.asarray(replan.contact_time, np.float64)
    for name, array, expected in (("cost", cost, (len(shape), *shape)), ("contact_time", contact, shape)):
        if array.shape != expected:
            raise LogError(f"{where}: {name} has shape {array.shape}; {expected} is expected of these plans")
    flat = np.full((contact.size, agents), np.nan)
    flat[:, columns] = cost[order].transpose(0, *(1 + axis for axis in order)).reshape(len(order), -1).T
    return flat, contact.transpose(order).ravel()
