import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest

from ppinfer.errors import LogError
from ppinfer.studies.faults import FaultyLogError
from ppinfer.studies.readers.mapping import FileOptions
from ppinfer.studies.statistics import read_measures

ROWS = ["id,robot,score", "007,naive,3", "007,new,4.5", "7,naive,2", "7,new,4"]


@pytest.fixture
def table(tmp_path):
    def write(text, name="table.csv", encoding="utf-8"):
        (tmp_path / name).write_bytes(text.encode(encoding))
        return tmp_path / name

    return write


def read(path, *dvs, **options):
    return read_measures(path, dvs or ["score"], within=["robot"], subject="id", **options)


def test_ids_that_look_like_numbers_are_names(table):
    (scores,) = read(table("\n".join(ROWS)))
    assert scores.subjects == ("007", "7")
    assert scores.levels == (("naive", "new"),)
    assert scores.values.tolist() == [[3.0, 4.5], [2.0, 4.0]]


@pytest.mark.parametrize("encoding", ["utf-8", "utf-8-sig"])
@pytest.mark.parametrize("end", ["\n", "\r\n", "\n\n"])
def test_byte_order_marks_line_ends_and_blank_lines_do_not_matter(table, encoding, end):
    (scores,) = read(table(end.join(ROWS) + end, encoding=encoding))
    assert scores.values.tolist() == [[3.0, 4.5], [2.0, 4.0]]


def test_other_delimiters_and_decimal_commas_are_read_where_they_are_said(table):
    text = "\n".join(row.replace(",", ";").replace(".", ",") for row in ROWS)
    path = table(text)
    (scores,) = read(path, options=FileOptions(delimiter=";", decimal=","))
    assert scores.values[0, 1] == 4.5
    with pytest.raises(FaultyLogError, match="separated by ';', not by ','") as told:
        read(path)
    assert told.value.counts == {"delimiter": 1}
    with pytest.raises(FaultyLogError, match="separated by tabs"):
        read(table(text.replace(";", "\t")))


def test_odd_names_and_quoted_cells_are_text(table):
    path = table('"participant id",C(x),"my dv"\n"a, b","<b>",1\n"a, b","=1+1",2\nc,<b>,3\nc,=1+1,4\n')
    (scores,) = read_measures(path, ["my dv"], within=["C(x)"], subject="participant id")
    assert scores.subjects == ("a, b", "c")
    assert scores.levels == (("<b>", "=1+1"),)


def test_parquet_is_read_with_numbers_as_names(tmp_path):
    columns = {"id": [7, 7, 8, 8], "robot": ["a", "b", "a", "b"], "score": [1.0, 2.0, 3.0, None]}
    pq.write_table(pa.table(columns), tmp_path / "t.parquet")
    (scores,) = read(tmp_path / "t.parquet")
    assert scores.subjects == ("7", "8")
    assert np.isnan(scores.values[1, 1])
    pq.write_table(pa.table({**columns, "robot": ["a", "a", "a", "b"]}), tmp_path / "t.parquet")
    with pytest.raises(FaultyLogError, match=r"\(rows 1, 2\)"):
        read(tmp_path / "t.parquet")


def test_empty_cells_of_a_variable_are_missing_and_of_a_name_are_faults(table):
    (scores,) = read(table("id,robot,score\n1,a,1\n1,b,NA\n2,a,\n2,b,2\n"))
    assert np.isnan(scores.values).tolist() == [[False, True], [True, False]]
    with pytest.raises(FaultyLogError) as told:
        read(table("id,robot,score\n,a,1\n1,b,2\n2,,3\n"))
    assert told.value.lines == [
        "table.csv: line 2: column 'id': is empty; expected a name",
        "table.csv: line 4: column 'robot': is empty; expected a name",
    ]


def test_cells_that_are_no_finite_numbers_are_told_with_their_lines(table):
    with pytest.raises(FaultyLogError) as told:
        read(table('id,robot,score\n1,a,good\n\n1,b,inf\n2,"a\nb",1e999\n2,b,3\n'))
    assert [line.partition(": column")[0] for line in told.value.lines] == [
        "table.csv: line 2",
        "table.csv: line 4",
        "table.csv: line 5",
    ]


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("id,robot,Score\n1,a,2\n", "'score': there is no such column; did you mean 'Score'"),
        ("id,robot,score,score\n1,a,2,3\n", "there are 2 columns of this name"),
        ("id,robot,score\n", "there are no rows"),
        ("", "the file is empty"),
        ("id,robot,score\n1,a\n", "line 2: has 2 cells, the header has 3"),
        (
            "id,robot,score\n1,a,2\n1,a,3\n",
            r"subject '1' at robot 'a' is there more than once \(lines 2, 3\)",
        ),
    ],
)
def test_a_table_that_says_something_else_is_refused(table, text, message):
    with pytest.raises(FaultyLogError, match=message):
        read(table(text))


def test_a_file_that_is_not_text_is_refused(table, tmp_path):
    with pytest.raises(FaultyLogError, match="is not UTF-8 text"):
        read(table("id,robot,score\n1,é,2\n", encoding="latin-1"))
    with pytest.raises(FaultyLogError, match="there is no such file"):
        read(tmp_path / "none.csv")


def test_a_column_has_one_role(table):
    path = table("\n".join(ROWS))
    with pytest.raises(LogError, match="column 'score' is asked for 2 times"):
        read(path, "score", "score")
    with pytest.raises(LogError, match="column 'id' is asked for 2 times"):
        read_measures(path, ["score"], within=["id"], subject="id")
    with pytest.raises(LogError, match="at least one dependent variable"):
        read_measures(path, [], within=["robot"], subject="id")


WIDE = "id,naive,new,proactive\n1,3,4,5\n2,2,3,4\n3,1,2,2\n"


@pytest.mark.parametrize(
    ("dvs", "within"),
    [
        (["score"], ["robot"]),
        (["naive", "new"], ["robot"]),
        (["score"], ["naive", "new"]),
        (["naive"], ["new"]),
    ],
)
def test_a_table_with_a_column_for_each_level_is_told_to_be_wide(table, dvs, within):
    with pytest.raises(LogError) as told:
        read_measures(table(WIDE), dvs, within=within, subject="id")[0].complete()
    text = "\n".join(getattr(told.value, "lines", [str(told.value)]))
    assert "every subject has one row" in text
    assert "a row for each subject and level" in text


def test_a_misspelt_column_of_a_long_table_is_not_taken_for_a_wide_one(table):
    with pytest.raises(FaultyLogError) as told:
        read(table("\n".join(ROWS)), "scores")
    assert told.value.counts == {"missing-column": 1}


@pytest.mark.parametrize("cell", ["nan", "NA", "null"])
def test_a_name_that_stands_for_no_value_is_told_as_it_stands(table, cell):
    with pytest.raises(FaultyLogError) as told:
        read(table("\n".join(ROWS).replace("new", cell)))
    assert told.value.counts == {"no-label": 2}
    assert f"{cell!r} stands for no value, and a name is expected" in told.value.lines[0]
    assert "call it something else" in told.value.lines[0]


def test_a_spreadsheet_is_told_to_be_one(tmp_path):
    (tmp_path / "scores.xlsx").write_bytes(b"PK\x03\x04" + bytes(range(128, 256)))
    with pytest.raises(
        FaultyLogError, match=r"scores.xlsx: 1 fault: is a spreadsheet; save its sheet as CSV in UTF-8"
    ):
        read(tmp_path / "scores.xlsx")
