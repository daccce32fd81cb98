"""The mapping of a tidy table, a TOML file: which column is what, in which units, and where the goals are."""

from __future__ import annotations

import difflib
import tomllib
from collections.abc import Iterable
from pathlib import Path
from typing import Any, Literal

from pydantic import BaseModel, ConfigDict, Field, ValidationError, model_validator

from ppinfer.guarding import read_toml
from ppinfer.studies.faults import Fault, Faults
from ppinfer.studies.readers.variable_names import CellKind, Per, wrong_with_variable

COORDINATES = ("x", "y", "z")


class _Table(BaseModel):
    model_config = ConfigDict(extra="forbid", frozen=True, strict=True)


class FileOptions(_Table):
    """``[file]``: how a CSV file is written, and which cells mean that there is no value."""

    delimiter: str = Field(",", min_length=1, max_length=1)
    decimal: Literal[".", ","] = "."
    missing: list[str] = ["", "NA", "NaN", "nan", "null"]


class Motion(_Table):
    """``[agents.NAME]``: the columns of one agent in a wide table; also the motion part of ``[columns]``."""

    x: str | None = None
    y: str | None = None
    z: str | None = None
    vx: str | None = None
    vy: str | None = None
    vz: str | None = None
    ux: str | None = None
    uy: str | None = None
    uz: str | None = None
    true_goal: str | None = None


class Columns(Motion):
    """``[columns]``: which column is what."""

    trial: str | None = None
    participant: str | None = None
    time: str | None = None
    agent: str | None = None
    condition: str | None = None
    round: str | None = None
    seed: str | None = None
    outcome: str | None = None


class Constants(_Table):
    """``[constants]``: what is the same in every row and so has no column."""

    trial: str | None = None
    participant: str | None = None
    agent: str | None = None
    condition: str | None = None
    control_quantity: Literal["velocity", "acceleration", "other"] = "acceleration"


class Units(_Table):
    """``[units]``: what times and positions are counted in; a number is the size of one unit in s or m."""

    time: str | float = "s"
    position: str | float = "m"
    velocity: str | float | None = None
    label: str | None = None


class VariableColumn(_Table):
    """``[variables]``: the column of a further variable (in a wide table one for each agent); a text is a column."""

    column: str | None = None
    columns: dict[str, str] | None = None
    per: Per | None = None
    kind: CellKind | None = None

    @model_validator(mode="before")
    @classmethod
    def _plain(cls, told: Any) -> Any:
        return {"column": told} if isinstance(told, str) else told

    def all_columns(self) -> list[str]:
        """Return the columns that are named."""
        return [self.column] if self.column is not None else list((self.columns or {}).values())


class GoalPlace(_Table):
    """``[goal_columns.NAME]``: the columns of one goal's position."""

    x: str
    y: str
    z: str | None = None


class GoalsFile(GoalPlace):
    """``[goals_file]``: a table of goals; with ``from_time`` a goal stands there from that time on."""

    path: str
    goal: str
    trial: str | None = None
    from_time: str | None = None


class SegmentsFile(_Table):
    """``[segments_file]``: a table of segments, half-open, by time or by sample within the trial."""

    path: str
    trial: str
    start: str
    stop: str
    true_goal: str | None = None
    agent: str | None = None
    by: Literal["time", "sample"] = "time"


class Mapping(_Table):
    """The whole mapping."""

    title: str = ""
    missing: Literal["fault", "dropout"] = "fault"
    file: FileOptions = Field(default_factory=lambda: FileOptions.model_validate({}))
    columns: Columns = Columns()
    agents: dict[str, Motion] = Field(default_factory=dict)
    constants: Constants = Constants()
    units: Units = Units()
    goals: dict[str, list[float]] = Field(default_factory=dict)
    goals_file: GoalsFile | None = None
    goal_columns: dict[str, GoalPlace] = Field(default_factory=dict)
    segments_file: SegmentsFile | None = None
    variables: dict[str, VariableColumn] = Field(default_factory=dict)

    def motions(self) -> dict[str, Motion]:
        """Return the motion columns by agent; in a long table under the empty name."""
        if self.agents:
            return dict(self.agents)
        own = Motion(**{name: getattr(self.columns, name) for name in Motion.model_fields})
        return {self.constants.agent or "": own}

    def space(self) -> tuple[str, ...]:
        """Return the labels of the coordinates that are mapped."""
        return (
            COORDINATES
            if any(motion.z is not None for motion in self.motions().values())
            else COORDINATES[:2]
        )


def read_mapping(path: Path, faults: Faults) -> Mapping | None:
    """Read a mapping; everything wrong with it is reported at once, and then None returned."""
    file = path.name
    try:
        told = read_toml(path)
    except OSError as error:
        faults.add(Fault("unreadable", f"cannot be read: {error.strerror}", file=str(path)))
        return None
    except (tomllib.TOMLDecodeError, UnicodeDecodeError) as error:
        faults.add(
            Fault("mapping", f"is not TOML: {error}", "see docs/log-format.md for an example", file=file)
        )
        return None
    try:
        mapping = Mapping.model_validate(told)
    except ValidationError as error:
        for wrong in error.errors():
            faults.add(_told(wrong, told, file))
        return None
    before = faults.total
    for message in _contradictions(mapping):
        faults.add(Fault("mapping", message, file=file))
    return mapping if faults.total == before else None


def closest(name: str, known: Iterable[str]) -> str:
    """Return a remark that lists what there is, the likeliest first.

    Examples
    --------
    >>> closest("tiem", ["time", "x"])
    "did you mean 'time'? there are 'time', 'x'"
    """
    names = list(known)
    folded = {other.casefold().strip(): other for other in names}
    near = difflib.get_close_matches(name.casefold(), list(folded), n=1, cutoff=0.5)
    listed = f"there are {', '.join(map(repr, names))}" if names else "there are none"
    return f"did you mean {folded[near[0]]!r}? {listed}" if near else listed


def _told(wrong: Any, told: dict[str, Any], file: str) -> Fault:
    place = [str(part) for part in wrong["loc"]]
    where = ".".join(place)
    if wrong["type"] == "extra_forbidden":
        model: Any = Mapping
        for part in place[:-1]:
            annotation = model.model_fields[part].annotation if part in model.model_fields else None
            tables = {"agents": Motion, "goal_columns": GoalPlace, "variables": VariableColumn}
            model = tables.get(part, annotation) or model
            model = next(
                (kind for kind in getattr(model, "__args__", (model,)) if hasattr(kind, "model_fields")),
                model,
            )
        remedy = closest(place[-1], model.model_fields if hasattr(model, "model_fields") else [])
        return Fault("mapping", f"there is no entry {where!r}", remedy, file=file)
    if wrong["type"] == "missing":
        return Fault("mapping", f"{where!r} is missing", file=file)
    return Fault("mapping", f"{where!r}: {wrong['msg']}, got {wrong['input']!r}", file=file)


def _contradictions(mapping: Mapping) -> list[str]:
    columns, constants = mapping.columns, mapping.constants
    found = []
    ways = [columns.agent is not None, constants.agent is not None, bool(mapping.agents)]
    if sum(ways) != 1:
        found.append(
            "say in one way whose motion it is: agent = a column in [columns], agent = a name in "
            "[constants], or a table [agents.NAME] for each agent"
        )
    if columns.time is None:
        found.append("'columns.time' is missing")
    for name in ("trial", "participant", "condition"):
        given = [getattr(columns, name), getattr(constants, name)]
        if name != "condition" and given == [None, None]:
            found.append(
                f"{name!r} is missing: name its column in [columns], or its one value in [constants]"
            )
        if None not in given:
            found.append(f"{name!r} is both in [columns] and in [constants]")
    space = mapping.space()
    for agent, motion in mapping.motions().items():
        where = f"agents.{agent}" if mapping.agents else "columns"
        found += [f"'{where}.{name}' is missing" for name in space if getattr(motion, name) is None]
        for kind, meaning in (("v", "velocity"), ("u", "control")):
            given = [getattr(motion, kind + name) is not None for name in space]
            if any(given) and not all(given):
                found.append(f"{where!r}: a {meaning} has all of {', '.join(kind + name for name in space)}")
    if mapping.agents and any(getattr(columns, name) for name in Motion.model_fields):
        mixed = [name for name in Motion.model_fields if getattr(columns, name)]
        found.append(f"[columns] holds {mixed}, but with [agents.NAME] these belong to each agent")
    if sum([bool(mapping.goals), mapping.goals_file is not None, bool(mapping.goal_columns)]) > 1:
        found.append("say in one way where the goals are: [goals], [goals_file] or [goal_columns]")
    for label, place in mapping.goals.items():
        if len(place) != len(space):
            found.append(f"'goals.{label}' has {len(place)} coordinates, expected {len(space)}")
    heads_for = any(motion.true_goal for motion in mapping.motions().values())
    if heads_for and mapping.segments_file is not None:
        found.append("segments come from true_goal columns or from [segments_file], not from both")
    labelled = heads_for or (
        mapping.segments_file is not None and mapping.segments_file.true_goal is not None
    )
    if labelled and not (mapping.goals or mapping.goals_file or mapping.goal_columns):
        found.append(
            "true goals are named, but not where the goals are: add [goals], [goals_file] or [goal_columns]"
        )
    agents = list(mapping.agents) or ([constants.agent] if constants.agent is not None else [])
    for name, told in mapping.variables.items():
        found += wrong_with_variable(name, told, agents, wide=bool(mapping.agents))
    for name in ("time", "position", "velocity"):
        unit = getattr(mapping.units, name)
        if unit is not None and scale(name, unit) is None:
            found.append(
                f"'units.{name}' is {unit!r}; expected a positive number or one of {', '.join(UNITS[name])}"
            )
    return found


# (multiply by, divide by): 300 ms / 1000 is 0.3 s exactly, 300 * 0.001 need not be
UNITS: dict[str, dict[str, tuple[float, float]]] = {
    "time": {"s": (1, 1), "ms": (1, 1000), "us": (1, 1e6), "ns": (1, 1e9), "min": (60, 1)},
    "position": {
        "m": (1, 1),
        "cm": (1, 100),
        "mm": (1, 1000),
        "km": (1000, 1),
        "in": (0.0254, 1),
        "ft": (0.3048, 1),
    },
    "velocity": {"m/s": (1, 1), "cm/s": (1, 100), "mm/s": (1, 1000), "km/h": (1, 3.6)},
}


def scale(quantity: str, unit: str | float) -> tuple[float, float] | None:
    """Return what to multiply with and to divide by to come to SI, or None if there is no such unit.

    Examples
    --------
    >>> scale("time", "ms"), scale("position", 0.5)
    ((1, 1000), (0.5, 1))
    """
    if isinstance(unit, str):
        return UNITS[quantity].get(unit)
    return (unit, 1) if 0 < unit < float("inf") else None
