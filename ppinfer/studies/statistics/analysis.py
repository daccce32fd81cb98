"""The analysis of some dependent variables: what ``ppinfer anova`` prints, and what a report shows."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from ppinfer.errors import LogError
from ppinfer.studies.statistics.anova import Effect, repeated_measures_anova
from ppinfer.studies.statistics.bayes_factors import PRIOR_SCALE
from ppinfer.studies.statistics.measures import Missing, RepeatedMeasures
from ppinfer.studies.statistics.missing_cells import refuse_missing
from ppinfer.studies.statistics.posthoc import Adjustment, PairwiseTest, pairwise_tests


@dataclass(frozen=True)
class Analysis:
    """Effects and pairwise tests of one or several dependent variables.

    Parameters
    ----------
    anova
        Every effect of every dependent variable.
    posthoc
        Every pairwise test; empty if none were asked for.
    measures
        What was analysed, after averaging and dropping.
    warnings
        What a reader of the numbers has to know: what was dropped or averaged, what is undefined.

    Examples
    --------
    >>> Analysis((), ()).to_json()
    {'anova': [], 'posthoc': []}
    """

    anova: tuple[Effect, ...]
    posthoc: tuple[PairwiseTest, ...]
    measures: tuple[RepeatedMeasures, ...] = ()
    warnings: tuple[str, ...] = ()

    def to_json(self) -> dict[str, list[dict[str, object]]]:
        """Return ``{"anova": [...], "posthoc": [...]}``; what is not finite is None."""
        return {
            "anova": [effect.to_json() for effect in self.anova],
            "posthoc": [test.to_json() for test in self.posthoc],
        }


def analyse(
    measures: Sequence[RepeatedMeasures],
    *,
    posthoc: Adjustment | None = None,
    missing: Missing = "refuse",
    prior_scale: float = PRIOR_SCALE,
) -> Analysis:
    """Run a repeated-measures ANOVA, and post-hoc tests if asked, on each dependent variable.

    Parameters
    ----------
    measures
        The dependent variables; each is analysed by itself (nothing is adjusted for their number).
    posthoc
        The adjustment of pairwise tests; None = no such tests.
    missing
        What to do about missing cells (`RepeatedMeasures.complete`).
    prior_scale
        The scale of the Bayes factors' prior.

    Raises
    ------
    FaultyLogError
        Naming every missing cell of every variable, if ``missing`` is ``"refuse"``.
    LogError
        If there is nothing to analyse, or too few subjects or levels.

    Examples
    --------
    >>> scores = RepeatedMeasures(
    ...     "score",
    ...     np.array([[3.0, 4.0, 1.0], [2.0, 4.0, 2.0], [1.0, 2.0, 2.0]]),
    ...     ("ann", "bob", "cy"),
    ...     ("robot",),
    ...     (("naive", "new", "old"),),
    ... )
    >>> analysis = analyse([scores], posthoc="holm")
    >>> len(analysis.anova), [(test.a, test.b) for test in analysis.posthoc]
    (1, [('naive', 'new'), ('naive', 'old'), ('new', 'old')])
    """
    if not measures:
        raise LogError("there is nothing to analyse; name at least one dependent variable")
    if missing == "refuse":
        refuse_missing(measures)
    complete = tuple(each.complete(missing) for each in measures)
    effects = tuple(
        effect for each in complete for effect in repeated_measures_anova(each, prior_scale=prior_scale)
    )
    tests: tuple[PairwiseTest, ...] = ()
    if posthoc is not None:
        tests = tuple(
            test for each in complete for test in pairwise_tests(each, posthoc, prior_scale=prior_scale)
        )
    warnings = [note for each in complete for note in each.notes]
    warnings += [warning for effect in effects for warning in effect.warnings]
    return Analysis(effects, tests, complete, tuple(dict.fromkeys(warnings)))
