"""What is asked of a report: which trials, which segments and people, by which model, and who is who."""

from __future__ import annotations

import shlex
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path

import xarray as xr

from ppinfer.errors import LogError
from ppinfer.goals import GoalModel
from ppinfer.goals.configuration import make_model, parameters_of, read_model
from ppinfer.studies.scores import DEFAULT_SHARES
from ppinfer.studies.segment_selection import SegmentOptions

DEFAULT_MODEL = "goal-lqr"
ROBOT, HUMAN = "robot", "human"
SEGMENT_OPTIONS = ("at", "min_samples", "min_distance")
NO_SEGMENTS = "choose{s} segments with a goal, of which this file has none"
OF_LOGS_ONLY = "choose{s} what is inferred of a log and of whom, and this is a posterior"


@dataclass(frozen=True)
class ReportOptions:
    """What was asked for; the names are those of `ppinfer.report.write_report`."""

    trials: tuple[str, ...] | None = None
    at: tuple[float, ...] = tuple(DEFAULT_SHARES)
    min_samples: int | None = None
    min_distance: float | None = None
    participants: tuple[str, ...] | None = None
    exclude: tuple[str, ...] | None = None
    model: str | None = None
    parameters: Mapping[str, str] = field(default_factory=dict)
    robot: str | None = None
    human: str | None = None

    @property
    def selection(self) -> SegmentOptions:
        """Which segments count."""
        return {
            "min_samples": self.min_samples,
            "min_distance": self.min_distance,
            "participants": self.participants,
            "exclude": self.exclude,
        }

    @property
    def is_fitted(self) -> bool:
        """Whether the model's parameters come from a MODEL.toml (its name has a dot or a slash)."""
        return self.model is not None and ("/" in self.model or "." in self.model)

    def goal_model(self) -> GoalModel:
        """Return the model that infers goals of a log: by name, or from a MODEL.toml."""
        name = self.model or DEFAULT_MODEL
        if not self.is_fitted:
            return make_model(name, self.parameters)
        read = read_model(name)
        return make_model(read.name, {**parameters_of(read), **self.parameters}) if self.parameters else read

    def model_origin(self) -> str:
        """Say where the model's parameters come from."""
        if self.is_fitted:
            told = f"with the parameters of {Path(self.model or '').name}"
            return f"{told} and some given by hand" if self.parameters else told
        if self.parameters:
            return "with parameters given by hand, not fitted: fit before you conclude"
        return "at its defaults, not fitted: fit before you conclude"

    def command(self, source: Path) -> str:
        """Return the command that makes the page; where the page goes does not matter, and is called report."""
        words = ["ppinfer", "report", source.name, "-o", "report"]
        if self.trials is not None:
            words += ["--trials", *self.trials]
        words += ["--at", *(f"{share:g}" for share in self.at)]
        for name in ("min_samples", "min_distance", "participants", "exclude"):
            value = getattr(self, name)
            if value is not None:
                words += [
                    f"--{name.replace('_', '-')}",
                    *map(str, value if isinstance(value, tuple) else [value]),
                ]
        if self.model is not None:
            words += ["--model", self.model]
        if self.parameters:
            words += ["--set", *(f"{name}={value}" for name, value in self.parameters.items())]
        for name in ("robot", "human"):
            if getattr(self, name) is not None:
                words += [f"--{name}", getattr(self, name)]
        return shlex.join(words)

    def refuse(self, source: Path, names: tuple[str, ...], why: str) -> None:
        """Raise `LogError` where any of these was asked for, which this file gives no use for."""
        plain = ReportOptions()
        given = [name for name in names if getattr(self, name) != getattr(plain, name)]
        if given:
            told = ", ".join("set" if name == "parameters" else name for name in given)
            raise LogError(f"{source}: {told} {why.format(s='s' * (len(given) == 1))}; leave it out")


@dataclass(frozen=True)
class Pair:
    """Who is the robot and who the human of a log."""

    robot: str
    human: str


def pair_of(log: xr.Dataset, options: ReportOptions) -> Pair | None:
    """Return who is who: as asked, else by name; of two agents the other one is the other. None where it is not told.

    Raises
    ------
    LogError
        If an agent that was asked for is not there, or both are the same.
    """
    agents = [str(name) for name in log["agent"].values]
    for option, name in (("robot", options.robot), ("human", options.human)):
        if name is not None and name not in agents:
            raise LogError(
                f"--{option} {name}: there is no such agent in the log; there are {', '.join(agents)}"
            )
    if options.robot is not None and options.robot == options.human:
        raise LogError(f"--robot and --human are both {options.robot}; two agents are expected")
    robot, human = options.robot, options.human
    if robot is None and ROBOT in agents and human != ROBOT:
        robot = ROBOT
    if human is None and HUMAN in agents and robot != HUMAN:
        human = HUMAN
    if len(agents) == 2 and (robot is None) != (human is None):
        (other,) = (name for name in agents if name not in (robot, human))
        robot, human = robot or other, human or other
    return Pair(robot, human) if robot is not None and human is not None else None
