"""When two arms would come into contact, profile by profile, and how far apart they are now."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from jaxtyping import Float

from ppinfer.coordination.plans import PlanSet
from ppsim.arms.geometry import Arm
from ppsim.errors import SimulationError


def contact_tables(
    arms: Sequence[Arm], plans: Sequence[PlanSet], *, stride: float = 0.1, clearance: float = 0.01
) -> tuple[Float[np.ndarray, "one two"], Float[np.ndarray, "one two"]]:
    """Return when the arms first collide, and when they first come within a clearance, for each pair of plans.

    Both arms' capsules are held against each other at `stride`, 2 `stride`, ... seconds from now, until the first of
    the two plans has ended: whoever finishes leaves. The static plan never ends. Now itself is not looked at: it is the
    same for all profiles, and two static plans never come into contact. What happens between these instants goes
    unseen: at the study's speeds two points of arms come at most 7.5 cm closer in 0.1 s.

    Parameters
    ----------
    arms : sequence of 2 Arm
        In the order of the plans.
    plans : sequence of 2 PlanSet
        Of both arms, from the same instant on.
    stride : float
        Seconds between checks; the paper's is 0.8.
    clearance : float
        Of the second table, m.

    Returns
    -------
    (plan of one, plan of two) float64
        Seconds until the capsules first touch; inf where they never do.
    (plan of one, plan of two) float64
        Seconds until they are first within the clearance, which is never later.

    Raises
    ------
    SimulationError
        If there are not two arms with plans of two joints, or stride or clearance make no sense.

    Examples
    --------
    >>> from ppsim.arms.geometry import ARMS
    >>> reaches = PlanSet("robot", [2, 1], [0.0, 4.0, 0.0], [[1.0, 0.0], [0.0, 0.0], [1.0, 0.0]], static=1)
    >>> waits = PlanSet("human", [1], [0.0], [[0.0, 0.0]], static=0)
    >>> collision, contact = contact_tables([ARMS["robot"], ARMS["human"]], [reaches, waits])
    >>> collision.ravel().round(1), contact.ravel().round(1)
    (array([ 2., inf]), array([1.7, inf]))
    """
    if len(arms) != 2 or len(plans) != 2:
        raise SimulationError(f"expected two arms and their plans; got {len(arms)} and {len(plans)}")
    for own in plans:
        if own.position.shape[1] != 2:
            raise SimulationError(f"plans of {own.agent!r} have {own.position.shape[1]} joints; arms have 2")
    if not 0.0 < stride < np.inf or not 0.0 <= clearance < np.inf:
        raise SimulationError(
            f"stride must be positive and clearance not negative; got {stride!r} s and {clearance!r} m"
        )
    from ppsim.arms.scans import contacts

    one, two = plans
    first = contacts(
        _rows(arms),
        one.starts,
        one.row_size,
        one.time,
        one.position,
        -1 if one.static is None else one.static,
        two.starts,
        two.row_size,
        two.time,
        two.position,
        -1 if two.static is None else two.static,
        float(stride),
        float(clearance),
    )
    return first[0], first[1]


def clearance_between(arms: Sequence[Arm], one: Any, two: Any) -> Float[np.ndarray, "*batch"]:
    """Return how far apart the capsules of two arms are, m; where they overlap it is negative.

    Parameters
    ----------
    arms : sequence of 2 Arm
        Whose joint angles they are.
    one, two : (*batch, 2) float
        Joint angles of each, rad.

    Examples
    --------
    >>> from ppsim.arms.geometry import ARMS
    >>> arms = [ARMS["robot"], ARMS["human"]]
    >>> float(clearance_between(arms, arms[0].home, arms[1].home).round(3))
    0.582
    """
    from ppsim.arms.scans import clearances

    one, two = np.broadcast_arrays(np.asarray(one, np.float64), np.asarray(two, np.float64))
    flat = clearances(
        _rows(arms), np.ascontiguousarray(one.reshape(-1, 2)), np.ascontiguousarray(two.reshape(-1, 2))
    )
    return flat.reshape(one.shape[:-1])


def _rows(arms: Sequence[Arm]) -> Float[np.ndarray, "arm 6"]:
    """Return the arms as the compiled scans know them: base, heading, links, radius."""
    return np.array([(*arm.base, arm.heading, *arm.links, arm.radius) for arm in arms])
