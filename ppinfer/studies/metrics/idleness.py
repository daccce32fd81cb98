"""What counts as idle: where the log says that an agent waits, else where it hardly moves."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any, Literal

IdleFrom = Literal["auto", "flags", "motion"]
IDLE_FROM: tuple[IdleFrom, ...] = ("auto", "flags", "motion")


def flag_of(role: str) -> str:
    """Return the name of the variable that says at each sample whether an agent waits.

    Examples
    --------
    >>> flag_of("robot")
    'is_{robot}_waiting'
    """
    return f"is_{{{role}}}_waiting"


@dataclass(frozen=True)
class IdleRule:
    """What counts as idle in a log; `ppinfer.studies.metrics.idle_rule.idle_rule` makes it.

    Parameters
    ----------
    source : {"flags", "motion"}
        Whether the log's waiting flags say it, or how fast an agent is.
    speed : mapping of str to float
        For each role the speed up to which an agent that is seen is idle, in the log's units of position a second.
    units : str
        Of these speeds.
    unused : str
        Why flags that the log has are not used; empty otherwise.
    """

    source: Literal["flags", "motion"] = "motion"
    speed: dict[str, float] = field(default_factory=dict)
    units: str = ""
    unused: str = ""

    def to_json(self) -> dict[str, Any]:
        """Return it as JSON has it."""
        return {"from": self.source, "speed": dict(self.speed), "units": self.units}
