"""What a model of goals is: a likelihood over goals and its generative twin."""

from __future__ import annotations

import dataclasses
from abc import ABC, abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, ClassVar, Protocol, cast, runtime_checkable

import numpy as np
from jaxtyping import Bool, Float, Int

from ppinfer.distributions import Factor, expand
from ppinfer.errors import ModelError
from ppinfer.goals.evidence import GoalEvidence


@dataclass(frozen=True, eq=False)
class GoalDesign:
    """What to simulate: where each row starts, its goals, and the goal that is pursued.

    Parameters
    ----------
    start : (row, space) float64
        Position of the agent at the first sample of each row.
    goals : (row, goal, space) float64
        Positions of the goals.
    true_goal : (row,) int64
        Index of the goal pursued.
    row_size : (row,) int64
        Samples of each row.
    dt : float
        Seconds between samples.

    Examples
    --------
    >>> design = GoalDesign.random(np.random.default_rng(0), rows=4, goals=3, samples=20, dt=0.1)
    >>> design.goals.shape
    (4, 3, 2)
    """

    start: Float[np.ndarray, "row space"]
    goals: Float[np.ndarray, "row goal space"]
    true_goal: Int[np.ndarray, " row"]
    row_size: Int[np.ndarray, " row"]
    dt: float = 0.1

    @classmethod
    def random(
        cls,
        rng: np.random.Generator,
        *,
        rows: int,
        goals: int = 3,
        samples: int = 40,
        dt: float = 0.1,
        extent: float = 10.0,
        space: int = 2,
    ) -> GoalDesign:
        """Draw starts and goals uniformly from a box of half-width `extent`, and the goal pursued uniformly."""
        return cls(
            start=rng.uniform(-extent, extent, (rows, space)),
            goals=rng.uniform(-extent, extent, (rows, goals, space)),
            true_goal=rng.integers(goals, size=rows),
            row_size=np.full(rows, samples, dtype=np.int64),
            dt=dt,
        )

    @property
    def time(self) -> Float[np.ndarray, " sample"]:
        """Seconds since the start of the row, for every sample."""
        seconds: np.ndarray = expand(np.zeros_like(self.row_size), self.row_size) * self.dt
        return seconds

    @property
    def pursued(self) -> Float[np.ndarray, "row space"]:
        """Position of the goal pursued in each row."""
        pursued: np.ndarray = self.goals[np.arange(len(self.goals)), self.true_goal]
        return pursued

    @property
    def labels(self) -> tuple[str, ...]:
        """Labels of the goals: their numbers."""
        return tuple(str(goal) for goal in range(self.goals.shape[1]))


@dataclass(frozen=True, eq=False)
class Observation:
    """One instant of one agent, as a robot would see it at control rate.

    Parameters
    ----------
    time : float
        Seconds.
    position : (space,) float64 or None
        None where the tracker lost the agent.
    velocity, control : (space,) float64, optional
        Where they are known; all or none of a row's observations carry them.
    partners : tuple of Observation
        The other agents at this instant, always in the same order; ``position=None`` where one was not seen.
    """

    time: float
    position: Float[np.ndarray, " space"] | None
    velocity: Float[np.ndarray, " space"] | None = None
    control: Float[np.ndarray, " control"] | None = None
    control_order: int | None = 2
    partners: tuple[Observation, ...] = ()


@runtime_checkable
class OnlineLikelihood(Protocol):
    """The likelihood of one observation after another, within one row."""

    def restart(self, goals: Float[np.ndarray, "goal space"], present: Bool[np.ndarray, " goal"]) -> None:
        """Begin a row with these goals."""

    def step(self, observation: Observation) -> Float[np.ndarray, " goal"]:
        """Return the log likelihood of this observation under every goal; -inf where a goal is absent."""


@runtime_checkable
class OnlineInstant(OnlineLikelihood, Protocol):
    """A likelihood of a model that also weighs each instant by itself; see `Assessment`."""

    def instant(self) -> Float[np.ndarray, " goal"]:
        """Return the log weights of the goals as things are since the last step; 0 where nothing is known."""


@dataclass(frozen=True, eq=False)
class Assessment:
    """What a model makes of the evidence: its likelihood, and what a reader should know of how it came about.

    Parameters
    ----------
    log_likelihood : Factor
        Over (sample, goal): what the belief gathers as time passes.
    state_source : str
        How velocities and controls were obtained.
    outliers : (sample,) bool, optional
        Samples set aside.
    instant : Factor, optional
        Over (sample, goal): how things are at each sample (how far a goal is, where others are heading). The posterior
        at a sample is the belief gathered so far times this factor, which the belief at later samples knows nothing of:
        standing near a goal for ten samples says no more than standing there for one.
    """

    log_likelihood: Factor
    state_source: str
    outliers: Bool[np.ndarray, " sample"] | None = field(default=None)
    instant: Factor | None = None


class GoalModel(ABC):
    """A likelihood over goals with its generative twin; subclasses are small frozen dataclasses of parameters.

    A subclass defines `log_likelihood` and `simulate`. It may define a field ``stay`` (the probability per sample that
    the goal stays what it is; 1 by default), set ``memoryless`` (each sample is judged by itself) or ``redraws`` (a
    goal that does not stay is drawn anew from the prior, itself included), say how many samples it needs to look at
    (``window``) and whether it needs other agents (``needs_partner``), name the parameters that `fit_goals` may fit
    (``fitted``, with their scale: ``log`` for positive numbers, ``logit`` for shares, ``linear`` for others) and how
    they are searched for (``search``: ``simplex``, or ``gradient`` for many parameters in a smooth objective) and from
    where (``starts``; the others from what they are), and replace `online` by something faster.
    `ppinfer.testing.check_likelihood` holds a subclass to the laws.

    Examples
    --------
    A model of one's own: whoever is nearer to a goal is heading there.

    >>> from dataclasses import dataclass
    >>> from ppinfer.goals import GoalModel
    >>> @dataclass(frozen=True)
    ... class Inverse(GoalModel):
    ...     memoryless = True
    ...     def log_likelihood(self, evidence):
    ...         goals = evidence.goals[evidence.row_of_sample]
    ...         distance = np.linalg.norm(evidence.position[:, None] - goals, axis=-1)
    ...         return evidence.likelihood_factor(-np.log(1.0 + distance))
    ...     def simulate(self, design, rng):
    ...         raise NotImplementedError
    """

    name: ClassVar[str] = "custom"
    memoryless: ClassVar[bool] = False
    redraws: ClassVar[bool] = False
    window: ClassVar[int] = 3
    gates_outliers: ClassVar[bool] = False
    fitted: ClassVar[dict[str, str]] = {}
    search: ClassVar[str] = "simplex"
    starts: ClassVar[dict[str, float]] = {"stay": 0.95, "evidence_floor": 0.02}
    stay: float = 1.0

    @property
    def needs_partner(self) -> bool:
        """Whether the model looks at other agents, so that evidence about one agent alone is refused."""
        return False

    @property
    def parameter_scales(self) -> dict[str, str]:
        """Names and scales of the parameters that `fit_goals` may fit: ``fitted``, unless they depend on the model."""
        return dict(self.fitted)

    @classmethod
    def parameter_types(cls, given: Mapping[str, Any]) -> dict[str, type]:
        """Return the parameters that can be written down as text or numbers, by name.

        Parameters
        ----------
        given : mapping
            The parameters at hand, where which there are depends on one of them.
        """
        plain: dict[Any, type] = {"str": str, "int": int, "float": float}
        fields: Mapping[str, Any] = getattr(cls, "__dataclass_fields__", {})
        return {name: plain[entry.type] for name, entry in fields.items() if entry.type in plain}

    @classmethod
    def from_parameters(cls, parameters: Mapping[str, Any]) -> GoalModel:
        """Return the model with these parameters, by the names of `parameter_types`; defaults for the others."""
        return cls(**parameters)

    @property
    def parameters(self) -> dict[str, str | int | float]:
        """The parameters that can be written down, with their values."""
        return {name: getattr(self, name) for name in type(self).parameter_types({})}

    def with_parameters(self, **changed: Any) -> GoalModel:
        """Return the model with some parameters changed.

        Examples
        --------
        >>> from ppinfer.goals import NearestGoal
        >>> NearestGoal().with_parameters(scale=2.0)
        NearestGoal(scale=2.0)
        """
        return cast(GoalModel, dataclasses.replace(cast(Any, self), **changed))

    @abstractmethod
    def log_likelihood(self, evidence: GoalEvidence) -> Factor:
        """Return the log likelihood of every sample under every goal, a Factor over (sample, goal).

        Samples that tell nothing (dropouts, the first of a row) hold zeros; absent goals hold -inf.
        """

    @abstractmethod
    def simulate(self, design: GoalDesign, rng: np.random.Generator) -> GoalEvidence:
        """Return evidence drawn from the model for the goals pursued in `design`."""

    def assess(self, evidence: GoalEvidence) -> Assessment:
        """Return the likelihood together with how the states behind it were obtained."""
        return Assessment(self.log_likelihood(evidence), "positions")

    def online(self, dt: float) -> OnlineLikelihood:
        """Return the same likelihood for one observation at a time; `dt` is the nominal time step in s."""
        from ppinfer.goals.online import WindowedLikelihood

        return WindowedLikelihood(self, dt)


# products of a few parameters and squared positions must stay numbers
LARGEST = 1e30


def require_range(
    name: str, value: float, low: float, high: float, *, open_low: bool = False, open_high: bool = False
) -> None:
    """Raise ModelError unless `value` lies in [low, high], or in an interval open at an end.

    Examples
    --------
    >>> require_range("stay", 0.98, 0.0, 1.0)
    """
    if not (low < value if open_low else low <= value) or not (value < high if open_high else value <= high):
        brackets = "(" if open_low else "[", ")" if open_high else "]"
        raise ModelError(f"{name} must lie in {brackets[0]}{low:g}, {high:g}{brackets[1]}; got {value!r}")
