"""What was seen of one agent, and the goals it may have had: the evidence of every goal model."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
from jaxtyping import Bool, Float, Int

from ppinfer.distributions import Axis, Factor, expand, row_starts
from ppinfer.errors import ImpossibleEvidenceError, LogError
from ppinfer.goals.partners import PartnerMotion

if TYPE_CHECKING:
    from ppinfer.goals.coupled.geometry import Geometry

# squares of positions must stay numbers
FARTHEST = 1e100
_TYPES: dict[str, type] = {
    "time": np.float64,
    "position": np.float64,
    "goals": np.float64,
    "row_size": np.int64,
    "observed": np.bool_,
    "present": np.bool_,
    "velocity": np.float64,
    "control": np.float64,
    "continues": np.bool_,
}


@dataclass(frozen=True, eq=False)
class GoalEvidence:
    """The motion of one agent over many rows, end to end; a row is a stretch over which the goals stay put.

    Parameters
    ----------
    time : (sample,) float64
        Seconds, increasing within a row.
    position : (sample, space) float64
        Position (m, or the log's unit); NaN exactly where `observed` is false.
    goals : (row, goal, space) float64
        Positions of the goals; anything where a goal is not `present`.
    row_size : (row,) int64
        Samples of each row, at least one.
    goal_labels : tuple of str
        Names of the goals.
    observed : (sample,) bool, optional
        False where the tracker lost the agent; default: always seen.
    present : (row, goal) bool, optional
        False where a goal does not exist in a row; default: all exist.
    velocity, control : (sample, space) float64, optional
        As logged: the control at a sample is the one applied from that sample on.
    control_order : {1, 2, None}
        What the control is: a velocity (1), an acceleration (2), or something else (None). A model uses a logged
        control only where it is the control of its own dynamics.
    continues : (row,) bool, optional
        True where a row goes on in the trial of the row before it.
    name_row : callable, optional
        From a row's number to how errors name it (its trial); default ``row 0``, ``row 1``, ...
    time_step : float, optional
        Nominal seconds between samples, where it is known; default: the median.
    partners : tuple of PartnerMotion
        What was seen of the other agents at the same samples; models of one agent by itself do not look at it.
    agent : str
        What the agent is called, beside its partners.

    Raises
    ------
    LogError
        Where sizes disagree, time does not increase, or values are not finite; the message names row and sample.

    Examples
    --------
    >>> evidence = GoalEvidence(
    ...     time=np.arange(3) * 0.1, position=np.array([[0.0, 0.0], [0.1, 0.0], [0.2, 0.0]]),
    ...     goals=np.array([[[1.0, 0.0], [0.0, 1.0]]]), row_size=np.array([3]), goal_labels=("cup", "bowl"),
    ... )
    >>> evidence.samples, evidence.rows, round(evidence.dt, 3)
    (3, 1, 0.1)
    """

    time: Float[np.ndarray, " sample"]
    position: Float[np.ndarray, "sample space"]
    goals: Float[np.ndarray, "row goal space"]
    row_size: Int[np.ndarray, " row"]
    goal_labels: tuple[str, ...]
    observed: Bool[np.ndarray, " _"] | None = None
    present: Bool[np.ndarray, "_ _"] | None = None
    velocity: Float[np.ndarray, "_ _"] | None = None
    control: Float[np.ndarray, "_ _"] | None = None
    control_order: int | None = 2
    continues: Bool[np.ndarray, " _"] | None = None
    name_row: Callable[[int], str] | None = None
    time_step: float | None = None
    partners: tuple[PartnerMotion, ...] = ()
    agent: str = "agent"

    def __post_init__(self) -> None:
        # kernels are compiled for contiguous arrays of these types, and for no others
        for name, dtype in _TYPES.items():
            value = getattr(self, name)
            if value is not None:
                object.__setattr__(self, name, np.ascontiguousarray(value, dtype=dtype))
        samples, rows = len(self.time), len(self.row_size)
        if self.position.ndim != 2 or len(self.position) != samples:
            raise LogError(
                f"position has shape {self.position.shape}; expected ({samples}, space), one row a sample"
            )
        expected: dict[str, tuple[int | None, ...]] = {
            "goals": (rows, len(self.goal_labels), self.position.shape[1]),
            "observed": (samples,),
            "present": (rows, len(self.goal_labels)),
            "velocity": (samples, self.position.shape[1]),
            "control": (samples, None),
            "continues": (rows,),
        }
        for name, shape in expected.items():
            value = getattr(self, name)
            if value is not None and (
                value.ndim != len(shape)
                or any(size not in (None, found) for size, found in zip(shape, value.shape, strict=True))
            ):
                wanted = ", ".join("controls" if size is None else str(size) for size in shape)
                raise LogError(f"{name} has shape {value.shape}; expected ({wanted})")
        if rows == 0 or self.row_size.min() < 1 or int(self.row_size.sum()) != samples:
            raise LogError(
                f"row_size must hold positive sizes that sum to the {samples} samples; got {rows} rows summing to "
                f"{int(self.row_size.sum())}"
            )
        for partner in self.partners:
            if partner.position.shape != self.position.shape:
                raise LogError(
                    f"partner {partner.name!r} has positions of shape {partner.position.shape}; expected "
                    f"{self.position.shape}, those of {self.agent!r}"
                )
        self._check_values()

    def _check_values(self) -> None:
        gaps = np.diff(self.time)
        bad = gaps <= 0
        bad[self.row_start[1:] - 1] = False
        if not np.isfinite(self.time).all() or bad.any():
            sample = (
                int(np.argmax(~np.isfinite(self.time)))
                if not np.isfinite(self.time).all()
                else int(np.argmax(bad)) + 1
            )
            raise LogError(f"{self.describe_sample(sample)}: time must be finite and increase within a trial")
        seen = np.isfinite(self.position).all(axis=1)
        wrong = ~seen if self.observed is None else self.observed & ~seen
        if wrong.any():
            raise LogError(
                f"{self.describe_sample(int(np.argmax(wrong)))}: position is not finite there; mark dropouts as "
                "not observed"
            )
        far = np.abs(self.position[seen]).max(initial=0.0)
        if far > FARTHEST:
            raise LogError(
                f"a position is {far:g} away from the origin; beyond {FARTHEST:g} nothing can be computed"
            )
        finite = (np.abs(self.goals) <= FARTHEST).all(axis=2)
        lost = ~finite if self.present is None else self.present & ~finite
        if lost.any():
            row, goal = (int(i) for i in np.argwhere(lost)[0])
            raise LogError(
                f"{self.row_name(row)}: goal {self.goal_labels[goal]!r} has no finite position; mark it as absent"
            )
        if self.present is not None and not self.present.any(axis=1).all():
            row = int(np.argmin(self.present.any(axis=1)))
            raise ImpossibleEvidenceError(
                f"{self.row_name(row)}: no goal is present, so there is nothing to infer"
            )

    @property
    def samples(self) -> int:
        """Number of samples over all rows."""
        return len(self.time)

    @property
    def rows(self) -> int:
        """Number of rows."""
        return len(self.row_size)

    @cached_property
    def row_start(self) -> Int[np.ndarray, " row"]:
        """Flat index of the first sample of each row."""
        return row_starts(self.row_size)

    @cached_property
    def row_of_sample(self) -> Int[np.ndarray, " sample"]:
        """Row of each sample."""
        return np.repeat(np.arange(self.rows), self.row_size)

    @cached_property
    def dt(self) -> float:
        """Nominal time between samples in s: `time_step`, or the median within rows (nan without two samples)."""
        if self.time_step is not None:
            return self.time_step
        inside = np.ones(max(self.samples - 1, 0), dtype=bool)
        inside[self.row_start[1:] - 1] = False
        gaps = np.diff(self.time)[inside]
        return float(np.median(gaps)) if len(gaps) else float("nan")

    @cached_property
    def seen(self) -> Bool[np.ndarray, " sample"]:
        """`observed`, spelled out."""
        return np.ones(self.samples, dtype=bool) if self.observed is None else self.observed

    @cached_property
    def goal_present(self) -> Bool[np.ndarray, "row goal"]:
        """`present`, spelled out."""
        return np.ones(self.goals.shape[:2], dtype=bool) if self.present is None else self.present

    @cached_property
    def geometry(self) -> Geometry:
        """How the agent and its partners stand to the goals at every sample, computed once."""
        from ppinfer.goals.coupled.geometry import Geometry

        return Geometry.of(self)

    @property
    def sample_axis(self) -> Axis:
        """The batch axis of every answer about this evidence."""
        return Axis("sample", self.samples)

    @property
    def goal_axis(self) -> Axis:
        """The hypotheses."""
        return Axis("goal", self.goal_labels)

    def row_name(self, row: int) -> str:
        """Return how errors name a row."""
        return f"row {row}" if self.name_row is None else self.name_row(row)

    def describe_sample(self, sample: int) -> str:
        """Return how errors name a flat sample index: its row and its place there."""
        row = int(np.searchsorted(self.row_start, sample, side="right")) - 1
        return f"{self.row_name(row)}, sample {sample - int(self.row_start[row])}"

    def take_rows(self, rows: Int[np.ndarray, " taken"]) -> GoalEvidence:
        """Return the evidence of some rows, in the order given; none of them continues another."""
        return self._take(rows, self.row_size[rows])

    def take_beginnings(self, row_size: Int[np.ndarray, " row"]) -> GoalEvidence:
        """Return the first samples of every row, as many as `row_size` says: what was known earlier on."""
        return self._take(np.arange(self.rows), np.asarray(row_size, dtype=np.int64))

    def of_partner(self, name: str | None = None) -> GoalEvidence:
        """Return the evidence about a partner: its motion, with the same rows and goals; this agent is its partner.

        Parameters
        ----------
        name : str, optional
            Which partner; default: the only one.

        Raises
        ------
        LogError
            Where there is no such partner, or none.

        Examples
        --------
        >>> evidence = GoalEvidence(
        ...     time=np.zeros(1), position=np.zeros((1, 2)), goals=np.ones((1, 1, 2)), row_size=np.array([1]),
        ...     goal_labels=("cup",), partners=(PartnerMotion("robot", np.ones((1, 2))),), agent="human",
        ... )
        >>> robot = evidence.of_partner("robot")
        >>> robot.position, robot.partners[0].name
        (array([[1., 1.]]), 'human')
        """
        names = [partner.name for partner in self.partners]
        if name not in names and (name is not None or len(names) != 1):
            raise LogError(
                f"there is no partner {name!r} beside {self.agent!r}; there are {names or 'none'}: say which"
            )
        chosen = self.partners[0 if name is None else names.index(name)]
        me = PartnerMotion(
            self.agent, self.position, self.observed, self.velocity, self.control, self.control_order
        )
        return replace(
            self,
            position=np.where(chosen.seen[:, None], chosen.position, np.nan),
            observed=chosen.observed,
            velocity=chosen.velocity,
            control=chosen.control,
            control_order=chosen.control_order,
            partners=(me, *(partner for partner in self.partners if partner is not chosen)),
            agent=chosen.name,
        )

    def _take(self, rows: Int[np.ndarray, " taken"], sizes: Int[np.ndarray, " taken"]) -> GoalEvidence:
        index = expand(self.row_start[rows], sizes)
        return replace(
            self,
            time=self.time[index],
            position=self.position[index],
            goals=self.goals[rows],
            row_size=sizes,
            observed=None if self.observed is None else self.observed[index],
            present=None if self.present is None else self.present[rows],
            velocity=None if self.velocity is None else self.velocity[index],
            control=None if self.control is None else self.control[index],
            continues=None,
            name_row=lambda row: self.row_name(int(rows[row])),
            partners=tuple(partner.take_samples(index) for partner in self.partners),
        )

    def likelihood_factor(self, log_values: Float[np.ndarray, "sample goal"]) -> Factor:
        """Return log likelihoods as a Factor over (sample, goal): 0 at dropouts, -inf where a goal is absent.

        Raises
        ------
        FactorError
            Where a value is NaN or +inf.
        """
        if not self.seen.all():
            log_values = np.where(self.seen[:, None], log_values, 0.0)
        if not self.goal_present.all():
            log_values = np.where(self.goal_present[self.row_of_sample], log_values, -np.inf)
        return Factor((self.sample_axis, self.goal_axis), log_values)
