"""Which agents of a log are the robot and the human."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import xarray as xr

from ppinfer.errors import LogError

Role = Literal["robot", "human"]
ROLES: tuple[Role, ...] = ("robot", "human")


@dataclass(frozen=True)
class Roles:
    """Which agents of a log are the robot and the human.

    Parameters
    ----------
    agents : tuple of str
        The log's agents.
    robot, human : str
        Their labels; one that is no agent of the log is told apart by `index`.
    """

    agents: tuple[str, ...]
    robot: str = "robot"
    human: str = "human"

    @classmethod
    def of(cls, log: xr.Dataset, *, robot: str | None = None, human: str | None = None) -> Roles:
        """Return the roles in a log: by default ``robot``, and ``human`` or whoever is the only agent.

        Raises
        ------
        LogError
            If an agent that is named is not in the log, or one is named for both roles.

        Examples
        --------
        >>> from ppinfer.testing import example_log
        >>> Roles.of(example_log()).human
        'human'
        """
        agents = tuple(log["agent"].values.astype(str).tolist())
        for label in (robot, human):
            if label is not None and label not in agents:
                raise LogError(f"there is no agent {label!r} in the log; there are {', '.join(agents)}")
        alone = agents[0] if len(agents) == 1 and agents[0] != (robot or "robot") else "human"
        roles = cls(agents, robot or "robot", human or alone)
        if roles.robot == roles.human:
            raise LogError(f"{roles.robot!r} is both the robot and the human; name two agents")
        return roles

    def label(self, role: str) -> str:
        """Return the label of the agent in a role."""
        return self.robot if role == "robot" else self.human

    def index(self, role: str) -> int | None:
        """Return the place of the agent in a role, None where the log has no such agent."""
        label = self.label(role)
        return self.agents.index(label) if label in self.agents else None

    def absent(self, role: str) -> str:
        """Say in words that nobody has a role."""
        return (
            f"there is no agent {self.label(role)!r} in the log; there are {', '.join(self.agents)} "
            f"(say with --{role} which of them is the {role})"
        )

    def filled(self, name: str) -> str:
        """Return a variable's name with ``{robot}`` and ``{human}`` replaced by the agents' labels."""
        return name.replace("{robot}", self.robot).replace("{human}", self.human)
