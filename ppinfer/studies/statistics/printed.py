"""Numbers as papers print them: rounded, cut off, or another number altogether."""

from __future__ import annotations

from decimal import ROUND_DOWN, Context, Decimal, InvalidOperation
from typing import Literal

from ppinfer.errors import LogError

Printed = Literal["both", "rounded", "truncated", "neither"]

# what the same computation gives elsewhere may differ in the last digits of a float
_SAME = Context(prec=12)


def as_printed(value: float, text: str) -> Printed:
    """Say how a printed number comes from a computed one.

    Parameters
    ----------
    value
        What was computed.
    text
        What is printed: a decimal number (``"4.0"``, ``".02"``), its digits counted; or a bound (``"< .01"``), which is
        ``"both"`` where it holds and ``"neither"`` where it does not.

    Returns
    -------
    str
        ``"both"`` where rounding and cutting off give what is printed, else which of them does, or ``"neither"``. A
        value halfway may be rounded either way.

    Raises
    ------
    LogError
        If the text is no decimal number, or the value is not finite.

    Examples
    --------
    >>> as_printed(4.0952, "4.0"), as_printed(2.1905, "2.2"), as_printed(3.619, "3.6"), as_printed(2.3, "2.2")
    ('truncated', 'rounded', 'both', 'neither')
    >>> as_printed(0.0079, "< .01")
    'both'
    """
    bound = text.strip().startswith("<")
    try:
        printed = Decimal(text.strip().removeprefix("<").strip())
    except InvalidOperation:
        printed = Decimal("NaN")
    computed = Decimal(value)
    if not printed.is_finite() or not computed.is_finite():
        raise LogError(f"cannot compare {value} with the printed {text!r}; expected finite decimal numbers")
    computed = _SAME.create_decimal(computed)
    if bound:
        return "both" if computed < printed else "neither"
    unit = Decimal(1).scaleb(int(printed.as_tuple().exponent))
    rounded = 2 * abs(computed - printed) <= unit
    truncated = computed.quantize(unit, rounding=ROUND_DOWN) == printed
    if rounded and truncated:
        return "both"
    return "rounded" if rounded else "truncated" if truncated else "neither"
