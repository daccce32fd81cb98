"""Table V of arXiv 2311.11893 (the second paper), from the answers themselves.

The paper's appendix: one-way repeated-measures ANOVA of the robot on every question, Bonferroni post-hoc tests.
"""

import os
from pathlib import Path

import pytest

from ppinfer.studies.statistics import analyse, as_printed, read_measures

ANSWERS = Path(os.environ.get("PPINFER_DATA", "nowhere")) / "reaching-study" / "likert.csv"
pytestmark = pytest.mark.skipif(
    not ANSWERS.exists(),
    reason="the answers are not here: set PPINFER_DATA to the folder that has reaching-study/",
)

ROBOTS = {"naive": "baseline", "reactive": "baseline_belief", "proactive": "cbp"}
# item: means of naive, reactive, proactive; F(2, 40); p, all as printed
PRINTED = {
    "accounted_for": (("2.1", "4.0", "3.7"), "12.4", "< 0.01"),
    "often_change": (("3.7", "1.7", "2.7"), "18.5", "< 0.01"),
    "many_points": (("3.6", "4.1", "3.0"), "4.0", "0.02"),
    "good_influence": (("3.0", "2.6", "3.2"), "1.8", "0.18"),
    "bad_influence": (("3.3", "1.8", "2.5"), "10.0", "< 0.01"),
    "easy_to_collaborate": (("3.3", "4.1", "3.4"), "2.9", "0.06"),
    "picked_best": (("3.2", "4.0", "2.7"), "8.1", "< 0.01"),
    "hindered_performance": (("2.8", "2.2", "3.0"), "2.6", "0.08"),
}
# "participants rated ... more with the reactive robot than the proactive robot (p < 0.01)" and so on
CLAIMS = {
    ("many_points", "reactive", "proactive"): "corrected: no, uncorrected: yes",
    ("bad_influence", "naive", "reactive"): "yes",
    ("picked_best", "reactive", "proactive"): "yes",
}


@pytest.fixture(scope="module")
def analysis():
    measures = read_measures(ANSWERS, list(PRINTED), within=["robot_type"], subject="user_id")
    return analyse(measures, posthoc="bonferroni")


@pytest.fixture(scope="module")
def effects(analysis):
    return {effect.dv: effect for effect in analysis.anova}


@pytest.fixture(scope="module")
def pairs(analysis):
    names = {level: robot for robot, level in ROBOTS.items()}
    return {(test.dv, names[test.a], names[test.b]): test for test in analysis.posthoc}


def test_all_eight_f_values_come_out_as_printed_rounded(effects):
    assert {(effect.df1, effect.df2, effect.subjects) for effect in effects.values()} == {(2, 40, 21)}
    for item, (_, printed, _) in PRINTED.items():
        assert f"{effects[item].F:.1f}" == printed
        assert as_printed(effects[item].F, printed) in ("both", "rounded")
    # these four are not what cutting off would give, so F values were rounded
    cut = {
        item for item, (_, printed, _) in PRINTED.items() if as_printed(effects[item].F, printed) == "rounded"
    }
    assert cut == {"often_change", "good_influence"}


def test_means_come_out_but_most_are_cut_off_and_one_is_rounded(effects):
    how = {}
    for item, (printed, _, _) in PRINTED.items():
        means = {mean["level"]: mean["mean"] for mean in effects[item].means}
        for robot, text in zip(ROBOTS, printed, strict=True):
            how[item, robot] = as_printed(means[ROBOTS[robot]], text)
    assert "neither" not in how.values()
    assert {cell for cell, told in how.items() if told == "rounded"} == {("hindered_performance", "reactive")}
    assert {cell for cell, told in how.items() if told == "truncated"} == {
        ("accounted_for", "reactive"),
        ("often_change", "reactive"),
        ("often_change", "proactive"),
        ("good_influence", "naive"),
        ("bad_influence", "reactive"),
        ("easy_to_collaborate", "naive"),
        ("picked_best", "naive"),
        ("picked_best", "proactive"),
    }


def test_p_values_come_out_cut_off_and_not_corrected_for_sphericity(effects):
    told = {item: as_printed(effects[item].p, printed) for item, (_, _, printed) in PRINTED.items()}
    assert told == {
        "accounted_for": "both",
        "often_change": "both",
        "many_points": "truncated",
        "good_influence": "truncated",
        "bad_influence": "both",
        "easy_to_collaborate": "truncated",
        "picked_best": "both",
        "hindered_performance": "truncated",
    }
    # the correction would not have changed what is significant
    assert all((effect.p < 0.05) == (effect.p_gg < 0.05) for effect in effects.values())
    assert all(effect.sphericity.mauchly_p > 0.05 for effect in effects.values())


@pytest.mark.parametrize("claim", CLAIMS)
def test_post_hoc_claims_hold_below_one_percent_but_for_one_that_holds_only_uncorrected(pairs, claim):
    test = pairs[claim]
    assert test.p < 0.01
    if CLAIMS[claim] == "yes":
        assert test.p_bonferroni < 0.01
    else:
        assert test.p == pytest.approx(0.0079, abs=0.00005)
        assert test.p_bonferroni == pytest.approx(0.0236, abs=0.00005)
        assert test.p_holm == test.p_bonferroni


def test_other_things_said_of_the_answers(effects, pairs):
    # significant: accounted, changed, points, influencing negatively, picking the best goals; and no others
    significant = {item for item, effect in effects.items() if effect.p < 0.05}
    assert significant == {"accounted_for", "often_change", "many_points", "bad_influence", "picked_best"}
    # "both the CBP and reactive robots were not making them choose worse goals": means below the middle, 3
    means = {mean["level"]: mean["mean"] for mean in effects["bad_influence"].means}
    assert max(means["baseline_belief"], means["cbp"]) < 3 < means["baseline"]
    # but that the naive robot was worse in this than the proactive one holds only uncorrected
    naive = pairs["bad_influence", "naive", "proactive"]
    assert naive.p < 0.05 < naive.p_bonferroni
