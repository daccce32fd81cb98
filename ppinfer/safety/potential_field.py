"""Potential-field control: what is near pushes away (29)."""

from __future__ import annotations

import numpy as np
from jaxtyping import Float

from ppinfer.errors import SafetyError
from ppinfer.safety.motion import LinearAgent


def potential_field_control(
    position: Float[np.ndarray, "*batch space"],
    source: Float[np.ndarray, "*#batch space"],
    *,
    strength: float = 10.0,
    clip: float = 0.5,
) -> Float[np.ndarray, "*batch space"]:
    """Return gamma / d^2 (x_R - o): a control that pushes a robot away from `source` (29).

    With a negative strength it attracts. The printed sign attracts to what is to be avoided; this one repels.

    Parameters
    ----------
    position, source : (..., space) float64
        Where the robot is, and what pushes it (m).
    strength : float
        gamma.
    clip : float
        Distances d below this count as this (m), so that the push stays finite.

    Raises
    ------
    SafetyError
        Where `clip` is not positive.

    Examples
    --------
    >>> potential_field_control(np.array([2.0, 0.0]), np.zeros(2))
    array([5., 0.])
    """
    if not clip > 0:
        raise SafetyError(f"clip must be positive (m); got {clip!r}")
    away = position - source
    square = np.maximum((away * away).sum(axis=-1, keepdims=True), clip * clip)
    push: np.ndarray = strength / square * away
    return push


def check_pushable(robot: LinearAgent) -> None:
    """Refuse an agent whose controls are not one for each dimension of its position: a push has no place there.

    Raises
    ------
    SafetyError
        If so.
    """
    space, controls = len(robot.position_index), robot.B.shape[1]
    if space != controls:
        raise SafetyError(
            f"a potential field needs one control for each dimension of the position, in the same order; the robot has "
            f"{controls} controls and {space} dimensions"
        )
