"""Post-hoc tests: every pair of levels by a paired t-test, adjusted for how many pairs there are."""

from __future__ import annotations

import itertools
from dataclasses import asdict, dataclass
from typing import Literal, get_args

import numpy as np

from ppinfer.studies.statistics.anova import NAN, exponential, finite_or_none
from ppinfer.studies.statistics.bayes_factors import PRIOR_SCALE, check_prior_scale, log_bayes_factor
from ppinfer.studies.statistics.contrasts import marginal_values
from ppinfer.studies.statistics.measures import RepeatedMeasures, check_choice
from ppinfer.studies.statistics.posterior_differences import credible_interval
from ppinfer.studies.statistics.student import student_tests

Adjustment = Literal["bonferroni", "holm"]
CONFIDENCE = 0.95


@dataclass(frozen=True)
class PairwiseTest:
    """The paired t-test of two levels of one factor, other factors averaged.

    Parameters
    ----------
    dv, effect
        The dependent variable and the factor.
    a, b
        The two levels; differences are a - b.
    mean_difference
        Over subjects, in the variable's units.
    low, high
        The 95 % confidence interval of this one mean difference (not simultaneous).
    low_simultaneous, high_simultaneous
        Intervals that hold for all pairs of the effect at once with at least 95 % (Bonferroni).
    t, df, p
        The paired t-test, two-sided, p not adjusted; t is infinite (and p 0) if all differences are the same, NaN if
        they are all zero.
    p_bonferroni, p_holm
        p adjusted for the pairs of this effect on this dependent variable.
    adjustment, p_adjusted
        The adjustment that was asked for, and its p.
    effect_size
        Cohen's d_z: mean difference over the standard deviation of differences.
    log_bf10
        Natural logarithm of the JZS Bayes factor, not adjusted for the number of pairs.
    credible_low, credible_high
        The 95 % credible interval of the mean difference, given that there is one (`credible_interval`).

    Examples
    --------
    >>> PairwiseTest("score", "robot", "new", "old", mean_difference=1.5).t
    nan
    """

    dv: str
    effect: str
    a: str
    b: str
    mean_difference: float = NAN
    low: float = NAN
    high: float = NAN
    low_simultaneous: float = NAN
    high_simultaneous: float = NAN
    t: float = NAN
    df: int = 0
    p: float = NAN
    p_bonferroni: float = NAN
    p_holm: float = NAN
    p_adjusted: float = NAN
    adjustment: str = "bonferroni"
    effect_size: float = NAN
    log_bf10: float = NAN
    credible_low: float = NAN
    credible_high: float = NAN

    def to_json(self) -> dict[str, object]:
        """Return the row that ``ppinfer anova --json`` prints; what is not finite is None."""
        row = {**asdict(self), "bf10": exponential(self.log_bf10)}
        return {key: finite_or_none(value) for key, value in row.items()}


def pairwise_tests(
    measures: RepeatedMeasures, adjust: Adjustment = "bonferroni", *, prior_scale: float = PRIOR_SCALE
) -> tuple[PairwiseTest, ...]:
    """Compare all pairs of levels of each factor.

    Parameters
    ----------
    measures
        Without missing cells (`RepeatedMeasures.complete`).
    adjust
        Which adjustment ``p_adjusted`` has; both are always computed. A family is the pairs of one factor on one
        dependent variable.
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
    >>> hours = np.array([[0.7, 1.9], [-1.6, 0.8], [-0.2, 1.1], [-1.2, 0.1], [-0.1, -0.1],
    ...                   [3.4, 4.4], [3.7, 5.5], [0.8, 1.6], [0.0, 4.6], [2.0, 3.4]])
    >>> test, = pairwise_tests(RepeatedMeasures("h", hours, tuple("abcdefghij"), ("drug",), (("1", "2"),)))
    >>> round(test.t, 4), test.df, round(test.p, 6)
    (-4.0621, 9, 0.002833)
    """
    from statsmodels.stats.multitest import multipletests

    check_choice("the adjustment", adjust, get_args(Adjustment))
    check_prior_scale(prior_scale)
    measures = measures.complete()
    n = len(measures.subjects)
    tests = []
    for number, factor in enumerate(measures.factors):
        cells, values = marginal_values(measures, (number,))
        pairs = list(itertools.combinations(range(len(cells)), 2))
        first, second = (np.array(side) for side in zip(*pairs, strict=True))
        differences = values[:, first] - values[:, second]
        noise = 16 * np.finfo(float).eps * np.abs(values).max()
        found = student_tests(differences, noise=noise)
        with np.errstate(divide="ignore", invalid="ignore"):
            d_z = found.mean / found.sd
        # what never differs is no evidence: it counts as a pair, with a p of 1
        known = np.where(np.isnan(found.p), 1.0, found.p)
        adjusted = {name: multipletests(known, method=name)[1] for name in ("bonferroni", "holm")}
        half = found.half_width(CONFIDENCE)
        half_all = found.half_width(CONFIDENCE, together=len(pairs))
        ends = {
            "low": found.mean - half,
            "high": found.mean + half,
            "low_simultaneous": found.mean - half_all,
            "high_simultaneous": found.mean + half_all,
        }
        for index, (a, b) in enumerate(pairs):
            undefined = bool(np.isnan(found.t[index]))
            credible = (NAN, NAN)
            if found.sd[index] > 0:
                credible = credible_interval(differences[:, index], level=CONFIDENCE, prior_scale=prior_scale)
            of_pair = {name: NAN if undefined else float(ps[index]) for name, ps in adjusted.items()}
            tests.append(
                PairwiseTest(
                    dv=measures.dv,
                    effect=factor,
                    a=cells[a][0],
                    b=cells[b][0],
                    mean_difference=float(found.mean[index]),
                    **{name: float(of_pairs[index]) for name, of_pairs in ends.items()},
                    t=float(found.t[index]),
                    df=n - 1,
                    p=float(found.p[index]),
                    p_bonferroni=of_pair["bonferroni"],
                    p_holm=of_pair["holm"],
                    p_adjusted=of_pair[adjust],
                    adjustment=adjust,
                    effect_size=float(d_z[index]),
                    log_bf10=log_bayes_factor(
                        float(found.t[index] ** 2), 1, n - 1, subjects=n, prior_scale=prior_scale
                    ),
                    credible_low=credible[0],
                    credible_high=credible[1],
                )
            )
    return tuple(tests)
