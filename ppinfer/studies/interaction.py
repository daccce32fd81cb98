"""One interaction out of a log: two agents among goals that stay where they are, and what was believed meanwhile."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import xarray as xr
from jaxtyping import Bool, Float, Int

from ppinfer.distributions.ragged import row_starts
from ppinfer.errors import LogError
from ppinfer.studies.goal_evidence import agent_index, goal_evidence

#: Names of what a study believed live of the human's goal: without the robot, and given what the robot does.
LIVE_BELIEFS = (("live_log_belief", "live_log_post"), ("logged_belief_nominal", "logged_belief_robot"))


@dataclass(frozen=True)
class Stretch:
    """Samples [start, stop) of a trial, counted over the whole log, through which the goals stay where they are."""

    trial: int
    start: int
    stop: int


@dataclass(frozen=True)
class Heading:
    """Samples [start, stop) of an interaction in which the human went for a goal; -1 where it is not known which."""

    start: int
    stop: int
    goal: int


@dataclass(frozen=True, eq=False)
class Interaction:
    """Two agents among goals, for some samples of a trial.

    Attributes
    ----------
    trial_id, agent, partner
        Which trial; who is predicted, and who they react to.
    goals
        Labels.
    units
        Of positions.
    time : (sample,) float64
        Seconds since the trial began.
    position, velocity : (sample, 2, space) float64
        Of the agent and of the partner; NaN where not seen. Velocities are those logged, or else differences.
    places : (sample, goal, space) float64
        Of the goals; NaN where absent.
    partner_goal : (sample,) int64
        The goal that the partner went for; -1 where it waited or the log does not say.
    belief, mental_model, overall, given : (sample, goal) float64
        Probabilities, as `infer_log_conditional` tells them.
    post : (sample, robot_goal, goal) float64
        The same, for each goal of the partner.
    live : dict of (sample, goal) float64
        What the log says was believed live, by the variable's name.
    headings
        The agent's segments that reach into the interaction.
    collision : (sample,) bool
        Where the agents collided, as far as the log says.
    """

    trial_id: str
    agent: str
    partner: str
    goals: tuple[str, ...]
    units: str
    time: Float[np.ndarray, " sample"]
    position: Float[np.ndarray, "sample 2 space"]
    velocity: Float[np.ndarray, "sample 2 space"]
    places: Float[np.ndarray, "sample goal space"]
    partner_goal: Int[np.ndarray, " sample"]
    belief: Float[np.ndarray, "sample goal"]
    mental_model: Float[np.ndarray, "sample goal"]
    overall: Float[np.ndarray, "sample goal"]
    given: Float[np.ndarray, "sample goal"]
    post: Float[np.ndarray, "sample goal goal"]
    live: dict[str, np.ndarray]
    headings: tuple[Heading, ...]
    collision: Bool[np.ndarray, " sample"]

    @property
    def apart(self) -> Float[np.ndarray, " sample"]:
        """Distance between the two; NaN where either is not seen."""
        distance: np.ndarray = np.linalg.norm(self.position[:, 0] - self.position[:, 1], axis=-1)
        return distance

    @property
    def closest(self) -> int:
        """The sample at which they were nearest to each other.

        Raises
        ------
        LogError
            Where they were never seen at the same time.
        """
        if np.isnan(self.apart).all():
            raise LogError(
                f"trial {self.trial_id!r}: {self.agent} and {self.partner} are never seen at the same time"
            )
        return int(np.nanargmin(self.apart))


def stretches(log: xr.Dataset, agent: str) -> list[Stretch]:
    """Return the stretches of all trials through which the goals stay where they are, in the order of the log.

    Examples
    --------
    >>> from ppinfer.testing import example_interaction_log
    >>> stretches(example_interaction_log(), "human")
    [Stretch(trial=0, start=0, stop=30), Stretch(trial=1, start=30, stop=60)]
    """
    size = goal_evidence(log, agent).row_size
    start = row_starts(size)
    trial = np.searchsorted(row_starts(log["row_size"].values), start, side="right") - 1
    return [
        Stretch(*each) for each in zip(trial.tolist(), start.tolist(), (start + size).tolist(), strict=True)
    ]


def read_interaction(log: xr.Dataset, beliefs: xr.Dataset, stretch: Stretch) -> Interaction:
    """Read one interaction of a log in memory, and the beliefs about it.

    Parameters
    ----------
    log : xarray.Dataset
        A study log.
    beliefs : xarray.Dataset
        What `infer_log_conditional` made of it.
    stretch : Stretch
        Which samples.

    Raises
    ------
    LogError
        Where the stretch is not one of the log.

    Examples
    --------
    >>> from ppinfer.studies import infer_log_conditional
    >>> from ppinfer.testing import example_interaction_log
    >>> log = example_interaction_log()
    >>> one = read_interaction(log, infer_log_conditional(log), Stretch(1, 30, 60))
    >>> one.trial_id, one.headings[1], round(float(one.apart[one.closest]), 2)
    ('scene-1', Heading(start=9, stop=30, goal=0), 3.26)
    """
    if (
        not 0 <= stretch.trial < log.sizes["trial"]
        or not 0 <= stretch.start < stretch.stop <= log.sizes["sample"]
    ):
        raise LogError(f"the log has no {stretch}")
    agent, partner = str(beliefs.attrs["agent"]), str(beliefs.attrs["partner"])
    pair = [agent_index(log, agent), agent_index(log, partner)]
    here = slice(stretch.start, stretch.stop)
    moving = log["goal_position"].dims[0] == "sample"
    where = here if moving else slice(stretch.trial, stretch.trial + 1)
    places = log["goal_position"].values[where].astype(np.float64)
    if "goal_present" in log:
        places = np.where((log["goal_present"].values[where] == 1)[..., None], places, np.nan)
    time, position = log["time"].values[here], log["position"].values[here][:, pair]
    return Interaction(
        trial_id=str(log["trial_id"].values[stretch.trial]),
        agent=agent,
        partner=partner,
        goals=tuple(str(goal) for goal in log["goal"].values),
        units=str(log["position"].attrs.get("units", "m")),
        time=time,
        position=position,
        velocity=_velocities(log, pair, here, time, position),
        places=np.broadcast_to(places, (len(time), *places.shape[1:])),
        partner_goal=beliefs["robot_goal_index"].values[here],
        belief=np.exp(beliefs["log_belief"].values[here]),
        mental_model=np.exp(beliefs["log_mental_model"].values[here]),
        overall=np.exp(beliefs["log_overall"].values[here]),
        given=np.exp(beliefs["log_given"].values[here]),
        post=np.exp(beliefs["log_post"].values[here]),
        live={name: live_probabilities(log, name)[here] for name in live_names(log)},
        headings=_headings(log, agent, stretch),
        collision=log["collision"].values[here] != 0
        if "collision" in log and log["collision"].dims == ("sample",)
        else np.zeros(len(time), dtype=bool),
    )


def live_names(log: xr.Dataset) -> tuple[str, ...]:
    """Return the variables that hold what was believed live: without the robot, then given what it does.

    Examples
    --------
    >>> from ppinfer.testing import example_interaction_log
    >>> live_names(example_interaction_log())
    ()
    """
    for names in LIVE_BELIEFS:
        if all(name in log and log[name].dims == ("sample", "goal") for name in names):
            return names
    return ()


def live_probabilities(log: xr.Dataset, name: str) -> Float[np.ndarray, "sample goal"]:
    """Return a belief that was held live as probabilities that sum to one; NaN where none was held.

    Examples
    --------
    >>> from ppinfer.testing import example_interaction_log
    >>> log = example_interaction_log(trials=1, samples=2)
    >>> log["live_log_post"] = (("sample", "goal"), np.log([[1.0, 1.0, 2.0], [1.0, 1.0, 2.0]]))
    >>> live_probabilities(log, "live_log_post").tolist()
    [[0.25, 0.25, 0.5], [0.25, 0.25, 0.5]]
    """
    values = log[name].values.astype(np.float64)
    weights: np.ndarray = np.exp(values) if name.startswith("live_log_") else values
    total = weights.sum(axis=1, keepdims=True)
    shares: np.ndarray = np.divide(weights, total, out=np.full_like(weights, np.nan), where=total > 0)
    return shares


def _velocities(
    log: xr.Dataset,
    pair: list[int],
    here: slice,
    time: Float[np.ndarray, " sample"],
    position: Float[np.ndarray, "sample 2 space"],
) -> Float[np.ndarray, "sample 2 space"]:
    """Return logged velocities, and for an agent without them those from one sample to the next (zero at first)."""
    steps = np.zeros_like(position)
    if len(time) > 1:
        steps[1:] = np.diff(position, axis=0) / np.diff(time)[:, None, None]
    if "velocity" not in log:
        return steps
    logged = log["velocity"].values[here][:, pair]
    return np.where(np.isnan(logged), steps, logged)


def _headings(log: xr.Dataset, agent: str, stretch: Stretch) -> tuple[Heading, ...]:
    if "segment_trial" not in log:
        return ()
    labels = log["goal"].values.astype(str).tolist()
    first = int(row_starts(log["row_size"].values)[stretch.trial])
    mine = (log["segment_trial"].values == stretch.trial) & (log["segment_agent"].values.astype(str) == agent)
    found = []
    for at in np.flatnonzero(mine).tolist():
        start = max(first + int(log["segment_start"].values[at]), stretch.start) - stretch.start
        stop = min(first + int(log["segment_stop"].values[at]), stretch.stop) - stretch.start
        goal = str(log["true_goal"].values[at])
        if start < stop:
            found.append(Heading(start, stop, labels.index(goal) if goal in labels else -1))
    return tuple(found)
