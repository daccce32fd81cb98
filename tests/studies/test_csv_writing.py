"""CSV tables: complete or not there, exact, and never run by a spreadsheet."""

import csv
import math

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from ppinfer.errors import LogError
from ppinfer.studies.csv_writing import cell_of_text, text_of_cell, write_csv
from ppinfer.studies.faults import Faults
from ppinfer.studies.readers.mapping import FileOptions
from ppinfer.studies.readers.tables import read_table

any_text = st.text() | st.text(alphabet="=+-@'\\x09un\t\r\n\",;1 ａ＝", max_size=6)


def rows_of(path):
    with path.open(newline="", encoding="utf-8") as file:
        return list(csv.reader(file))


@given(
    st.lists(
        st.tuples(any_text, st.floats(allow_infinity=False), st.integers(), st.booleans()),
        min_size=1,
        max_size=5,
    ),
    any_text.filter(lambda name: name not in ("number", "whole", "flag")),
)
def test_what_is_written_is_read_back(tmp_path_factory, rows, name):
    path = tmp_path_factory.mktemp("csv") / "table.csv"
    text, number, whole, flag = (list(column) for column in zip(*rows, strict=True))
    write_csv(path, {name: text, "number": np.array(number), "whole": whole, "flag": np.array(flag)})
    header, *read = rows_of(path)
    assert [text_of_cell(cell) for cell in header] == [name, "number", "whole", "flag"]
    assert [text_of_cell(row[0]) for row in read] == text
    for told, wanted in zip((row[1] for row in read), number, strict=True):
        assert told == "" if math.isnan(wanted) else float(told) == wanted
    assert [int(row[2]) for row in read] == whole
    assert [bool(int(row[3])) for row in read] == flag


@given(any_text)
@example("\r=1")
@example("\ufeff=1")
@example("' =1")
def test_no_cell_of_text_is_computed_or_holds_what_cannot_be_seen(text):
    cell = cell_of_text(text)
    assert not any(ord(character) < 32 or 0x7F <= ord(character) < 0xA0 for character in cell)
    if cell.lstrip().startswith(tuple("=+-@＝＋－＠")):
        assert math.isfinite(float(cell)) or math.isinf(float(cell))
    cell.encode("utf-8")


@given(any_text, any_text)
@example("=a", "'=a")
@example("\n", "\\x0a")
def test_texts_that_differ_are_told_apart_in_cells(one, other):
    assert (cell_of_text(one) == cell_of_text(other)) == (one == other)


@given(any_text)
def test_a_cell_gives_its_text_back(text):
    assert text_of_cell(cell_of_text(text)) == text


@pytest.mark.parametrize("text", ["=cmd()", "+1+1", "-x", "@SUM(A1)", "\t=1", "\r=1", " =1", "＝1", "-1-1"])
def test_what_a_spreadsheet_would_run_is_text(text):
    assert cell_of_text(text)[0] in "'\\"


@pytest.mark.parametrize("text", ["-3", "+0.5", "-1e-5", "Ann", "a=b", "'quoted'", "3 - 4", ""])
def test_other_texts_stand_as_they_are(text):
    assert cell_of_text(text) == text


def test_a_column_alone_keeps_its_empty_cells(tmp_path):
    write_csv(tmp_path / "one.csv", {"x": [1.0, None, float("nan")]})
    assert rows_of(tmp_path / "one.csv") == [["x"], ["1.0"], [""], [""]]


def test_our_own_reader_reads_it(tmp_path):
    write_csv(tmp_path / "t.csv", {"who": ['a "b", c', "d"], "x": np.array([0.1, np.nan])})
    faults = Faults()
    table = read_table(tmp_path / "t.csv", [("who", "who"), ("x", "x")], FileOptions(), faults)
    assert table.text("who").labels == ['a "b", c', "d"]
    np.testing.assert_array_equal(table.numbers("x", faults), [0.1, np.nan])
    assert not faults


@pytest.mark.parametrize(
    ("columns", "told"),
    [
        ({}, "without columns"),
        ({"a": [1], "b": [1, 2]}, "'a' has 1, 'b' has 2"),
        ({"a": [1], "b": [[2]]}, "column 'b', row 1: a cell holds text or a number, got list"),
    ],
)
def test_what_no_table_can_hold_is_refused_and_the_older_file_stays(tmp_path, columns, told):
    (tmp_path / "t.csv").write_text("older\n")
    with pytest.raises(LogError, match=told):
        write_csv(tmp_path / "t.csv", columns)
    assert [path.name for path in tmp_path.iterdir()] == ["t.csv"]
    assert (tmp_path / "t.csv").read_text() == "older\n"
