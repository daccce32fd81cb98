"""The belief a robot holds at control rate: one observation in, one distribution over goals out."""

from __future__ import annotations

import math
from collections import deque
from typing import TYPE_CHECKING, Any

import numpy as np
from jaxtyping import Bool, Float

from ppinfer.distributions import Axis, Distribution
from ppinfer.errors import ImpossibleEvidenceError, LogError, ModelError
from ppinfer.goals.belief import lacks_partner
from ppinfer.goals.evidence import GoalEvidence
from ppinfer.goals.model import Observation, OnlineInstant
from ppinfer.goals.partners import PartnerMotion
from ppinfer.goals.priors import log_priors
from ppinfer.goals.switching import row_transitions

if TYPE_CHECKING:
    from collections.abc import Sequence

    from ppinfer.goals.model import GoalModel


class OnlineGoalBelief:
    """A belief over one agent's goals, updated as it moves; equal at every step to the offline filter.

    Parameters
    ----------
    model : GoalModel
        The likelihood; its ``stay`` says how goals change.
    dt : float
        Nominal seconds between observations.
    labels : sequence of str
        Names of the goals.

    Examples
    --------
    >>> from ppinfer.goals import GoalLQR
    >>> belief = OnlineGoalBelief(GoalLQR(rationality=1.0), dt=0.1, labels=["cup", "bowl"])
    >>> _ = belief.restart(np.array([[1.0, 0.0], [0.0, 1.0]]))
    >>> for step in range(4):
    ...     distribution = belief.observe(0.1 * step, np.array([0.1 * step, 0.0]))
    >>> distribution.mode()["goal"]
    'cup'
    """

    def __init__(self, model: GoalModel, *, dt: float, labels: Sequence[str]) -> None:
        self._model = model
        self._likelihood = model.online(dt)
        self._weighs_instants = isinstance(self._likelihood, OnlineInstant)
        self._axes = (Axis("goal", labels),)
        self._log_belief: Float[np.ndarray, " goal"] | None = None
        self._transition: Float[np.ndarray, "goal goal"] | None = None
        self._present: Bool[np.ndarray, " goal"] | None = None
        self._space = 0
        self._fresh = True
        self._last_time = -np.inf

    def restart(
        self,
        goals: Float[np.ndarray, "goal space"],
        *,
        present: Bool[np.ndarray, " goal"] | None = None,
        prior: Any = None,
        carry: bool = False,
    ) -> Distribution:
        """Begin a row: new goals, and the belief from its prior or carried over goal by goal.

        Parameters
        ----------
        goals : (goal, space) float64
            Positions of the goals, one for each label.
        present : (goal,) bool, optional
            Goals that exist; default all.
        prior : (goal,) array of float, optional
            Probabilities to start from; default even over the goals present.
        carry : bool
            Start from the last belief, moved on by one step of the goals' transition, instead of from a prior.

        Raises
        ------
        LogError
            Where the goals do not match the labels or are not finite.
        """
        count = len(self._axes[0])
        goals = np.asarray(goals, dtype=np.float64)
        there = np.ones(count, dtype=bool) if present is None else np.asarray(present, dtype=bool)
        if goals.ndim != 2 or len(goals) != count or there.shape != (count,):
            raise LogError(
                f"goals of shape {goals.shape} do not match the {count} labels {list(self._axes[0].labels)}"
            )
        if not np.isfinite(goals[there]).all() or not there.any():
            raise LogError(
                "at least one goal must be present, and every goal that is must have a finite position"
            )
        log_prior = log_priors(there[None], prior, name_row=lambda _: "the new row")[0]
        model = self._model
        if carry and self._log_belief is not None and self._present is not None:
            entry = row_transitions(
                log_prior[None],
                there[None],
                model.stay,
                memoryless=model.memoryless,
                redraws=model.redraws,
                appeared=(there & ~self._present)[None],
            )
            self._log_belief = _moved(self._log_belief, np.exp(entry[0][0]))
        else:
            self._log_belief = log_prior
        self._transition = None
        if model.memoryless or model.stay != 1.0:
            within = row_transitions(
                log_prior[None], there[None], model.stay, memoryless=model.memoryless, redraws=model.redraws
            )
            self._transition = np.exp(within[0][0])
        self._present = there
        self._space = goals.shape[1]
        self._fresh = True
        self._last_time = -np.inf
        self._likelihood.restart(goals, there)
        return Distribution._sound(self._axes, self._log_belief, ("random",))

    def observe(
        self,
        time: float,
        position: Float[np.ndarray, " space"] | None,
        *,
        velocity: Float[np.ndarray, " space"] | None = None,
        control: Float[np.ndarray, " control"] | None = None,
        control_order: int | None = 2,
        partners: Sequence[Observation] = (),
    ) -> Distribution:
        """Return the belief after one more observation; ``position=None`` is a dropout.

        Parameters
        ----------
        time : float
            Seconds, later than the last observation of the row.
        position, velocity, control : (space,) float64, optional
            What was seen; `control_order` is 1 where the control is a velocity, 2 where it is an acceleration.
        partners : sequence of Observation
            The other agents at this instant, in the same order throughout a row; not needed by models of one agent.

        Raises
        ------
        LogError
            Where no row was begun, time does not increase, or a value is not finite.
        ModelError
            Where the model looks at other agents and none is given.
        ImpossibleEvidenceError
            Where every goal is ruled out.
        """
        if self._log_belief is None:
            raise LogError("no goals yet: call restart(goals) before the first observation")
        if not self._last_time < time < math.inf:
            raise LogError(
                f"time must be finite and increase within a row; got {time!r} after {self._last_time!r}"
            )
        if position is not None and np.shape(position) != (self._space,):
            raise LogError(
                f"position at time {time!r} has shape {np.shape(position)}; the goals lie in {self._space} dimensions"
            )
        for name, value in (("position", position), ("velocity", velocity), ("control", control)):
            # of a few numbers, Python is the faster judge
            if value is not None and not all(map(math.isfinite, np.asarray(value).tolist())):
                raise LogError(f"{name} at time {time!r} is not finite; pass position=None for a dropout")
        if self._model.needs_partner and not partners:
            raise ModelError(lacks_partner(self._model, "the agent observed"))
        for partner in partners:
            _check_partner(partner, self._space)
        self._last_time = time
        log_likelihood = self._likelihood.step(
            Observation(time, position, velocity, control, control_order, tuple(partners))
        )
        log_belief = self._log_belief
        if self._transition is not None and not self._fresh:
            log_belief = _moved(log_belief, self._transition)
        log_belief = log_belief + log_likelihood
        log_total = np.logaddexp.reduce(log_belief)
        if log_total == -np.inf:
            raise ImpossibleEvidenceError(f"every goal is ruled out at time {time!r}")
        self._log_belief = log_belief - log_total
        self._fresh = False
        if self._weighs_instants:
            # what holds at this instant multiplies the belief that is told, and not the one that is kept
            weighed = self._log_belief + self._likelihood.instant()  # type: ignore[attr-defined]
            log_total = np.logaddexp.reduce(weighed)
            if log_total == -np.inf:
                raise ImpossibleEvidenceError(f"every goal is ruled out at time {time!r}")
            return Distribution._sound(self._axes, weighed - log_total, ("random",))
        return Distribution._sound(self._axes, self._log_belief, ("random",))


def _check_partner(partner: Observation, space: int) -> None:
    if partner.position is None:
        return
    if np.shape(partner.position) != (space,):
        raise LogError(
            f"a partner's position at time {partner.time!r} has shape {np.shape(partner.position)}; the goals lie in "
            f"{space} dimensions"
        )
    for value in (partner.position, partner.velocity, partner.control):
        if value is not None and not all(map(math.isfinite, np.asarray(value).tolist())):
            raise LogError(
                f"what was seen of a partner at time {partner.time!r} is not finite; pass position=None for a dropout"
            )


def _moved(
    log_belief: Float[np.ndarray, " goal"], transition: Float[np.ndarray, "goal goal"]
) -> Float[np.ndarray, " goal"]:
    """Return the belief one step later."""
    largest = log_belief.max()
    with np.errstate(divide="ignore"):
        moved: np.ndarray = np.log(np.exp(log_belief - largest) @ transition) + largest
    return moved


class WindowedLikelihood:
    """Any model's likelihood one observation at a time, by handing it the last few observations of the row."""

    def __init__(self, model: GoalModel, dt: float) -> None:
        self._model = model
        self._dt = dt
        self._recent: deque[Observation] = deque(maxlen=max(1, model.window))
        self._goals = np.zeros((0, 2))
        self._present = np.zeros(0, dtype=bool)

    def restart(self, goals: Float[np.ndarray, "goal space"], present: Bool[np.ndarray, " goal"]) -> None:
        """Begin a row with these goals."""
        self._recent.clear()
        self._goals, self._present = goals, present

    def step(self, observation: Observation) -> Float[np.ndarray, " goal"]:
        """Return the log likelihood of this observation under every goal."""
        if observation.position is None:
            return np.where(self._present, 0.0, -np.inf)
        self._recent.append(observation)
        window = list(self._recent)
        evidence = GoalEvidence(
            time=np.array([seen.time for seen in window]),
            position=np.array([seen.position for seen in window], dtype=np.float64),
            goals=self._goals[None],
            row_size=np.array([len(window)]),
            goal_labels=tuple(str(goal) for goal in range(len(self._goals))),
            present=self._present[None],
            velocity=_stacked([seen.velocity for seen in window]),
            control=_stacked([seen.control for seen in window]),
            control_order=observation.control_order,
            time_step=self._dt,
            partners=_partners(window),
        )
        latest: np.ndarray = self._model.log_likelihood(evidence).log_values[-1]
        return latest


def _partners(window: list[Observation]) -> tuple[PartnerMotion, ...]:
    """Return the partners' motion in the window; they may come and go with the agent's own dropouts only."""
    motions = []
    for index in range(len(window[-1].partners)):
        seen = [observation.partners[index] for observation in window]
        observed = np.array([partner.position is not None for partner in seen])
        unknown = np.full_like(window[-1].position, np.nan, dtype=np.float64)
        motions.append(
            PartnerMotion(
                f"partner {index}",
                np.array([unknown if partner.position is None else partner.position for partner in seen]),
                observed,
                _stacked([partner.velocity for partner in seen]),
                _stacked([partner.control for partner in seen]),
                seen[-1].control_order,
            )
        )
    return tuple(motions)


def _stacked(values: list[Float[np.ndarray, " m"] | None]) -> Float[np.ndarray, "window m"] | None:
    known = [value for value in values if value is not None]
    return np.array(known, dtype=np.float64) if len(known) == len(values) else None
