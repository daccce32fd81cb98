import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ppinfer.errors import LogError
from ppinfer.studies.faults import FaultyLogError
from ppinfer.studies.statistics import RepeatedMeasures, analyse
from ppinfer.studies.statistics.measures import check_choice

GAPS = RepeatedMeasures(
    "score",
    np.array([[1.0, 2.0, 3.0], [2.0, math.nan, 4.0], [3.0, 5.0, math.nan], [2.0, 2.0, 5.0]]),
    ("ann", "bob", "cy", "di"),
    ("robot",),
    (("naive", "reactive", "proactive"),),
    source="study.csv",
)


def test_every_missing_cell_is_named_and_refused():
    with pytest.raises(FaultyLogError) as told:
        GAPS.complete()
    assert told.value.lines == [
        "study.csv: column 'score': subject 'bob' at robot 'reactive' has no value",
        "study.csv: column 'score': subject 'cy' at robot 'proactive' has no value",
    ]


def test_missing_cells_of_all_variables_are_named_at_once():
    other = RepeatedMeasures(
        "trust", GAPS.values.T.copy(), ("x", "y", "z"), ("robot",), (("a", "b", "c", "d"),)
    )
    with pytest.raises(FaultyLogError) as told:
        analyse([GAPS, other])
    assert told.value.counts == {"missing-cell": 4}


def test_subjects_or_levels_are_dropped_where_the_caller_chooses_and_that_is_said():
    people = GAPS.complete("drop-subjects")
    assert people.subjects == ("ann", "di")
    assert people.notes == ("'score': 2 of 4 subjects dropped for missing cells: 'bob', 'cy'",)
    with pytest.raises(
        LogError, match=r"too few levels: 1 .'naive'., expected at least 2 .'score': 2 of 3 levels"
    ):
        GAPS.complete("drop-levels")
    analysis = analyse([GAPS], missing="drop-subjects")
    assert analysis.warnings[0] == people.notes[0]
    assert analysis.anova[0].subjects == 2


def test_a_level_that_somebody_lacks_is_dropped_by_name():
    values = GAPS.values.copy()
    values[2, 2] = 1.0
    kept = RepeatedMeasures("score", values, GAPS.subjects, GAPS.factors, GAPS.levels).complete("drop-levels")
    assert kept.levels == (("naive", "proactive"),)
    assert kept.notes == ("'score': 1 of 3 levels of 'robot' dropped for missing cells: 'reactive'",)
    assert (kept.values == values[:, [0, 2]]).all()


def test_levels_of_several_factors_are_not_dropped():
    values = np.zeros((2, 2, 2))
    values[0, 0, 0] = math.nan
    measures = RepeatedMeasures("y", values, ("a", "b"), ("f", "g"), (("1", "2"), ("1", "2")))
    with pytest.raises(LogError, match="more than one way to drop levels"):
        measures.complete("drop-levels")
    with pytest.raises(
        LogError, match=r"number of subjects is 1, expected at least 2 \('y': 1 of 2 subjects"
    ):
        measures.complete("drop-subjects")


def test_repeated_cells_are_named_with_their_rows():
    columns = (np.arange(5.0), ["a", "a", "b", "b", "a"], {"x": ["1", "2", "1", "2", "1"]})
    with pytest.raises(FaultyLogError, match=r"subject 'a' at x '1' is there more than once \(rows 1, 5\)"):
        RepeatedMeasures.from_columns("y", *columns)
    with pytest.raises(FaultyLogError, match=r"study.csv: 1 fault: subject 'a' at x '1' .* \(lines 11, 15\)"):
        RepeatedMeasures.from_columns("y", *columns, lines=[11, 12, 13, 14, 15], source="study.csv")
    taken = RepeatedMeasures.from_columns("y", *columns, repeated="mean")
    assert taken.values.tolist() == [[2.0, 1.0], [2.0, 3.0]]
    assert taken.notes == ("'y': mean of several rows taken in 1 cells (up to 2 rows)",)


@given(st.permutations(range(12)))
def test_the_order_of_rows_changes_only_the_order_of_names(order):
    subjects, levels = np.divmod(np.arange(12), 3)
    values = np.arange(12.0) ** 2
    told = RepeatedMeasures.from_columns(
        "y",
        values[order],
        [f"s{subjects[row]}" for row in order],
        {"x": [f"l{levels[row]}" for row in order]},
    )
    for subject, row in zip(told.subjects, told.values, strict=True):
        for level, value in zip(told.levels[0], row, strict=True):
            assert value == (3 * int(subject[1:]) + int(level[1:])) ** 2


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"subjects": ("ann", "bob")}, "values of shape"),
        ({"subjects": ("ann", "bob", "ann", "di")}, "subject 'ann' is named 2 times"),
        ({"levels": (("a", "b", "b"),)}, "level of 'robot' 'b' is named 2 times"),
        ({"factors": ("robot", "round")}, "a name for each factor"),
        ({"values": np.full((4, 3), math.inf)}, "subject 'ann' at robot 'naive' is infinite"),
    ],
)
def test_what_does_not_fit_together_is_refused(change, message):
    fields = {name: getattr(GAPS, name) for name in ("dv", "values", "subjects", "factors", "levels")}
    with pytest.raises(LogError, match=message):
        RepeatedMeasures(**{**fields, **change})


def test_a_choice_that_there_is_not_is_refused_by_name():
    with pytest.raises(
        LogError, match="missing is 'drop'; expected one of 'refuse', 'drop-subjects', 'drop-levels'"
    ):
        check_choice("missing", "drop", ["refuse", "drop-subjects", "drop-levels"])


def test_a_factor_between_subjects_is_recognised():
    told = RepeatedMeasures.from_columns(
        "y", np.arange(4.0), ["a", "b", "c", "d"], {"group": ["old", "old", "new", "new"]}
    )
    for missing in ("refuse", "drop-subjects"):
        with pytest.raises(LogError, match="no subject has values at more than one level of 'group'"):
            analyse([told], missing=missing)


@pytest.mark.parametrize("several", [(math.inf,), (math.inf, -math.inf), (1.0, math.inf)])
def test_an_infinite_value_is_refused_and_is_no_missing_one(several):
    rows = [*several, 1.0, 2.0, 3.0]
    subjects = ["ann"] * (len(several) + 1) + ["bob"] * 2
    levels = ["old"] * len(several) + ["new", "old", "new"]
    with pytest.raises(LogError, match="subject 'ann' at robot 'old' is infinite"):
        RepeatedMeasures.from_columns("y", np.array(rows), subjects, {"robot": levels}, repeated="mean")
