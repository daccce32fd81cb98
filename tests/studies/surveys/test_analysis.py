"""What a survey says, and that it names nobody."""

import csv
import json

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy import stats

from ppinfer.errors import LogError
from ppinfer.studies.surveys import Instrument, analyse_survey, read_survey, score_table, write_scores
from ppinfer.studies.surveys.pseudonyms import pseudonyms

from .tables import INSTRUMENT, ITEMS, answers, survey_of, table

READ = Instrument.parse(INSTRUMENT)


def read(folder, rows, instrument=READ, **options):
    path = folder / "answers.csv"
    path.write_text(table(rows), encoding="utf-8")
    return read_survey(path, instrument, **options)


def all_output(survey):
    analysis = analyse_survey(survey, missing="mean-of-answered")
    return json.dumps(analysis.to_json()) + str(score_table(survey))


@given(answers(), st.randoms(use_true_random=False), st.integers(0, 3))
def test_renaming_participants_or_reordering_the_table_changes_nothing(rows, random, seed):
    names = sorted({row[0] for row in rows})
    numbers = random.sample(range(99), len(names))
    renamed = {name: f"someone {number}" for name, number in zip(names, numbers, strict=True)}
    other = [[renamed[row[0]], *row[1:]] for row in rows]
    random.shuffle(other)
    one, two = (survey_of(each, READ).pseudonymised(seed) for each in (rows, other))
    assert all_output(one) == all_output(two)


@pytest.mark.parametrize("reordered", [False, True])
def test_what_is_written_is_the_same_byte_for_byte_whoever_answered(tmp_path, reordered):
    rows = [
        [user, f"{user}@mail", robot, 1 + len(user) % 5, 2, 3] for user in ("ann", "bo") for robot in "ab"
    ]
    write_scores(tmp_path / "one.csv", read(tmp_path, rows))
    other = [["x" + row[0][::-1], "", *row[2:]] for row in (rows[::-1] if reordered else rows)]
    write_scores(tmp_path / "two.csv", read(tmp_path, other))
    assert (tmp_path / "one.csv").read_bytes() == (tmp_path / "two.csv").read_bytes()


def test_no_name_and_no_column_that_the_instrument_does_not_name_gets_out(tmp_path):
    rows = [[f"name-{i}", "secret@mail", robot, 1 + i % 5, 2, ""] for i in range(4) for robot in "ab"]
    survey = read(tmp_path, rows)
    for told in (all_output(survey), repr(vars(survey)), str(survey.missing_cells())):
        assert "secret" not in told
        assert "name-" not in told


def test_pseudonyms_do_not_follow_the_answers_either_and_the_seed_shuffles_them():
    values = np.arange(30.0)[:, None]
    named = [pseudonyms(np.arange(30), ["a"] * 30, values, seed=seed) for seed in range(3)]
    assert all(sorted(names) == [f"P{i:02}" for i in range(1, 31)] for names in named)
    assert len(set(named)) == 3
    for names in named:
        order = [int(name[1:]) for name in names]
        assert abs(stats.spearmanr(order, range(30)).statistic) < 0.5
    assert len(pseudonyms(np.arange(100), ["a"] * 100, np.arange(100.0)[:, None])[0]) == 4


def test_names_are_kept_where_that_is_asked_for(tmp_path):
    rows = [["zoe", "", "one", 1, 2, 3], ["ann", "", "one", 4, 5, 1]]
    assert score_table(read(tmp_path, rows, keep_ids=True))["participant"] == ["ann", "zoe"]


@given(answers())
def test_summaries_are_those_of_the_answers_that_were_given(rows):
    analysis = analyse_survey(survey_of(rows, READ), missing="mean-of-answered")
    for row in analysis.items:
        at = 3 + ITEMS.index(row.name)
        given_answers = np.array([float(each[at]) for each in rows if each[2] == row.condition and each[at]])
        assert row.n == len(given_answers) == row.participants == sum(row.counts.values())
        assert row.n + row.missing == sum(each[2] == row.condition for each in rows)
        if row.n:
            assert row.mean == pytest.approx(given_answers.mean())
            assert row.median == np.median(given_answers)
        if row.n > 1:
            assert row.sd == pytest.approx(given_answers.std(ddof=1))
            assert row.sem == pytest.approx(stats.sem(given_answers), abs=1e-12)
        assert all(row.counts[number] == (given_answers == number).sum() for number in range(1, 6))
    assert {(row.name, row.condition) for row in analysis.items} == {
        (name, row[2]) for row in rows for name in ITEMS
    }


def test_the_standard_error_is_over_participants_where_they_answered_more_than_once(tmp_path):
    rows = [
        [user, "", robot, value, 1, 1] for user, value in (("u", 1), ("v", 5)) for robot in ("one", "two")
    ]
    row = next(row for row in analyse_survey(read(tmp_path, rows), by=[]).items if row.name == "easy")
    assert (row.n, row.participants, row.condition) == (4, 2, "")
    assert row.sem == pytest.approx(stats.sem([1, 5]))


def test_scores_are_written_after_reversing_and_anova_reads_them(tmp_path):
    from ppinfer.studies.statistics import read_measures

    rows = [
        [user, "", robot, 1 + (at + i) % 5, 2, 3 - i]
        for at, user in enumerate("uvw")
        for i, robot in enumerate("ab")
    ]
    survey = read(tmp_path, rows)
    write_scores(tmp_path / "scores.csv", survey)
    with (tmp_path / "scores.csv").open() as file:
        written = list(csv.DictReader(file))
    assert list(written[0]) == ["participant", "robot", "easy", "quick", "slow_reversed", "fluency"]
    for row in written:
        parts = [float(row[name]) for name in ("easy", "quick", "slow_reversed")]
        assert float(row["fluency"]) == pytest.approx(np.mean(parts))
    assert [row["participant"] for row in written] == ["P01", "P01", "P02", "P02", "P03", "P03"]
    (measures,) = read_measures(tmp_path / "scores.csv", ["fluency"], within=["robot"], subject="participant")
    assert measures.values.shape == (3, 2)
    assert np.isfinite(measures.values).all()


def test_an_item_that_should_be_reversed_is_told(tmp_path):
    rows = [[f"u{i}", "", "one", 1 + i % 5, 1 + i % 5, 1 + i % 5] for i in range(5)]
    (told,) = analyse_survey(read(tmp_path, rows)).warnings
    assert "item 'slow' correlates negatively with the rest (-1.00): it is reversed; should it be?" in told
    forgotten = Instrument.parse(INSTRUMENT.replace("slow = {reversed = true}", "slow = {}"))
    rows = [[*row[:5], 6 - row[5]] for row in rows]
    (told,) = analyse_survey(read(tmp_path, rows, forgotten)).warnings
    assert told.endswith("is it reversed?")


def test_alpha_is_told_of_each_condition_over_all_and_within_participants(tmp_path):
    rows = [
        [u, "", r, 1 + i % 5, 1 + (i * i) % 5, 5 - i % 4]
        for i, (u, r) in enumerate((u, r) for u in "uvwx" for r in "ab")
    ]
    analysis = analyse_survey(read(tmp_path, rows))
    told = [
        (row.of, row.condition, row.alpha.responses, row.alpha.low is None) for row in analysis.reliability
    ]
    assert told == [
        ("condition", "a", 4, False),
        ("condition", "b", 4, False),
        ("all responses", "", 8, True),
        ("within participants", "", 8, True),
    ]
    assert "counts participants as often as they answered" in analysis.notes[0]


def test_a_survey_that_everybody_answers_once_has_one_alpha_and_its_interval(tmp_path):
    once = Instrument.parse(INSTRUMENT.replace('condition = "robot"', ""))
    rows = [[f"u{i}", "", "", 1 + i % 5, 1 + (i + i // 3) % 5, 5 - i % 5] for i in range(9)]
    analysis = analyse_survey(read(tmp_path, rows, once))
    (row,) = analysis.reliability
    assert row.of == "all responses"
    assert row.alpha.low < row.alpha.alpha < row.alpha.high
    assert analysis.notes == ()
    assert {row.condition for row in analysis.items} == {""}


def test_alpha_is_of_responses_that_answered_all_items_of_the_scale(tmp_path):
    rows = [[f"u{i}", "", "one", 1 + i % 5, 1 + i % 4, ""] for i in range(5)] + [["v", "", "one", 1, 2, 3]]
    analysis = analyse_survey(read(tmp_path, rows), missing="mean-of-answered")
    assert analysis.reliability[0].alpha.responses == 1
    assert "two responses or more" in analysis.reliability[0].alpha.reason
    assert analysis.warnings[0].startswith("5 missing answers: scores are means")
    dropped = analyse_survey(read(tmp_path, rows), missing="drop-responses")
    assert dropped.dropped_responses == 5
    assert dropped.warnings[0] == "5 missing answers: 5 of 6 responses were left out"


def test_an_unknown_condition_column_is_refused(tmp_path):
    with pytest.raises(LogError, match="no condition column 'rbot' in the instrument; did you mean 'robot'"):
        analyse_survey(read(tmp_path, [["u", "", "one", 1, 1, 1]]), by=["rbot"])
