"""Reading answers: what a cell means, and every wrong one told with line and column, naming nobody."""

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest
from hypothesis import given, settings

from ppinfer.errors import LogError
from ppinfer.studies.faults import FaultyLogError
from ppinfer.studies.surveys import Instrument, read_survey

from .tables import HEADER, INSTRUMENT, answers, table

READ = Instrument.parse(INSTRUMENT)


def read(tmp_path, rows, instrument=READ, **options):
    path = tmp_path / "answers.csv"
    path.write_text(table(rows) if isinstance(rows, list) else rows, encoding="utf-8")
    return read_survey(path, instrument, **options)


@settings(max_examples=12)
@given(answers())
def test_answers_are_what_the_cells_say(tmp_path_factory, rows):
    survey = read(tmp_path_factory.mktemp("s"), rows, keep_ids=True)
    wanted = [[float(cell) if cell else np.nan for cell in row[3:]] for row in rows]
    np.testing.assert_array_equal(survey.values, wanted)
    assert [survey.participants[who] for who in survey.participant] == [row[0] for row in rows]
    assert [condition[0] for condition in survey.conditions] == [row[2] for row in rows]


def test_a_cell_is_a_number_or_the_text_of_an_anchor(tmp_path):
    survey = read(
        tmp_path, [["u", "", "one", "4.0", " strongly  AGREE", "5e0"], ["u", "", "two", "NA", "agree", "1"]]
    )
    np.testing.assert_array_equal(survey.values, [[4, 5, 5], [np.nan, 4, 1]])
    np.testing.assert_array_equal(survey.turned, [[4, 5, 1], [np.nan, 4, 5]])


def test_every_wrong_cell_is_told_with_line_and_column_and_nobody_is_named(tmp_path):
    rows = [
        ["ann", "a@b", "one", "6", "2.5", "perhaps"],
        ["ann", "a@b", "one", "1", "1", "1"],
        ["", "a@b", "one", "1", "1", "1"],
        ["ann", "a@b", "", "0", "inf", "1"],
    ]
    with pytest.raises(FaultyLogError) as caught:
        read(tmp_path, rows)
    lines = caught.value.lines
    assert all("ann" not in line and "a@b" not in line for line in lines)
    told = "\n".join(lines)
    for part in (
        "line 2: column 'easy': expected a whole number from 1 to 5 or one of 'Strongly Disagree', 'Agree', "
        "'Strongly Agree', got '6'",
        "line 2: column 'how_quick': expected",
        "got '2.5'",
        "line 2: column 'slow'",
        "got another text (of 7 letters)",
        "line 3: column 'user': this participant has answered under this condition in line 2 already",
        "line 4: column 'user': no participant",
        "line 5: column 'robot': no condition",
        "line 5: column 'easy'",
        "line 5: column 'how_quick'",
    ):
        assert part in told
    assert sum(caught.value.counts.values()) == 8


def test_a_wrong_cell_is_shown_where_it_is_a_number_or_a_misspelt_anchor_but_not_where_it_may_be_a_name(
    tmp_path,
):
    rows = [["u1", "", "one", "Stongly agree", "7 / 5", "Ann Miller <ann@b.org>"]]
    with pytest.raises(FaultyLogError) as caught:
        read(tmp_path, rows)
    told = "\n".join(caught.value.lines)
    assert "got 'Stongly agree'" in told
    assert "got '7 / 5'" in told
    assert "got another text (of 22 letters)" in told
    assert "Ann" not in told


def test_columns_that_are_not_there_are_told_in_terms_of_the_instrument(tmp_path):
    with pytest.raises(FaultyLogError) as caught:
        read(tmp_path, "usr,robot,easy,slow\na,b,1,1\n")
    told = " ".join(caught.value.lines)
    assert "no such column (the instrument's 'columns.subject'); did you mean 'usr'?" in told
    assert "(the instrument's 'items.quick')" in told


def test_a_condition_that_stands_for_no_value_is_told_as_such(tmp_path):
    with pytest.raises(FaultyLogError) as caught:
        read(tmp_path, [["u", "", "NA", 1, 1, 1]])
    assert "no condition: 'NA' stands for no value; call it something else" in " ".join(caught.value.lines)


def test_conditions_that_the_instrument_does_not_list_are_faults(tmp_path):
    listed = Instrument.parse(INSTRUMENT + "\n[conditions.robot]\none = 'One'\ntwo = ''\n")
    with pytest.raises(FaultyLogError, match="names no condition 'tow'; did you mean 'two'"):
        read(tmp_path, [["u", "", "one", 1, 1, 1], ["u", "", "tow", 1, 1, 1]], listed)


def test_listed_conditions_come_in_their_order_and_others_sorted(tmp_path):
    rows = [["u", "", robot, 1, 1, 1] for robot in ("one", "two", "three")]
    assert list(read(tmp_path, rows).groups()) == ["one", "three", "two"]
    listed = Instrument.parse(INSTRUMENT + "\n[conditions.robot]\ntwo = ''\none = ''\nthree = ''\n")
    assert list(read(tmp_path, rows, listed).groups()) == ["two", "one", "three"]


def test_semicolons_decimal_commas_and_other_points(tmp_path):
    instrument = Instrument.parse("""
        columns = {subject = "Nr", condition = ["Roboter", "Aufgabe"]}
        file = {delimiter = ";", decimal = ",", missing = ["", "k.A."]}
        anchors = {1 = "trifft gar nicht zu", 7 = "trifft völlig zu"}
        items = {leicht = {column = "War leicht"}, schnell = {}}
    """)
    text = "Nr;Roboter;Aufgabe;War leicht;schnell\n1;A;x;7,0;trifft völlig zu\n1;A;y;k.A.;3\n"
    survey = read(tmp_path, text, instrument, keep_ids=True)
    np.testing.assert_array_equal(survey.values, [[7, 7], [np.nan, 3]])
    assert survey.labels() == ["A / x", "A / y"]
    assert survey.labels(["Aufgabe"]) == ["x", "y"]
    with pytest.raises(LogError, match="no condition column 'aufgabe'"):
        survey.labels(["aufgabe"])
    with pytest.raises(FaultyLogError, match=r"got '2,5'"):
        read(tmp_path, text.replace("7,0", "2,5"), instrument)


def test_another_delimiter_is_told_instead_of_all_the_columns_that_it_hides(tmp_path):
    with pytest.raises(FaultyLogError, match="1 fault: cells seem to be separated by ';', not by ','"):
        read(tmp_path, table([["u", "", "one", 1, 1, 1]], delimiter=";"))


def test_a_parquet_table_is_read_alike(tmp_path):
    columns = {
        "user": [1, 2],
        "robot": ["a", "a"],
        "easy": [4.0, None],
        "how_quick": [1, 2],
        "slow": ["5", "Agree"],
    }
    pq.write_table(pa.table(columns), tmp_path / "answers.parquet")
    survey = read_survey(tmp_path / "answers.parquet", READ, keep_ids=True)
    np.testing.assert_array_equal(survey.values, [[4, 1, 5], [np.nan, 2, 4]])


def test_missing_answers_are_named_and_refused_unless_one_chooses(tmp_path):
    survey = read(
        tmp_path, [["u", "", "one", "", "2", "3"], ["u", "", "two", "4", "5", ""], ["v", "", "one", 4, 4, 3]]
    )
    with pytest.raises(FaultyLogError) as caught:
        survey.complete()
    assert [line.partition(";")[0] for line in caught.value.lines] == [
        "answers.csv: line 2: column 'easy': no answer (condition 'one')",
        "answers.csv: line 3: column 'slow': no answer (condition 'two')",
    ]
    kept = survey.complete("drop-responses")
    np.testing.assert_array_equal(kept.values, [[4, 4, 3]])
    assert len(kept.participants) == 1
    assert kept.participants[0] in survey.participants
    means = survey.complete("mean-of-answered").scores().ravel()
    np.testing.assert_allclose(np.sort(means), [(2 + 3) / 2, (4 + 4 + 3) / 3, (4 + 5) / 2])
    with pytest.raises(LogError, match="missing='ignore'; expected one of refuse"):
        survey.complete("ignore")


def test_where_no_response_is_whole_there_is_nothing_to_keep(tmp_path):
    survey = read(tmp_path, [["u", "", "one", "", "2", "3"]])
    with pytest.raises(LogError, match="every response lacks an answer"):
        survey.complete("drop-responses")


def test_positions_are_whole_numbers_from_one(tmp_path):
    instrument = Instrument.parse(
        INSTRUMENT.replace('condition = "robot"', 'condition = "robot"\nposition = "at"')
    )
    header = [*HEADER, "at"]
    rows = [["u", "", "one", 1, 1, 1, "2"], ["u", "", "two", 1, 1, 1, ""]]
    assert read(tmp_path, table(rows, header), instrument).position.tolist() == [2, 0]
    for cell in ("0", "-1", "1.5", "x", "1e99"):
        with pytest.raises(FaultyLogError) as caught:
            read(tmp_path, table([["u", "", "one", 1, 1, 1, cell]], header), instrument)
        assert sum(caught.value.counts.values()) == 1
        assert "line 2: column 'at'" in str(caught.value)
