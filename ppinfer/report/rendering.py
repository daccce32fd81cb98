"""Pages from templates: whatever comes from a log is text, never markup."""

from __future__ import annotations

from typing import TYPE_CHECKING

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


def _environment() -> Environment:
    import jinja2

    # everything from a log is text: escaping is never off
    environment = jinja2.Environment(
        loader=jinja2.PackageLoader("ppinfer.report", "templates"),
        autoescape=True,
        undefined=jinja2.StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    environment.filters["number"] = number
    return environment


def number(value: float | None, digits: int = 3) -> str:
    """Return a number as a page shows it; NaN (or None) is one that does not exist, such as an error of one person.

    Examples
    --------
    >>> number(-0.25, 2), number(float("nan"))
    ('−0.25', '–')
    """
    return "–" if value is None or value != value else f"{value:.{digits}f}".replace("-", "−")
