"""Repeated-measures analysis of variance: F by statsmodels; sphericity, effect sizes and Bayes factors beside it."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from ppinfer.studies.statistics.bayes_factors import PRIOR_SCALE, check_prior_scale, log_bayes_factor
from ppinfer.studies.statistics.contrasts import effect_scores, effects_of, marginal_values
from ppinfer.studies.statistics.measures import RepeatedMeasures
from ppinfer.studies.statistics.sphericity import Sphericity, sphericity

NAN = float("nan")
# AnovaRM regresses on dummies for every subject and cell: cubic in the number of values (0.1 s at 1000)
_REGRESSED = 1000


@dataclass(frozen=True)
class Effect:
    """One effect of a within-subject design on one dependent variable.

    Parameters
    ----------
    dv, effect
        The dependent variable; the factor, or factors joined by ``:`` for an interaction.
    F, df1, df2, p
        The F test, not corrected for sphericity. F is inf (and p 0) if subjects do not differ at all in how they differ
        between levels, NaN (and so p) if nothing differs.
    sphericity
        Mauchly's test and the epsilons.
    p_gg, p_hf
        p-values with both degrees of freedom multiplied by Greenhouse and Geisser's, Huynh and Feldt's epsilon.
    partial_eta_squared
        SS effect / (SS effect + SS error).
    generalized_eta_squared
        SS effect / (SS effect + all SS between subjects and of errors) (Olejnik & Algina 2003; Bakeman 2005).
    log_bf10
        Natural logarithm of the JZS Bayes factor for an effect over none (`bayes_factors`).
    friedman_chi2, friedman_p, kendall_w
        Friedman's test on ranks and its effect size, for a single factor of 3 levels or more; NaN elsewhere.
    subjects
        How many subjects the effect was computed from.
    means
        For each cell of the effect its levels, mean, standard deviation and standard error over subjects.
    warnings
        What a reader of these numbers has to know.

    Examples
    --------
    >>> Effect("score", "robot", 4.0, 2, 40, 0.026, Sphericity(0.9, 1.0), 0.03, 0.026, 0.17, 0.1).log_bf10
    nan
    """

    dv: str
    effect: str
    F: float
    df1: int
    df2: int
    p: float
    sphericity: Sphericity
    p_gg: float
    p_hf: float
    partial_eta_squared: float
    generalized_eta_squared: float
    log_bf10: float = NAN
    friedman_chi2: float = NAN
    friedman_p: float = NAN
    kendall_w: float = NAN
    subjects: int = 0
    means: tuple[Mapping[str, object], ...] = ()
    warnings: tuple[str, ...] = ()

    def to_json(self) -> dict[str, object]:
        """Return the row that ``ppinfer anova --json`` prints; what is not finite is None."""
        row = {
            "dv": self.dv,
            "effect": self.effect,
            "F": self.F,
            "df1": self.df1,
            "df2": self.df2,
            "p": self.p,
            "epsilon": self.sphericity.epsilon,
            "p_gg": self.p_gg,
            "effect_size": self.partial_eta_squared,
            "generalized_effect_size": self.generalized_eta_squared,
            "epsilon_hf": self.sphericity.epsilon_hf,
            "p_hf": self.p_hf,
            "mauchly_w": self.sphericity.mauchly_w,
            "mauchly_chi2": self.sphericity.mauchly_chi2,
            "mauchly_df": self.sphericity.mauchly_df or None,
            "mauchly_p": self.sphericity.mauchly_p,
            "bf10": exponential(self.log_bf10),
            "log_bf10": self.log_bf10,
            "friedman_chi2": self.friedman_chi2,
            "friedman_p": self.friedman_p,
            "kendall_w": self.kendall_w,
            "subjects": self.subjects,
            "means": [dict(mean) for mean in self.means],
        }
        return {key: finite_or_none(value) for key, value in row.items()}


def repeated_measures_anova(
    measures: RepeatedMeasures, *, prior_scale: float = PRIOR_SCALE
) -> tuple[Effect, ...]:
    """Analyse every effect of a complete within-subject design: main effects first, then interactions.

    1. Subjects' own means are taken off (no effect within subjects depends on them), and the scale is set to 1.
    2. F, degrees of freedom and p are those of statsmodels' ``AnovaRM`` (of the same sums of squares directly where its
       regression would have more than 1000 values).
    3. Each subject's scores on the effect's orthonormal contrasts give the sums of squares of the effect sizes,
       the epsilons, and Mauchly's test.

    Parameters
    ----------
    measures
        Without missing cells (`RepeatedMeasures.complete`).
    prior_scale
        The scale of the Bayes factors' prior.

    Raises
    ------
    FaultyLogError
        If cells are missing.
    LogError
        If there are fewer than 2 subjects, or than 2 levels of a factor.

    Examples
    --------
    Field's data: how long eight people take to retch after eating four animals; F(3, 21) = 3.79.

    >>> seconds = np.array([[8, 7, 1, 6], [9, 5, 2, 5], [6, 2, 3, 8], [5, 3, 1, 9],
    ...                     [8, 4, 5, 8], [7, 5, 6, 7], [10, 2, 7, 2], [12, 6, 8, 1.0]])
    >>> animals = ("stick insect", "kangaroo testicle", "fish eye", "witchetty grub")
    >>> subjects = tuple("12345678")
    >>> effect, = repeated_measures_anova(RepeatedMeasures("s", seconds, subjects, ("animal",), (animals,)))
    >>> round(effect.F, 2), effect.df1, effect.df2, round(effect.p, 3), round(effect.p_gg, 3)
    (3.79, 3, 21, 0.026, 0.063)
    """
    check_prior_scale(prior_scale)
    measures = measures.complete()
    n = len(measures.subjects)
    flat = measures.values.reshape(n, -1)
    own = flat.mean(axis=1, keepdims=True)
    centred = (flat - own).reshape(measures.values.shape)
    size = float(np.abs(centred).max()) or 1.0
    centred = centred / size
    # what rounding alone leaves of a score that is zero in exact arithmetic
    noise = 16 * np.finfo(float).eps * flat.shape[1] * float(np.abs(measures.values).max()) / size
    effects = list(effects_of(len(measures.factors)))
    scores = [effect_scores(centred, effect) for effect in effects]
    sums = [_sums_of_squares(each, noise) for each in scores]
    between = flat.shape[1] * float((((own - own.mean()) / size) ** 2).sum())
    unexplained = between + sum(error for _, error in sums)
    tests = None
    if flat.size <= _REGRESSED and all(error > 0 for _, error in sums):
        tests = _statsmodels_f(centred, effects)
    rows = []
    for index, (effect, score, (ss, error)) in enumerate(zip(effects, scores, sums, strict=True)):
        df1 = score.shape[1]
        df2 = df1 * (n - 1)
        F = tests[index] if tests is not None and ss > 0 else _ratio(ss / df1, error / df2)
        judged = sphericity(score) if error > 0 else Sphericity(NAN, NAN)
        rows.append(
            Effect(
                dv=measures.dv,
                effect=":".join(measures.factors[factor] for factor in effect),
                F=F,
                df1=df1,
                df2=df2,
                p=_tail(F, df1, df2, 1.0),
                sphericity=judged,
                p_gg=_tail(F, df1, df2, judged.epsilon),
                p_hf=_tail(F, df1, df2, judged.epsilon_hf),
                partial_eta_squared=_ratio(ss, ss + error),
                generalized_eta_squared=_ratio(ss, ss + unexplained),
                log_bf10=log_bayes_factor(F, df1, df2, subjects=n, prior_scale=prior_scale),
                **_friedman(measures),
                subjects=n,
                means=_means(measures, effect),
                warnings=_warnings(measures, effect, F, df1, judged),
            )
        )
    return tuple(rows)


def _sums_of_squares(scores: Float[np.ndarray, "subject contrast"], noise: float) -> tuple[float, float]:
    """Return the sums of squares of effect and error, exactly zero where they are no more than rounding."""
    mean = scores.mean(axis=0)
    effect, error = len(scores) * float((mean**2).sum()), float(((scores - mean) ** 2).sum())
    negligible = scores.size * noise**2
    return (effect if effect > negligible else 0.0), (error if error > negligible else 0.0)


def _statsmodels_f(
    values: Float[np.ndarray, "subject *level"], effects: Sequence[tuple[int, ...]]
) -> list[float]:
    """Return each effect's F by ``AnovaRM``, under names of our own: users' may be no names in a formula."""
    import pandas as pd
    from statsmodels.stats.anova import AnovaRM

    subject, *levels = np.indices(values.shape).reshape(values.ndim, -1)
    factors = {f"f{number}": codes for number, codes in enumerate(levels)}
    table = pd.DataFrame({"y": values.ravel(), "subject": subject, **factors})
    fitted = AnovaRM(table, "y", "subject", within=list(factors)).fit().anova_table
    return [float(fitted.loc[":".join(f"f{factor}" for factor in effect), "F Value"]) for effect in effects]


def _friedman(measures: RepeatedMeasures) -> dict[str, float]:
    if len(measures.factors) > 1 or len(measures.levels[0]) < 3:
        return {}
    from scipy.stats import friedmanchisquare

    n, k = measures.values.shape
    if (measures.values == measures.values[:, :1]).all():
        return {}
    chi2, p = friedmanchisquare(*measures.values.T)
    return {"friedman_chi2": float(chi2), "friedman_p": float(p), "kendall_w": float(chi2) / (n * (k - 1))}


def _means(measures: RepeatedMeasures, effect: tuple[int, ...]) -> tuple[Mapping[str, object], ...]:
    cells, values = marginal_values(measures, effect)
    spread = values.std(axis=0, ddof=1)
    return tuple(
        {
            "level": " : ".join(cell),
            "levels": {measures.factors[factor]: name for factor, name in zip(effect, cell, strict=True)},
            "mean": float(mean),
            "sd": float(sd),
            "sem": float(sd / math.sqrt(len(values))),
        }
        for cell, mean, sd in zip(cells, values.mean(axis=0), spread, strict=True)
    )


def _warnings(
    measures: RepeatedMeasures, effect: tuple[int, ...], F: float, df1: int, judged: Sphericity
) -> tuple[str, ...]:
    name = ":".join(measures.factors[factor] for factor in effect)
    where = f"{measures.dv!r}, effect {name!r}"
    if math.isnan(F):
        return (f"{where}: no subject differs between levels; F and p are undefined",)
    if math.isinf(F):
        return (f"{where}: every subject differs between levels by exactly the same; F is infinite, p is 0",)
    n = len(measures.subjects)
    if df1 > 1 and n - 1 < df1:
        return (
            f"{where}: {n} subjects are too few for Mauchly's test with {df1} contrasts (at least {df1 + 1} are "
            "needed); epsilon is a rough estimate",
        )
    if judged.mauchly_w == 0:
        return (f"{where}: some contrast does not vary at all over subjects; Mauchly's W is 0",)
    return ()


def _ratio(over: float, under: float) -> float:
    if under > 0:
        return over / under
    return math.inf if over > 0 else NAN


def _tail(F: float, df1: int, df2: int, epsilon: float) -> float:
    from scipy.stats import f

    if math.isinf(F):
        return 0.0
    return float(f.sf(F, df1 * epsilon, df2 * epsilon))


def exponential(log_value: float) -> float:
    """Return exp of a logarithm, inf where that is more than a float holds.

    Examples
    --------
    >>> exponential(0.0), exponential(1e6)
    (1.0, inf)
    """
    return math.exp(log_value) if not log_value > 709.7 else math.inf


def finite_or_none(value: object) -> object:
    """Return None for a float that JSON has no word for, anything else as it is.

    Examples
    --------
    >>> finite_or_none(float("inf")), finite_or_none(2.0)
    (None, 2.0)
    """
    return None if isinstance(value, float) and not math.isfinite(value) else value
