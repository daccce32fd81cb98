"""What is known of a variable of a study by its name: what there is one of, and what its cells say."""

from __future__ import annotations

import re
import unicodedata
from collections.abc import Collection
from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal

from ppinfer.studies.schema import DIMS, VARIABLES, VariableSpec

if TYPE_CHECKING:
    from ppinfer.studies.readers.mapping import VariableColumn

Per = Literal["trial", "sample", "trial-agent", "sample-agent"]
CellKind = Literal["number", "integer", "flag", "text", "time"]

DIMS_OF: dict[Per, tuple[str, ...]] = {
    "trial": ("trial",),
    "sample": ("sample",),
    "trial-agent": ("trial", "agent"),
    "sample-agent": ("sample", "agent"),
}
ARGUMENTS = ("controller", "instruction")
"""What `build_log` takes as arguments of its own, though a mapping gives it as any other variable."""

_IN_COLUMNS = ("time", "participant", "condition", "round", "seed", "outcome", "true_goal")
# a Zarr store has a file of its own called zarr.json
_NAME = re.compile(r"(?!zarr\.json$)[^\W\d_]([\w. -]*\w)?", re.IGNORECASE)


@dataclass(frozen=True)
class Known:
    """What there is one of, and what cells may say: the first kind unless the mapping says another.

    Parameters
    ----------
    per, kinds
        As in a mapping's ``[variables]``.
    """

    per: Per
    kinds: tuple[CellKind, ...]


READ_BY_METRICS: dict[str, Known] = {
    "team_score": Known("trial", ("number", "integer")),
    "collisions": Known("trial", ("number", "integer")),
    "n_collisions": Known("trial", ("number", "integer")),
    "first_score_s": Known("trial", ("time", "number")),
    "collision": Known("sample", ("flag",)),
    "scored": Known("sample", ("flag",)),
    "pursued": Known("sample-agent", ("integer", "number")),
    "is_{agent}_waiting": Known("sample", ("flag",)),
    "{agent}_pick": Known("sample", ("integer", "number")),
    "{agent}_goal_index": Known("sample", ("integer", "number")),
    "{agent}_goal_changes": Known("trial", ("number", "integer")),
}
"""Variables that are none of the format's own, but that metrics of `ppinfer.studies.metrics` read."""


def known_variable(name: str, agents: Collection[str] = ()) -> Known | None:
    """Return what is known of a variable by its name, None of one that only its study knows.

    Parameters
    ----------
    name : str
        What the log calls it.
    agents : collection of str
        Labels of the agents, which are part of some names.

    Examples
    --------
    >>> known_variable("finish_time").per, known_variable("is_arm_waiting", ["arm"]).kinds
    ('trial-agent', ('flag',))
    >>> known_variable("layout") is None
    True
    """
    if name in VARIABLES:
        return _of_the_format(VARIABLES[name])
    for pattern, found in READ_BY_METRICS.items():
        if name == pattern or any(name == pattern.replace("{agent}", agent) for agent in agents):
            return found
    return None


def wrong_with_variable(
    name: str, told: VariableColumn, agents: Collection[str], *, wide: bool = False
) -> list[str]:
    """Return what is wrong with an entry of ``[variables]``.

    Parameters
    ----------
    name : str
        What the log is to call it.
    told : VariableColumn
        The entry.
    agents : collection of str
        Labels of the agents, as far as they are known.
    wide : bool
        Whether each agent has columns of its own.

    Examples
    --------
    >>> from ppinfer.studies.readers.mapping import VariableColumn
    >>> wrong_with_variable("row_size", VariableColumn(column="n"), ["human"])
    ["'variables.row_size': the log has something of its own of this name; choose another"]
    """
    where = f"'variables.{name}'"
    spec = VARIABLES.get(name)
    if name in DIMS or (spec is not None and not spec.as_variable and name not in ARGUMENTS):
        remedy = "name its column in [columns]" if name in _IN_COLUMNS else "choose another"
        return [f"{where}: the log has something of its own of this name; {remedy}"]
    known = known_variable(name, agents)
    if spec is not None and known is None:
        return [f"{where}: is a point at each sample, which a column cannot give"]
    if not _NAME.fullmatch(name) or len(name) > 100 or not unicodedata.is_normalized("NFC", name):
        return [
            f"{where}: a name has up to 100 letters, digits, '_', '-', '.' and spaces, begins with a letter, and ends "
            "with a letter, a digit or '_'"
        ]
    found = []
    if known is not None and told.per not in (None, known.per):
        found.append(f"{where}: per is {told.per!r}; there is one a {known.per}")
    if known is not None and told.kind is not None and told.kind not in known.kinds:
        found.append(f"{where}: kind is {told.kind!r}; expected {' or '.join(map(repr, known.kinds))}")
    return found + _wrong_columns(where, told, known.per if known else told.per, agents, wide)


def _wrong_columns(
    where: str, told: VariableColumn, per: Per | None, agents: Collection[str], wide: bool
) -> list[str]:
    of_agents = per in ("trial-agent", "sample-agent")
    if (told.column is None) == (told.columns is None):
        return [f"{where}: name its column, or with [agents.NAME] in columns one for each agent"]
    if told.columns is None:
        if of_agents and wide and len(agents) > 1:
            return [f"{where}: name one for each agent, columns = {{{' = ..., '.join(agents)} = ...}}"]
        return []
    if not wide:
        return [f"{where}: columns of agents go with [agents.NAME]; name one column"]
    if per is not None and not of_agents:
        return [f"{where}: there is one a {per}; name one column"]
    strange = [agent for agent in told.columns if agent not in agents]
    absent = [agent for agent in agents if agent not in told.columns]
    return [
        *(f"{where}: there is no agent {agent!r}; the agents are {', '.join(agents)}" for agent in strange),
        *(f"{where}: the agent {agent!r} has no column" for agent in absent),
    ]


def _of_the_format(spec: VariableSpec) -> Known | None:
    per = next((per for per, dims in DIMS_OF.items() if dims in spec.dims), None)
    if per is None:
        return None
    if spec.units == "s":
        return Known(per, ("time", "number"))
    kinds: dict[str, tuple[CellKind, ...]] = {
        "str": ("text",),
        "float64": ("number", "integer"),
        "int64": ("integer",),
        "int8": ("flag",),
    }
    return Known(per, kinds[spec.kind])
