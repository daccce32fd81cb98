"""Some whole trials in memory, as metrics see them: who is who, how long things took, who was idle."""

from __future__ import annotations

from functools import cached_property

import numpy as np
import xarray as xr
from jaxtyping import Bool, Float, Int, Shaped

from ppinfer.distributions.ragged import row_starts
from ppinfer.errors import LogError
from ppinfer.studies.metrics.idleness import IdleRule, flag_of
from ppinfer.studies.metrics.roles import ROLES, Role, Roles


class TrialContext:
    """Some whole trials of a log in memory, laid end to end, and what several metrics are made of.

    An *interval* is what lies between a sample and the one before it in its trial; the first sample of a trial ends
    none. Arrays over intervals have one entry a sample, and 0 or False at first samples, so that `total` adds them up.

    Parameters
    ----------
    log : xarray.Dataset
        The trials, with the variables that the metrics need.
    roles : Roles
        Who is the robot and who the human.
    idle : IdleRule
        What counts as idle.

    Examples
    --------
    >>> from ppinfer.studies.metrics.idleness import IdleRule
    >>> from ppinfer.testing import example_log
    >>> log = example_log(participants=1, trials=2)
    >>> trials = TrialContext(log, Roles.of(log), IdleRule())
    >>> trials.duration.round(6).tolist(), trials.total(trials.interval).round(6).tolist()
    ([1.9, 1.9], [1.9, 1.9])
    """

    def __init__(self, log: xr.Dataset, roles: Roles, idle: IdleRule) -> None:
        self.log, self.roles, self.idle = log, roles, idle

    def has(self, name: str) -> bool:
        """Return whether the log has a variable; ``{robot}`` and ``{human}`` stand for labels."""
        return self.roles.filled(name) in self.log.variables

    def values(self, name: str) -> Shaped[np.ndarray, "..."]:
        """Return a variable's values; ``{robot}`` and ``{human}`` stand for labels."""
        found: np.ndarray = self.log[self.roles.filled(name)].values
        return found

    def agent(self, role: Role) -> int:
        """Return the place of the agent in a role.

        Raises
        ------
        LogError
            If the log has no such agent.
        """
        index = self.roles.index(role)
        if index is None:
            raise LogError(self.roles.absent(role))
        return index

    @cached_property
    def row_size(self) -> Int[np.ndarray, " trial"]:
        """Samples of each trial."""
        return np.asarray(self.log["row_size"].values, np.int64)

    @cached_property
    def start(self) -> Int[np.ndarray, " trial"]:
        """Where the samples of each trial begin."""
        return row_starts(self.row_size)

    @cached_property
    def trial(self) -> Int[np.ndarray, " sample"]:
        """The trial of each sample."""
        return np.repeat(np.arange(self.row_size.size), self.row_size)

    @cached_property
    def is_first(self) -> Bool[np.ndarray, " sample"]:
        """Whether a sample is the first of its trial."""
        first = np.zeros(int(self.row_size.sum()), bool)
        first[self.start] = True
        return first

    @cached_property
    def began(self) -> Float[np.ndarray, " trial"]:
        """When each trial's first sample is, on the log's clock; mostly 0."""
        return np.asarray(self.log["time"].values[self.start])

    @cached_property
    def elapsed(self) -> Float[np.ndarray, " sample"]:
        """Seconds since the trial's first sample."""
        return np.asarray(self.log["time"].values - np.repeat(self.began, self.row_size))

    @cached_property
    def duration(self) -> Float[np.ndarray, " trial"]:
        """Seconds from each trial's first sample to its last."""
        return np.asarray(self.elapsed[self.start + self.row_size - 1])

    @cached_property
    def interval(self) -> Float[np.ndarray, " sample"]:
        """Seconds since the sample before; 0 at first samples."""
        seconds: np.ndarray = np.diff(self.log["time"].values, prepend=0.0)
        seconds[self.is_first] = 0.0
        return seconds

    @cached_property
    def both_busy(self) -> Bool[np.ndarray, " sample"]:
        """Whether an interval lies in the time in which everybody has a task: until the first of them has finished."""
        busy = ~self.is_first
        if self.has("finish_time"):
            who = [index for role in ROLES if (index := self.roles.index(role)) is not None]
            # nobody finished: NaN, and no time is later than that
            finish = np.fmin.reduce(self.values("finish_time")[:, who], axis=1)
            finish = np.repeat(finish - self.began, self.row_size)
            # a finish is the time of a sample, written apart from it
            busy &= ~(self.elapsed > finish + 1e-9)
        return busy

    @cached_property
    def busy_time(self) -> Float[np.ndarray, " trial"]:
        """Seconds of each trial in which everybody has a task."""
        return self.total(np.where(self.both_busy, self.interval, 0.0))

    def total(self, values: Shaped[np.ndarray, " sample"]) -> Shaped[np.ndarray, " trial"]:
        """Add up what each sample, or interval, contributes to its trial."""
        counted = values.astype(np.int64) if values.dtype == bool else values
        # every trial has a sample
        return np.asarray(np.add.reduceat(counted, self.start))

    def runs(self, marked: Bool[np.ndarray, " sample"]) -> Int[np.ndarray, " trial"]:
        """Count the runs of marked samples in each trial: episodes, however long each lasts."""
        before = np.concatenate([[False], marked[:-1]])
        return self.total(marked & (self.is_first | ~before))

    def seen(self, role: Role) -> Bool[np.ndarray, " sample"]:
        """Return the intervals at both ends of which an agent was seen."""
        here = self.log["observed"].values[:, self.agent(role)] != 0
        both: np.ndarray = here.copy()
        both[1:] &= here[:-1]
        both[self.is_first] = False
        return both

    def step_length(self, role: Role, positions: str = "position") -> Float[np.ndarray, " sample"]:
        """Return how far an agent moved in each interval; NaN where it was not seen at both ends."""
        where = self.log[positions].values[:, self.agent(role)]
        length = np.full(len(where), np.nan)
        length[1:] = np.sqrt(((where[1:] - where[:-1]) ** 2).sum(axis=-1))
        length[self.is_first] = np.nan
        return length

    def idle_and_active(self, role: Role) -> tuple[Bool[np.ndarray, " sample"], Bool[np.ndarray, " sample"]]:
        """Return the intervals in which an agent was idle, and those in which it was active; unseen ones are neither.

        1. By flags: an interval is idle where the flag of the sample at which it begins is not 0.
        2. By motion: where the agent was seen at both ends, and was not faster than the threshold.
        """
        if role not in self._idle_and_active:
            split = self._by_flag if self.idle.source == "flags" else self._by_motion
            self._idle_and_active[role] = split(role)
        return self._idle_and_active[role]

    @cached_property
    def _idle_and_active(
        self,
    ) -> dict[Role, tuple[Bool[np.ndarray, " sample"], Bool[np.ndarray, " sample"]]]:
        return {}

    def _by_flag(self, role: Role) -> tuple[Bool[np.ndarray, " sample"], Bool[np.ndarray, " sample"]]:
        there = ~self.is_first
        waits = there.copy()
        waits[1:] &= self.values(flag_of(role))[:-1] != 0
        return waits, there & ~waits

    def _by_motion(self, role: Role) -> tuple[Bool[np.ndarray, " sample"], Bool[np.ndarray, " sample"]]:
        seen = self.seen(role)
        slow = np.zeros(seen.shape, bool)
        # as lengths: no division by an interval that is too short
        slow[seen] = self.step_length(role)[seen] <= self.idle.speed[role] * self.interval[seen]
        return slow, seen & ~slow


def share(
    part: Float[np.ndarray, " trial"], whole: Float[np.ndarray, " trial"]
) -> Float[np.ndarray, " trial"]:
    """Return what share of a whole a part is, or its rate: NaN where there is no whole.

    Examples
    --------
    >>> share(np.array([1.0, 0.0]), np.array([4.0, 0.0])).tolist()
    [0.25, nan]
    """
    found: np.ndarray = np.divide(part, whole, out=np.full(whole.shape, np.nan), where=whole > 0)
    return found
