"""Everything that is wrong with a log, at once: each fault with its trial, sample and column."""

from __future__ import annotations

import itertools
import os
from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr
from jaxtyping import Float, Shaped

from ppinfer import guarding
from ppinfer.errors import LogError
from ppinfer.studies.blocks import block_edges
from ppinfer.studies.checksums import ContentDigest, slabs
from ppinfer.studies.faults import Fault, Faults, Report
from ppinfer.studies.goal_absences import GoalAbsences
from ppinfer.studies.motion_checks import (
    JUMP_FACTOR,
    Rows,
    check_logged,
    check_marks,
    check_positions,
    check_time,
    goal_faults,
    jump_threshold,
    step_speeds,
)
from ppinfer.studies.planned_checks import (
    DEEP,
    ReplanPlaces,
    check_costs,
    check_planned_trials,
    check_replan_times,
    check_replans,
    check_waypoints,
    planned_rows,
)
from ppinfer.studies.progress import ProgressCallback, silent
from ppinfer.studies.schema import DIGEST_ATTR
from ppinfer.studies.storage import open_log
from ppinfer.studies.structure_checks import (
    check_row_sizes,
    check_segments,
    check_structure,
    sample_offsets,
    trial_names,
)

_BLOCK_SAMPLES = 500_000
_BLOCK_DEEP = 4_000_000


def validate_log(log: xr.Dataset | str | os.PathLike[str], *, progress: ProgressCallback = silent) -> Report:
    """Find everything that is wrong with a study log.

    A log on disk is read once, in blocks of whole trials, and its content is compared with its digest; of a
    log in memory the digest is not looked at, since editing it is what memory is for.

    Parameters
    ----------
    log
        A log or the path of one.
    progress
        Told how many samples are checked, of how many.

    Returns
    -------
    Report
        ``faults``, ``warnings`` (implausible jumps, a missing digest), exact counts of each kind, and ``ok``.
        A file that cannot be read at all is a report with one fault.

    Examples
    --------
    >>> from ppinfer.studies import build_log
    >>> log = build_log(agents=["human"], row_size=[2], time=[0.1, 0.1], position=np.zeros((2, 1, 2)))
    >>> print(validate_log(log).faults[0].kind)
    time-not-increasing
    """
    if isinstance(log, xr.Dataset):
        return _Validation(log, "log", progress).run()
    source = str(Path(log))
    try:
        # another process reads the log, under limits: this one may never touch it
        told = guarding.asked("validate-log", source, progress=progress)
        if told is not None:
            return Report.from_json(told["report"])
        opened = open_log(log)
    except LogError as error:
        text = str(error).removeprefix(f"{source}: ")
        faults = Faults([Fault("unreadable", text, file=source)])
        return Report.of(source, faults, Faults())
    try:
        return _Validation(opened, source, progress, digest=ContentDigest()).run()
    finally:
        opened.close()


@dataclass
class _Validation:
    log: xr.Dataset
    source: str
    progress: ProgressCallback
    digest: ContentDigest | None = None
    faults: Faults = field(default_factory=Faults)
    warnings: Faults = field(default_factory=Faults)
    damaged: set[str] = field(default_factory=set)
    absences: GoalAbsences | None = None
    places: ReplanPlaces | None = None

    def run(self) -> Report:
        # numbers that are none are what is looked for: that there are some is no cause for a warning
        with np.errstate(all="ignore"):
            return self._run()

    def _run(self) -> Report:
        sizes = {str(name): size for name, size in self.log.sizes.items()}
        usable = check_structure(self.log, self.faults)
        usable &= self._load_still()
        cut = "row_size" in usable and check_row_sizes(self.log, self.faults)
        offsets = (
            sample_offsets(self.log["row_size"].values) if cut else np.array([0, sizes.get("sample", 0)])
        )
        names = trial_names(self.log) if cut else ["?"]
        if cut:
            self._count_absences(usable, offsets)
            self._check_planned(usable, names)
        self._check_samples(usable, offsets, names, cut)
        self._check_deep(usable, names)
        needed = {
            "segment_trial",
            "segment_agent",
            "segment_start",
            "segment_stop",
            "true_goal",
            "agent",
            "row_size",
        }
        if needed <= usable:
            sound = check_segments(self.log, self.faults)
            if cut and {"goal", "goal_present"} <= usable:
                self._check_true_goals(sound, names)
        if {"goal_position", "goal_present"} <= usable and "sample" not in self.log["goal_present"].dims:
            placed, present = self.log["goal_position"].values, self.log["goal_present"].values
            ids = trial_names(self.log)
            for kind, column, wrong, message, remedy in goal_faults(placed, present):
                fault = Fault(kind, message, remedy, column=column)
                self.faults.add_each(
                    kind,
                    np.flatnonzero(wrong).tolist(),
                    # bound now: the loop's next kind must not change what this one says
                    partial(lambda fault, trial: replace(fault, trial=ids[trial]), fault),
                )
        self._check_digest()
        return Report.of(self.source, self.faults, self.warnings, sizes)

    def _load_still(self) -> set[str]:
        """Read what is not along samples, waypoints or profiles; return the names of all that can be read."""
        readable, loaded = set(), {}
        for name, variable in self.log.variables.items():
            if not {"sample", *DEEP}.isdisjoint(variable.dims):
                readable.add(str(name))
                continue
            values = self._read(str(name), slice(None))
            if values is not None:
                readable.add(str(name))
                # what is in memory need not be put there
                if name not in self.log.coords and self.digest is not None:
                    loaded[name] = (variable.dims, values, variable.attrs)
        self.log = self.log.assign(loaded) if loaded else self.log
        return readable

    def _read(self, name: str, rows: slice) -> Shaped[np.ndarray, "*_"] | None:
        if name in self.damaged:
            return None
        variable = self.log.variables[name]
        try:
            values: Any = variable[rows].values if variable.ndim else variable.values
        except Exception as error:
            self.damaged.add(name)
            reason = " ".join(str(error).split())[:160]
            self.faults.add(
                Fault(
                    "checksum",
                    f"cannot be read from row {rows.start or 0} on ({reason})",
                    "the file is damaged: get it again from its source",
                    column=name,
                )
            )
            return None
        if self.digest is not None:
            self.digest.update(name, values)
        return np.asarray(values)

    def _check_planned(self, usable: set[str], names: list[str]) -> None:
        check_planned_trials(self.log, usable, names, self.faults)
        rows = planned_rows(self.log, usable, names, self.faults)
        if rows is not None:
            self.places = ReplanPlaces(rows, names)
            check_replans(self.log, usable, self.places, self.faults)

    def _check_deep(self, usable: set[str], names: list[str]) -> None:
        """Read waypoints and profiles, a block of whole replans at a time where they can be cut."""
        log = self.log
        deep = {
            dim: [str(name) for name, variable in log.variables.items() if dim in variable.dims]
            for dim in DEEP
        }
        for dim, found in deep.items():
            leading = [name for name in found if log.variables[name].dims[0] == dim]
            for name in sorted(set(found) - set(leading)):
                for slab in slabs(log, name):
                    self._read(name, slab[0] if slab else slice(None))
            for start, stop in self._deep_blocks(dim, log.sizes.get(dim, 0)):
                block = {name: self._read(name, slice(start, stop)) for name in leading}
                held = {name: values for name, values in block.items() if values is not None}
                if self.places is None:
                    continue
                if dim == "waypoint" and {"waypoint_time", "waypoint_position"} <= set(held):
                    check_waypoints(
                        held["waypoint_time"], held["waypoint_position"], start, self.places, self.faults
                    )
                elif dim == "profile" and {"cost", "contact_time"} <= set(held):
                    plans = log.variables["plan_row_size"].values
                    check_costs(held["cost"], held["contact_time"], start, plans, self.places, self.faults)

    def _deep_blocks(self, dim: str, total: int) -> Iterator[tuple[int, int]]:
        if self.places is None:
            yield from ((at, min(at + _BLOCK_DEEP, total)) for at in range(0, total, _BLOCK_DEEP))
            return
        rows = self.places.rows
        edges = rows.profile if dim == "profile" else rows.waypoint[rows.plan]
        yield from itertools.pairwise(edges[block_edges(np.diff(edges), _BLOCK_DEEP)].tolist())

    def _check_samples(self, usable: set[str], offsets: np.ndarray, names: list[str], cut: bool) -> None:
        log = self.log
        along = [str(name) for name in log.variables if "sample" in log.variables[name].dims]
        leading = [name for name in along if log.variables[name].dims[0] == "sample"]
        for name in sorted(set(along) - set(leading)):
            for slab in slabs(log, name):
                self._read(name, slab[0] if slab else slice(None))
        agents = [str(name) for name in log["agent"].values.tolist()] if "agent" in usable else []
        total = int(offsets[-1])
        # four bytes a sample and agent: the only thing here that grows with the samples
        speeds = np.full((len(agents), total if cut else 0), np.nan, np.float32)
        for start, stop in self._blocks(offsets, cut):
            first = np.zeros(stop - start, bool)
            first[offsets[(offsets >= start) & (offsets < stop)] - start] = True
            rows = Rows(offsets, names, start, first)
            block = {name: self._read(name, slice(start, stop)) for name in leading}
            held = {name: values for name, values in block.items() if values is not None and name in usable}
            self._check_block(held, usable, agents, rows, cut)
            if self.places is not None and "time" in held:
                check_replan_times(held["time"], start, self.log, self.places, offsets, self.faults)
            if cut and agents and {"time", "position"} <= set(held):
                speeds[:, start:stop] = step_speeds(held["time"], held["position"], first).T
            if self.absences is not None and "goal_present" in held:
                self.absences.add(held["goal_present"])
            self.progress(stop, total)
        if cut:
            self._warn_of_jumps(speeds, agents, offsets, names)

    def _count_absences(self, usable: set[str], offsets: np.ndarray) -> None:
        """Get ready to count, while the samples go by, where goals are absent within segments."""
        names = ("segment_trial", "segment_start", "segment_stop")
        if not {"goal", "goal_present", *names} <= usable or "sample" not in self.log["goal_present"].dims:
            return
        trial, start, stop = (self.log[name].values for name in names)
        begin = np.zeros(trial.size, np.int64)
        known = (trial >= 0) & (trial < offsets.size - 1)
        begin[known] = offsets[trial[known]]
        samples = int(offsets[-1])
        # segments that do not fit are told elsewhere; here their bounds only must not overflow
        first, last = (begin + np.clip(bound, 0, samples) for bound in (start, stop))
        self.absences = GoalAbsences(first, last, samples=samples, goals=self.log.sizes["goal"])

    def _blocks(self, offsets: np.ndarray, cut: bool) -> Iterator[tuple[int, int]]:
        if not cut:
            total = int(offsets[-1])
            yield from ((at, min(at + _BLOCK_SAMPLES, total)) for at in range(0, total, _BLOCK_SAMPLES))
            return
        edges = offsets[block_edges(np.diff(offsets), _BLOCK_SAMPLES)].tolist()
        yield from itertools.pairwise(edges)

    def _check_block(
        self, held: dict[str, np.ndarray], usable: set[str], agents: list[str], rows: Rows, cut: bool
    ) -> None:
        faults = self.faults
        if "time" in held and cut:
            check_time(held["time"], rows, faults)
        if "observed" in held:
            check_marks("observed", held["observed"], rows, faults)
            if "position" in held and agents:
                check_positions(held["position"], held["observed"], agents, rows, faults)
            for name in ("velocity", "control"):
                if name in held and agents and f"has_{name}" in usable:
                    has = self.log[f"has_{name}"].values
                    check_logged(name, held[name], has, held["observed"], agents, rows, faults)
        if "held" in held:
            check_marks("held", held["held"], rows, faults)
        if "end_effector" in held:
            wild = np.flatnonzero(np.isinf(held["end_effector"]).any(axis=(1, 2)))
            rows.report(
                faults, "not-finite", "end_effector", wild, "is infinite", "NaN where it is not there"
            )
        if {"goal_position", "goal_present"} <= set(held):
            for kind, column, wrong, message, remedy in goal_faults(
                held["goal_position"], held["goal_present"]
            ):
                rows.report(faults, kind, column, np.flatnonzero(wrong), message, remedy)

    def _warn_of_jumps(
        self,
        speeds: Float[np.ndarray, "agent sample"],
        agents: list[str],
        offsets: np.ndarray,
        names: list[str],
    ) -> None:
        everywhere = Rows(offsets, names, 0, np.zeros(0, bool))
        for index, agent in enumerate(agents):
            jumps = np.flatnonzero(speeds[index] > (limit := jump_threshold(speeds[index])))
            if jumps.size:
                trial, sample = everywhere.place(int(jumps[0]))
                self.warnings.add(
                    Fault(
                        "implausible-jump",
                        f"{jumps.size} steps of {agent!r} are faster than {limit:.3g} a second "
                        f"({JUMP_FACTOR:g} times the median of its steps that move); this is the first",
                        "look at them; a marker that was lost is a dropout (observed 0)",
                        trial=trial,
                        sample=sample,
                        column="position",
                        count=int(jumps.size),
                    )
                )

    def _check_true_goals(self, sound: np.ndarray, names: list[str]) -> None:
        log = self.log
        labels = log["goal"].values.astype(str)
        goal = log["true_goal"].values.astype(str)
        if labels.size == 0:
            return
        order = np.argsort(labels)
        at = order[np.minimum(np.searchsorted(labels[order], goal), labels.size - 1)]
        known = np.flatnonzero(sound & (labels[at] == goal) & (goal != ""))
        trial, start = log["segment_trial"].values[known], log["segment_start"].values[known]
        if "sample" not in log["goal_present"].dims:
            present = log["goal_present"].values[trial, at[known]] == 1
        elif self.absences is not None and "goal_present" not in self.damaged:
            present = self.absences.present_throughout(known, goal=at[known])
        else:
            return
        self.faults.add_each(
            "goals-missing",
            np.flatnonzero(~present).tolist(),
            lambda index: Fault(
                "goals-missing",
                f"segment {known[index]}: its true goal {goal[known[index]]!r} is absent during the segment",
                "correct the segment, the label or goal_present",
                trial=names[trial[index]],
                sample=int(start[index]),
                column="true_goal",
            ),
        )

    def _check_digest(self) -> None:
        if self.digest is None:
            return
        stated = self.log.attrs.get(DIGEST_ATTR)
        if stated is None:
            self.warnings.add(
                Fault(
                    "no-checksum",
                    f"there is no attribute {DIGEST_ATTR}",
                    "damage to text would go unseen",
                    file=self.source,
                )
            )
        elif not self.damaged and self.digest.hexdigest(self.log) != stated:
            self.faults.add(
                Fault(
                    "checksum",
                    f"the content does not match {DIGEST_ATTR}: the file is damaged or was edited",
                    "get it again from its source; any other faults may follow from this one",
                    file=self.source,
                )
            )
