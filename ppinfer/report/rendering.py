"""Pages from templates: whatever comes from a log is text, never markup."""

from __future__ import annotations

import math
from functools import cache
from typing import TYPE_CHECKING

from ppinfer.errors import printable
from ppinfer.report.folder import GENERATOR

if TYPE_CHECKING:
    from jinja2 import Environment
    from markupsafe import Markup


def render(template: str, **context: object) -> Markup:
    """Return the page, or the part of one, that a template makes of these things.

    Text among these things is escaped; only what this function made itself is markup.
    """
    from markupsafe import Markup

    return Markup(_environment().get_template(template).render(generator=GENERATOR, **context))


@cache
def _environment() -> Environment:
    import jinja2

    # everything from a log is text: escaping is never off
    environment = jinja2.Environment(
        loader=jinja2.PackageLoader("ppinfer.report", "templates"),
        autoescape=True,
        undefined=jinja2.StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
        # what would turn the direction of writing, or a terminal that shows the page, is shown itself
        finalize=lambda value: printable(value, keep="\n") if type(value) is str else value,
    )
    for shown in (number, figures, error_decimals, p_value, bayes_factor):
        environment.filters[shown.__name__] = shown
    return environment


def number(value: float | None, digits: int = 3) -> str:
    """Return a number as a page shows it; NaN (or None) is one that does not exist, such as an error of one person.

    Examples
    --------
    >>> number(-0.25, 2), number(float("nan"))
    ('−0.25', '–')
    """
    return "–" if value is None or value != value else f"{value:.{digits}f}".replace("-", "−")


def figures(value: float | None, digits: int = 4) -> str:
    """Return a number of any size with so many significant figures.

    Examples
    --------
    >>> figures(1234.5678), figures(-0.012345), figures(0.0), figures(None)
    ('1235', '−0.01235', '0', '–')
    """
    if value is None or value != value:
        return "–"
    return f"{value:.{max(digits, len(f'{abs(value):.0f}')) if abs(value) < 1e9 else digits}g}".replace(
        "-", "−"
    )


def error_decimals(mean: float | None, sem: float | None) -> int:
    """Return to how many decimals a mean and its standard error are shown: two figures of the error.

    Without an error, and where rounding alone leaves one: four figures of the mean.

    Examples
    --------
    >>> error_decimals(19.0909, 0.3989), error_decimals(0.3479, 0.0094), error_decimals(12.0, 31.0)
    (2, 4, 0)
    >>> error_decimals(0.7251, float("nan")), error_decimals(24.9, 0.0)
    (4, 2)
    """
    if mean is None or not math.isfinite(mean):
        return 0
    if sem is None or not math.isfinite(sem) or abs(sem) <= 1e-9 * abs(mean):
        return min(6, max(0, 3 - math.floor(math.log10(abs(mean))))) if mean else 0
    return min(6, max(0, 1 - math.floor(math.log10(abs(sem)))))


def p_value(value: float | None) -> str:
    """Return a p-value: three digits, and nothing smaller than .001.

    Examples
    --------
    >>> p_value(0.0312), p_value(1e-9), p_value(1.0)
    ('.031', '< .001', '1')
    """
    if value is None or value != value:
        return "–"
    if value < 0.001:
        return "< .001"
    return "1" if value > 0.9995 else f"{value:.3f}".removeprefix("0")


def bayes_factor(log_value: float | None) -> str:
    """Return a Bayes factor, given its natural logarithm.

    Examples
    --------
    >>> bayes_factor(0.0), bayes_factor(-2.0), bayes_factor(40.0)
    ('1.00', '0.135', '2.4e+17')
    """
    if log_value is None or log_value != log_value:
        return "–"
    if abs(log_value) > 700:
        return f"{'<' if log_value < 0 else '>'} 1e{'−' * (log_value < 0)}304"
    value = math.exp(log_value)
    return f"{value:.3g}" if 0.001 <= value < 1 else f"{value:.2f}" if 1 <= value < 1000 else f"{value:.1e}"
