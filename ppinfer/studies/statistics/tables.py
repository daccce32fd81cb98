"""An analysis as rows of text, for a terminal or a page."""

from __future__ import annotations

import math
from collections.abc import Iterator

from ppinfer.studies.statistics.analysis import Analysis
from ppinfer.studies.statistics.anova import Effect

EFFECT_COLUMNS = (
    "variable", "effect", "F", "p", "Mauchly p", "epsilon", "p (GG)", "partial eta²", "BF10", "Friedman p", "n",
)  # fmt: skip
PAIR_COLUMNS = ("variable", "factor", "pair", "difference", "t", "p", "p adjusted", "d_z", "BF10")
_WIDE = 6


def effect_rows(analysis: Analysis) -> list[tuple[str, ...]]:
    """Return a row for each effect, under `EFFECT_COLUMNS`.

    Examples
    --------
    >>> effect_rows(Analysis((), ()))
    []
    """
    return [
        (
            effect.dv,
            effect.effect,
            f"F({effect.df1}, {effect.df2}) = {number(effect.F, 2)}",
            p_text(effect.p),
            p_text(effect.sphericity.mauchly_p),
            number(effect.sphericity.epsilon, 3),
            p_text(effect.p_gg),
            number(effect.partial_eta_squared, 3),
            bayes_factor_text(effect.log_bf10),
            p_text(effect.friedman_p),
            str(effect.subjects),
        )
        for effect in analysis.anova
    ]


def mean_tables(analysis: Analysis) -> Iterator[tuple[str, tuple[str, ...], list[tuple[str, ...]]]]:
    """Yield for each effect its name, the columns and the rows of a table of means ± standard errors.

    Variables whose levels are the same share a table with a column a level; many levels become rows.

    Examples
    --------
    >>> list(mean_tables(Analysis((), ())))
    []
    """
    groups: dict[tuple[str, tuple[str, ...]], list[Effect]] = {}
    for effect in analysis.anova:
        levels = tuple(str(mean["level"]) for mean in effect.means)
        groups.setdefault((effect.effect, levels), []).append(effect)
    for (name, levels), effects in groups.items():
        cells = [[f"{mean['mean']:.3f} ± {mean['sem']:.3f}" for mean in effect.means] for effect in effects]
        rows: list[tuple[str, ...]]
        if len(levels) <= _WIDE:
            rows = [(effect.dv, *of_dv) for effect, of_dv in zip(effects, cells, strict=True)]
            yield name, ("variable", *levels), rows
        else:
            rows = [
                (effect.dv, level, cell)
                for effect, of_dv in zip(effects, cells, strict=True)
                for level, cell in zip(levels, of_dv, strict=True)
            ]
            yield name, ("variable", name, "mean"), rows


def pair_rows(analysis: Analysis) -> list[tuple[str, ...]]:
    """Return a row for each pairwise test, under `PAIR_COLUMNS`.

    Examples
    --------
    >>> pair_rows(Analysis((), ()))
    []
    """
    return [
        (
            test.dv,
            test.effect,
            f"{test.a} - {test.b}",
            f"{test.mean_difference:+.3f} [{number(test.low, 3)}, {number(test.high, 3)}]",
            f"t({test.df}) = {number(test.t, 2)}",
            p_text(test.p),
            p_text(test.p_adjusted),
            number(test.effect_size, 2),
            bayes_factor_text(test.log_bf10),
        )
        for test in analysis.posthoc
    ]


def number(value: float, digits: int) -> str:
    """Return a number with some digits after the point; a dash for what is undefined.

    Examples
    --------
    >>> number(3.7938, 2), number(float("nan"), 2), number(float("inf"), 2)
    ('3.79', '-', 'inf')
    """
    return "-" if math.isnan(value) else f"{value:.{digits}f}"


def p_text(p: float) -> str:
    """Return a p-value; what would be printed as zero is told as a bound.

    Examples
    --------
    >>> p_text(0.02569), p_text(3e-7), p_text(float("nan"))
    ('0.0257', '< 0.0001', '-')
    """
    return "< 0.0001" if p < 0.0001 else number(p, 4)


def bayes_factor_text(log_value: float) -> str:
    """Return a Bayes factor given as a logarithm, however large.

    Examples
    --------
    >>> bayes_factor_text(2.85), bayes_factor_text(7.42), bayes_factor_text(1000.0), bayes_factor_text(float("nan"))
    ('17.3', '1669', '1e434', '-')
    """
    if not math.isfinite(log_value):
        return "-" if math.isnan(log_value) else "inf"
    if abs(log_value) < math.log(1e5):
        value = math.exp(log_value)
        return f"{value:.0f}" if value >= 100 else f"{value:.3g}"
    return f"1e{round(log_value / math.log(10))}"
