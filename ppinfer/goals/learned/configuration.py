"""What a network is made of, and in which units it sees the world."""

from __future__ import annotations

import json
from dataclasses import asdict, dataclass, fields
from typing import Any

from ppinfer.errors import ModelError
from ppinfer.goals.dynamics import Dynamics
from ppinfer.goals.model import LARGEST, require_range
from ppinfer.goals.noisily_rational import NoisilyRational

# more than any network here needs, and less than what a crafted file could ask a machine to allocate
_LARGEST_SIZE = 4096


@dataclass(frozen=True)
class NetworkConfiguration:
    """Sizes of the network, and how plans and states are to be understood.

    Parameters
    ----------
    past, horizon : int
        Steps of motion so far, the present one included, and steps of the robot's plan to come.
    hidden : int
        Width of the LSTM's states and of the layers behind it.
    dynamics : {"double-integrator", "single-integrator"}
        What states hold.
    dt : float
        Seconds of a step.
    state_weight, control_weight : float
        Q and R of the robot's LQR, whose way to a goal is its nominal plan.
    length_scale, speed_scale : float
        What counts as one unit inside the network (m, m/s).

    Raises
    ------
    ModelError
        Where a value is out of its range.

    Examples
    --------
    >>> configuration = NetworkConfiguration(past=10, horizon=30)
    >>> NetworkConfiguration.from_json(configuration.to_json()) == configuration
    True
    """

    past: int
    horizon: int
    hidden: int = 32
    dynamics: str = "double-integrator"
    dt: float = 0.1
    state_weight: float = 10.0
    control_weight: float = 1.0
    length_scale: float = 10.0
    speed_scale: float = 5.0

    def __post_init__(self) -> None:
        for name in ("past", "horizon", "hidden"):
            value = getattr(self, name)
            if not (isinstance(value, int) and not isinstance(value, bool) and 1 <= value <= _LARGEST_SIZE):
                raise ModelError(f"{name} must be a whole number from 1 to {_LARGEST_SIZE}; got {value!r}")
        for name in ("dt", "state_weight", "control_weight", "length_scale", "speed_scale"):
            require_range(name, getattr(self, name), 0.0, LARGEST, open_low=True)
        Dynamics.named(self.dynamics, self.dt)

    @property
    def robot(self) -> NoisilyRational:
        """The robot's LQR."""
        return NoisilyRational.lqr(
            Dynamics.named(self.dynamics, self.dt),
            state_weight=self.state_weight,
            control_weight=self.control_weight,
        )

    def to_json(self) -> str:
        """Return it as a line of JSON."""
        return json.dumps(asdict(self), sort_keys=True)

    @classmethod
    def from_json(cls, text: str) -> NetworkConfiguration:
        """Return the configuration that a line of JSON holds.

        Raises
        ------
        ModelError
            Where it holds another one, or none.
        """
        try:
            found: Any = json.loads(text)
        except ValueError as error:
            raise ModelError(f"the configuration is not JSON: {error}") from error
        names = {field.name for field in fields(cls)}
        if not isinstance(found, dict) or set(found) != names:
            raise ModelError(f"the configuration must name {', '.join(sorted(names))}")
        wanted = {field.name: field.type for field in fields(cls)}
        for name, value in found.items():
            kinds: dict[Any, tuple[type, ...]] = {"int": (int,), "float": (int, float), "str": (str,)}
            if isinstance(value, bool) or not isinstance(value, kinds[wanted[name]]):
                raise ModelError(f"the configuration's {name} must be of type {wanted[name]}; got {value!r}")
        return cls(**found)
