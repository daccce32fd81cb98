"""The orders of a survey's participants, told without naming anybody."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from ppinfer.studies.surveys.counterbalancing import Counterbalancing, check_orders
from ppinfer.studies.surveys.orders import orders_of_survey, read_orders
from ppinfer.studies.surveys.survey import Survey


@dataclass(frozen=True, eq=False)
class SurveyOrders:
    """What the orders balance in which the participants of a survey met the conditions.

    Attributes
    ----------
    source : str
        The file that the orders are from.
    found : Counterbalancing
        Of everybody who has an order.
    without_order : tuple of str
        Participants of the survey who have none.
    not_in_survey : int
        How many have an order and no response.
    """

    source: str
    found: Counterbalancing
    without_order: tuple[str, ...]
    not_in_survey: int

    def to_json(self) -> dict[str, Any]:
        """Return the same as JSON."""
        return {
            "source": self.source,
            **self.found.to_json(),
            "without_order": list(self.without_order),
            "not_in_survey": self.not_in_survey,
        }

    def lines(self) -> list[str]:
        """Return what a reader has to know, in sentences."""
        said = self.found.lines()
        if self.without_order:
            said.append(f"{len(self.without_order)} participants of the survey have no order")
        if self.not_in_survey:
            said.append(f"{self.not_in_survey} participants have an order and no response")
        return said


def check_survey_orders(
    survey: Survey,
    path: str | os.PathLike[str] | None = None,
    *,
    names: Mapping[str, str] | None = None,
    by: Sequence[str] | None = None,
    seed: int = 0,
) -> SurveyOrders:
    r"""Ask what the orders balance in which the participants of a survey met the conditions.

    Parameters
    ----------
    survey : Survey
        Read with ``keep_ids``, so that its participants have the names of the table of orders.
    path : path, optional
        A table of orders (`read_orders`); by default the survey's own column of positions is taken.
    names : mapping of str to str, optional
        What participants are to be called; by default their pseudonyms (`Survey.pseudonyms`).
    by : sequence of str, optional
        Condition columns that make up the conditions; by default all.
    seed : int
        Of random assignments (`check_orders`), and of the pseudonyms.

    Raises
    ------
    FaultyLogError, LogError
        As `read_orders`, `orders_of_survey` and `check_orders`.

    Examples
    --------
    >>> from ppinfer.studies.surveys import Instrument, read_survey
    >>> _ = Path("answers.csv").write_text("user,robot,easy\nann,a,5\nann,b,2\nbob,a,3\nbob,b,2\n")
    >>> _ = Path("orders.csv").write_text("user,first,second\nann,a,b\n")
    >>> instrument = Instrument.parse('''
    ...     columns = {subject = "user", condition = "robot"}
    ...     anchors = {1 = "no", 5 = "yes"}
    ...     items.easy = {}
    ... ''')
    >>> checked = check_survey_orders(read_survey("answers.csv", instrument, keep_ids=True), "orders.csv")
    >>> checked.found.orders, len(checked.without_order)
    ({('a', 'b'): 1}, 1)
    """
    told = dict(survey.pseudonyms(seed) if names is None else names)
    conditions = list(survey.groups(by))
    if path is None:
        own = orders_of_survey(
            replace(survey, participants=tuple(told[who] for who in survey.participants)), by
        )
        absent = tuple(sorted(who for who, order in own.items() if not order))
        orders = {who: order for who, order in sorted(own.items()) if order}
        return SurveyOrders(survey.source, check_orders(orders, conditions=conditions, seed=seed), absent, 0)
    read = read_orders(path, survey.instrument, conditions)
    orders = {told[who]: order for who, order in read.items() if who in told}
    without = tuple(sorted(set(told.values()) - set(orders)))
    # those who answered nothing have no pseudonym; their orders count all the same
    others = sorted(order for who, order in read.items() if who not in told)
    orders |= {f"not in the survey, {number}": order for number, order in enumerate(others, start=1)}
    orders = dict(sorted(orders.items()))
    found = check_orders(orders, conditions=conditions, seed=seed)
    return SurveyOrders(Path(path).name, found, without, len(others))
