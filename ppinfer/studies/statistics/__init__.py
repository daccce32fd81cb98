"""Statistics of a study: repeated-measures analyses of variance, post-hoc tests, and their Bayesian counterpart."""

from ppinfer.studies.statistics.analysis import Analysis, analyse
from ppinfer.studies.statistics.anova import Effect, repeated_measures_anova
from ppinfer.studies.statistics.bayes_factors import log_bayes_factor
from ppinfer.studies.statistics.measures import RepeatedMeasures
from ppinfer.studies.statistics.posterior_differences import credible_interval
from ppinfer.studies.statistics.posthoc import PairwiseTest, pairwise_tests
from ppinfer.studies.statistics.printed import as_printed
from ppinfer.studies.statistics.reading import read_measures
from ppinfer.studies.statistics.sphericity import Sphericity, sphericity

__all__ = [
    "Analysis",
    "Effect",
    "PairwiseTest",
    "RepeatedMeasures",
    "Sphericity",
    "analyse",
    "as_printed",
    "credible_interval",
    "log_bayes_factor",
    "pairwise_tests",
    "read_measures",
    "repeated_measures_anova",
    "sphericity",
]
