"""Which orders of conditions occurred, and whether condition is confounded with position."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import permutations
from typing import Any, Literal

import numpy as np
from jaxtyping import Int

from ppinfer.errors import LogError
from ppinfer.studies.surveys.random_orders import p_of_unevenness

Design = Literal[
    "one order", "fully counterbalanced", "Williams design", "Latin square", "not counterbalanced"
]
Confounding = Literal["none", "partial", "perfect"]
LISTED_ORDERS = 120
MOST_CONDITIONS = 100


@dataclass(frozen=True, eq=False)
class Counterbalancing:
    """What the orders of a study's participants balance, and what they do not; made by `check_orders`.

    Attributes
    ----------
    conditions : tuple of str
        All of them.
    participants : int
        Those whose order has every condition; only these count below.
    incomplete : tuple of str
        Participants whose order lacks conditions.
    orders : dict of tuple of str to int
        The orders that occurred, the most frequent first, and how many participants had each.
    possible : int
        How many orders there are.
    absent : tuple of tuple of str
        Those that did not occur (up to 120 of them).
    positions : (condition, position) int64
        How many participants met each condition at each position.
    following : (condition, condition) int64
        How often the second came right after the first.
    statistic, p : float
        Anderson's statistic of `positions`, and how often random orders are at least as uneven (`method`); NaN without
        a whole order.
    method : str
        ``"exact"`` or how many random assignments.

    Examples
    --------
    >>> found = check_orders({"ann": ["a", "b"], "bob": ["b", "a"], "cy": ["a", "b"]})
    >>> found.positions.tolist(), found.confounding, found.design, round(found.p, 3)
    ([[2, 1], [1, 2]], 'partial', 'not counterbalanced', 1.0)
    """

    conditions: tuple[str, ...]
    participants: int
    incomplete: tuple[str, ...]
    orders: dict[tuple[str, ...], int]
    possible: int
    absent: tuple[tuple[str, ...], ...]
    positions: Int[np.ndarray, "condition position"]
    following: Int[np.ndarray, "condition condition"]
    statistic: float
    p: float
    method: str

    @property
    def expected(self) -> float:
        """How many participants each condition would have at each position."""
        return self.participants / len(self.conditions)

    @property
    def equal_positions(self) -> bool:
        """Whether each condition is at each position equally often."""
        return bool(self.participants and np.ptp(self.positions) == 0)

    @property
    def nearly_equal_positions(self) -> bool:
        """Whether positions are as equal as they can be where conditions do not divide the participants."""
        return bool(self.participants and (np.abs(self.positions - self.expected) < 1).all())

    @property
    def equal_following(self) -> bool:
        """Whether each condition comes right after each other one equally often."""
        apart = self.following[~np.eye(len(self.conditions), dtype=bool)]
        return bool(self.participants and np.ptp(apart) == 0)

    @property
    def confounding(self) -> Confounding:
        """How far position tells the condition: not at all, partly, or perfectly (each condition has its position)."""
        if not self.participants or self.equal_positions:
            return "none"
        return "perfect" if (np.count_nonzero(self.positions, axis=1) == 1).all() else "partial"

    @property
    def cramers_v(self) -> float:
        """Cramér's V of condition and position: 0 = each position has all conditions equally often, 1 = perfect."""
        if not self.participants:
            return math.nan
        deviation = ((self.positions - self.expected) ** 2 / self.expected).sum()
        return math.sqrt(deviation / (self.positions.sum() * (len(self.conditions) - 1)))

    @property
    def design(self) -> Design:
        """What the orders are, by the strictest name that holds.

        Fully counterbalanced: every order equally often. Williams design: each condition at each position, and right
        after each other one, equally often. Latin square: each condition at each position equally often.
        """
        if len(self.orders) == 1:
            return "one order"
        if len(self.orders) == self.possible and len(set(self.orders.values())) == 1:
            return "fully counterbalanced"
        if self.equal_positions:
            return "Williams design" if self.equal_following else "Latin square"
        return "not counterbalanced"

    def to_json(self) -> dict[str, Any]:
        """Return the same as JSON."""
        return {
            "conditions": list(self.conditions),
            "participants": self.participants,
            "incomplete": list(self.incomplete),
            "orders": [{"order": list(order), "participants": count} for order, count in self.orders.items()],
            "possible_orders": self.possible,
            "absent_orders": [list(order) for order in self.absent],
            "positions": [
                {"condition": name, "participants": counts}
                for name, counts in zip(self.conditions, self.positions.tolist(), strict=True)
            ],
            "expected_per_position": self.expected,
            "equal_positions": self.equal_positions,
            "following": [
                {
                    "condition": name,
                    "followed_by": {
                        other: count
                        for other, count in zip(self.conditions, counts, strict=True)
                        if other != name
                    },
                }
                for name, counts in zip(self.conditions, self.following.tolist(), strict=True)
            ],
            "equal_following": self.equal_following,
            "design": self.design,
            "confounding": self.confounding,
            "cramers_v": self.cramers_v,
            "statistic": self.statistic,
            "p": self.p,
            "method": self.method,
        }

    def lines(self) -> list[str]:
        """Return what a reader has to know, in sentences."""
        if not self.participants:
            return ["no participant has an order with every condition"]
        k, said = len(self.conditions), []
        said.append(
            f"{len(self.orders)} of {self.possible} possible orders occurred among {self.participants} participants"
        )
        if self.confounding == "perfect":
            said.append(
                "condition and position are perfectly confounded: effects of either cannot be told apart"
            )
        elif self.equal_positions:
            said.append(
                "each condition is at each position equally often: condition is not confounded with position"
            )
        else:
            allowed = (
                " but as evenly as this number of participants allows" if self.nearly_equal_positions else ""
            )
            said.append(
                f"conditions are not at each position equally often{allowed} ({self.expected:.3g} each would be): "
                f"Cramér's V = {self.cramers_v:.2f}; orders drawn at random are at least as uneven with "
                f"p = {self.p:.3g} ({self.method})"
            )
        if k > 2 and not self.equal_following:
            said.append("who follows whom is not balanced: carry-over may differ between conditions")
        if self.incomplete:
            said.append(f"{len(self.incomplete)} participants have no whole order and were left out here")
        return said


def check_orders(
    orders: Mapping[str, Sequence[str]], *, conditions: Sequence[str] | None = None, seed: int = 0
) -> Counterbalancing:
    r"""Ask what the orders in which participants met the conditions balance.

    With :math:`O_{cj}` participants who met condition c of k at position j and :math:`E = n / k`, Anderson's (1959)
    statistic is :math:`A = \frac{k - 1}{k} \sum_{cj} (O_{cj} - E)^2 / E`. Its p-value is the probability of at least
    that much if each participant's order were drawn from all orders alike. It is added up over all such draws, or
    estimated from random ones: the chi-squared distribution that A nears asks for E of about 5 or more. Orders that
    were assigned to be even have p near 1. A large p does not say that a small study is balanced: `positions` does.

    Parameters
    ----------
    orders : mapping of str to sequence of str
        By participant, the conditions in the order in which they were met; those not met are left out.
    conditions : sequence of str, optional
        All conditions; by default those that occur, sorted.
    seed : int
        Of random assignments, which are drawn where there are too many to go through.

    Raises
    ------
    LogError
        If a condition is unknown or comes twice in an order, or there are fewer than two conditions or more than 100.

    Examples
    --------
    >>> cyclic = {"ann": "abc", "bob": "bca", "cy": "cab"}
    >>> found = check_orders(cyclic)
    >>> found.design, found.equal_positions, found.equal_following
    ('Latin square', True, False)
    """
    known = (
        tuple(conditions)
        if conditions is not None
        else tuple(sorted({name for one in orders.values() for name in one}))
    )
    if len(set(known)) < max(2, len(known)):
        raise LogError(
            f"orders are of two conditions or more, each named once; got {', '.join(map(repr, known)) or 'none'}"
        )
    if len(known) > MOST_CONDITIONS:
        raise LogError(
            f"there are {len(known):,} conditions, and orders of at most {MOST_CONDITIONS} are checked; is the column "
            "of the condition another one?"
        )
    for who, order in orders.items():
        strange = [name for name in order if name not in known]
        twice = [name for name, count in Counter(order).items() if count > 1]
        if strange or twice:
            told = f"has no condition {strange[0]!r}" if strange else f"comes to {twice[0]!r} twice"
            raise LogError(
                f"the order of participant {who!r} {told}; the conditions are {', '.join(map(repr, known))}"
            )
    whole = [tuple(order) for order in orders.values() if len(order) == len(known)]
    at = np.array([[known.index(name) for name in order] for order in whole], np.int64).reshape(
        -1, len(known)
    )
    k = len(known)
    positions = np.zeros((k, k), np.int64)
    following = np.zeros((k, k), np.int64)
    np.add.at(positions, (at, np.arange(k)), 1)
    np.add.at(following, (at[:, :-1], at[:, 1:]), 1)
    counted = sorted(Counter(whole).items(), key=lambda item: (-item[1], item[0]))
    possible = math.factorial(k)
    absent: tuple[tuple[str, ...], ...] = ()
    if possible <= LISTED_ORDERS:
        absent = tuple(order for order in permutations(known) if order not in dict(counted))
    p, method = (math.nan, "none") if not whole else p_of_unevenness(positions, len(whole), seed=seed)
    return Counterbalancing(
        known,
        len(whole),
        tuple(who for who, order in orders.items() if len(order) < k),
        dict(counted),
        possible,
        absent,
        positions,
        following,
        _statistic(positions, len(whole)) if whole else math.nan,
        p,
        method,
    )


def _statistic(positions: Int[np.ndarray, "condition position"], participants: int) -> float:
    k = len(positions)
    return float((k - 1) / k * ((positions - participants / k) ** 2).sum() * k / participants)
