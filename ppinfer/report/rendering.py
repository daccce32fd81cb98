"""Pages from templates: whatever comes from a log is text, never markup."""

from __future__ import annotations

from ppinfer.report.folder import GENERATOR


def render(template: str, **context: object) -> str:
    """Return the page that a template makes of these things."""
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
    return environment.get_template(template).render(generator=GENERATOR, **context)


def number(value: float, digits: int = 3) -> str:
    """Return a number as a page shows it; NaN is a standard error that does not exist.

    Examples
    --------
    >>> number(-0.25, 2), number(float("nan"))
    ('−0.25', '–')
    """
    return "–" if value != value else f"{value:.{digits}f}".replace("-", "−")
