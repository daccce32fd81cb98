import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from ppinfer.studies import FaultyLogError, open_log, read_log, read_tidy, validate_log, write_log
from ppinfer.studies.metrics import trial_metrics
from ppinfer.studies.metrics.registry import METRICS
from ppinfer.studies.readers.variable_names import known_variable
from ppinfer.studies.schema import VARIABLES

HEAD = """
[columns]
trial = "g"
participant = "s"
time = "t"
"""
LONG = HEAD + 'agent = "who"\nx = "px"\ny = "py"\n[units]\ntime = "ms"\n[variables]\n'
WIDE = (
    HEAD
    + """
[agents.human]
x = "hx"
y = "hy"
[agents.robot]
x = "rx"
y = "ry"
[units]
time = "ms"
[variables]
"""
)
WIDE_TABLE = [
    "g,s,t,hx,hy,rx,ry,layout,score,waits,pick,note,done_h,done_r",
    "1,a,0,0,0,0,0,open,3.5,0,-1,,100,",
    "1,a,100,1,0,0,1,open,3.5,1,2,hm,100,",
    "2,a,0,0,0,0,0,door,,1,-1,,50,100",
    "2,a,100,1,0,0,1,door,,0,-1,so,50,100",
]
LONG_TABLE = [
    "g,s,t,who,px,py,layout,flag,mine,busy",
    "1,a,0,h,0,0,3,true,1.5,4",
    "1,a,0,r,1,1,3,true,2.5,5",
    "1,a,100,h,0,1,3,false,1.5,6",
    "1,a,100,r,1,2,3,false,2.5,7",
]


@pytest.fixture
def read(tmp_path):
    """Write a table and its mapping, and read it."""

    def written(rows, mapping):
        (tmp_path / "reaches.csv").write_text("\n".join(rows) + "\n")
        (tmp_path / "m.toml").write_text(mapping)
        return read_tidy(tmp_path / "reaches.csv", tmp_path / "m.toml")

    return written


def told(caught):
    return [(fault.kind, fault.line, fault.column) for fault in caught.value.faults]


def test_variables_of_a_wide_table_come_into_the_log_and_into_metrics(read, tmp_path):
    log = read(
        WIDE_TABLE,
        WIDE
        + 'layout = "layout"\nteam_score = "score"\nis_human_waiting = "waits"\nhuman_pick = "pick"\nnote = "note"\n'
        + 'finish_time = {columns = {human = "done_h", robot = "done_r"}}\n',
    )
    assert validate_log(log).ok
    assert log.layout.values.tolist() == ["open", "door"]
    np.testing.assert_array_equal(log.team_score.values, [3.5, np.nan])
    assert (log.is_human_waiting.dims, log.is_human_waiting.dtype) == (("sample",), np.int8)
    assert log.human_pick.values.tolist() == [-1, 2, -1, -1]
    assert log.note.values.tolist() == ["", "hm", "", "so"]
    # in seconds, as the log's time is
    np.testing.assert_array_equal(log.finish_time.values, [[0.1, np.nan], [0.05, 0.1]])
    assert log.finish_time.attrs["units"] == "s"
    assert log.attrs["notes"].splitlines() == [
        "variable 'layout': text, one a trial, as its cells say",
        "variable 'note': text, one a sample, as its cells say",
    ]
    write_log(log, tmp_path / "log.nc")
    again = read_log(tmp_path / "log.nc")
    for name in ("layout", "team_score", "is_human_waiting", "human_pick", "note", "finish_time"):
        assert again[name].identical(log[name]), name
    metrics = trial_metrics(log)
    assert {"score", "first_score_s", "human_s", "failures"} <= set(metrics.names)
    assert {group.group for group in metrics.by("layout")} == {"open", "door"}
    assert metrics.values_of("human_s").tolist() == [0.1, 0.05]


def test_variables_of_a_long_table_are_those_of_trials_samples_and_agents(read):
    log = read(
        LONG_TABLE,
        LONG + 'layout = "layout"\nflag = "flag"\nmine = "mine"\nbusy = "busy"\nfinish_time = "mine"\n',
    )
    assert (log.layout.dims, log.layout.dtype, log.layout.values.tolist()) == (("trial",), np.int64, [3])
    assert (log.flag.dims, log.flag.dtype, log.flag.values.tolist()) == (("sample",), np.int8, [1, 0])
    assert (log.mine.dims, log.mine.values.tolist()) == (("trial", "agent"), [[1.5, 2.5]])
    assert (log.busy.dims, log.busy.values.tolist()) == (("sample", "agent"), [[4, 5], [6, 7]])
    assert log.finish_time.values.tolist() == [[0.0015, 0.0025]]


@pytest.mark.parametrize("target", ["log.nc", "log.zarr"])
def test_texts_of_agents_and_names_of_every_script_are_stored(read, tmp_path, target):
    table = [*LONG_TABLE[:3], *(row.replace(",6", ",ä").replace(",7", ",") for row in LONG_TABLE[3:])]
    told = '"büro nr-2.x" = {column = "busy", kind = "text"}\nwho = {column = "who", per = "trial-agent"}\n'
    log = read(table, LONG + told)
    write_log(log, tmp_path / target)
    again = read_log(tmp_path / target)
    assert again["büro nr-2.x"].values.tolist() == [["4", "5"], ["ä", ""]]
    assert again.who.values.tolist() == [["h", "r"]]


def test_what_an_agent_was_asked_to_be_can_be_grouped_by(read):
    log = read(LONG_TABLE, LONG + 'instruction = "mine"\n')
    assert log.instruction.values.tolist() == [["1.5", "2.5"]]


@pytest.mark.parametrize(
    ("told_as", "rows", "expected"),
    [
        ('team_score = "layout"', {3: ",9,true,2.5,5"}, [("not-constant", 3, "layout")]),
        ('x1 = {column = "busy", per = "sample"}', {}, [("not-constant", 3, "busy"), ("not-constant", 5, "busy")]),
        ('x1 = {column = "mine", per = "trial"}', {}, [("not-constant", 3, "mine"), ("not-constant", 5, "mine")]),
        ('finish_time = "busy"', {}, [("not-constant", 4, "busy"), ("not-constant", 5, "busy")]),
        ('stops = "layout"', {2: ",,true,1.5,4"}, [("missing-value", 2, "layout")]),
        ('x1 = {column = "mine", kind = "integer"}', {}, [("not-a-number", n, "mine") for n in (2, 3, 4, 5)]),
        ('collision = "busy"', {}, [*[("not-a-flag", n, "busy") for n in (2, 3, 4, 5)]]),
        ('scored = "flag"', {4: ",3,,1.5,6"}, [("missing-value", 4, "flag")]),
        ('x1 = "busy"', {4: ",3,false,1.5,six"}, [("mixed-kinds", 4, "busy")]),
        ('x1 = "flag"\nx2 = "busy"', {4: ",3,0,1.5,six", 5: ",3,0,2.5,6"},
         [("mixed-kinds", 2, "flag"), ("mixed-kinds", 3, "flag"), ("mixed-kinds", 4, "busy")]),
        ('x1 = {column = "busy", kind = "number"}\ny1 = {column = "mine", kind = "flag"}', {2: ",3,true,1.5,x"},
         [("not-a-number", 2, "busy"), *[("not-a-flag", n, "mine") for n in (2, 3, 4, 5)]]),
    ],
)  # fmt: skip
def test_every_wrong_cell_of_a_variable_is_told_with_line_and_column(read, told_as, rows, expected):
    table = list(LONG_TABLE)
    for line, ends in rows.items():
        table[line - 1] = ",".join(table[line - 1].split(",")[:6]) + ends
    with pytest.raises(FaultyLogError) as caught:
        read(table, LONG + told_as + "\n")
    assert sorted(told(caught)) == sorted(expected)


def test_faults_of_variables_are_told_with_those_of_times(read):
    table = [row.replace("1,a,0,h", "1,a,zero,h").replace(",4", ",four") for row in LONG_TABLE]
    with pytest.raises(FaultyLogError) as caught:
        read(table, LONG + 'stops = "busy"\n')
    assert told(caught) == [("not-a-number", 2, "t"), ("not-a-number", 2, "busy")]


def test_an_agent_without_a_row_has_no_number_and_cannot_have_a_flag(read):
    table = LONG_TABLE[:-1]
    mapping = 'missing = "dropout"\n' + LONG
    log = read(table, mapping + 'busy = {column = "busy", kind = "number"}\n')
    np.testing.assert_array_equal(log.busy.values, [[4, 5], [6, np.nan]])
    with pytest.raises(FaultyLogError, match="there is no row of 'r' here that says its pursued"):
        read(table, mapping + 'pursued = "busy"\n')


@pytest.mark.parametrize(
    ("mapping", "expected"),
    [
        ('row_size = "n"', "'variables.row_size': the log has something of its own of this name; choose another"),
        ('condition = "n"', "of this name; name its column in [columns]"),
        ('trial = "n"', "of its own of this name"),
        ('"a/b" = "n"', "a name has up to 100 letters"),
        ('"zarr.json" = "n"', "a name has up to 100 letters"),
        ('end_effector = "n"', "a point at each sample"),
        ('stops = {column = "n", per = "sample"}', "per is 'sample'; there is one a trial"),
        ('stops = {column = "n", kind = "text"}', "kind is 'text'; expected 'integer'"),
        ('is_human_waiting = {column = "n", per = "trial"}', "per is 'trial'; there is one a sample"),
        ('finish_time = "n"', "name one for each agent, columns = {human = ..., robot = ...}"),
        ('finish_time = {columns = {human = "n"}}', "the agent 'robot' has no column"),
        ('a = {columns = {human = "n", robot = "n", r2 = "n"}}', "there is no agent 'r2'; the agents are human, robot"),
        ('stops = {columns = {human = "n", robot = "n"}}', "there is one a trial; name one column"),
        ('a = {per = "trial"}', "name its column"),
        ('a = {colum = "n"}', "no entry 'variables.a.colum'; did you mean 'column'"),
        ('a = {column = "n", kind = "numbr"}', "'variables.a.kind'"),
        ("a = 3", "'variables.a'"),
    ],
)  # fmt: skip
def test_a_variable_that_cannot_be_is_told_before_the_table_is_read(read, mapping, expected):
    with pytest.raises(FaultyLogError) as caught:
        read([""], WIDE + mapping + "\n")
    assert expected in "\n".join(caught.value.lines)


def test_a_column_that_is_not_there_is_told_with_the_likeliest(read):
    with pytest.raises(FaultyLogError, match=r"variables\.layout.*did you mean 'layout'"):
        read(WIDE_TABLE, WIDE + 'layout = "Layot"\n')


@pytest.mark.parametrize(
    ("cells", "kind"),
    [("1 2", "int64"), ("1 2.5", "float64"), ("1 NA", "float64"), ("1e3 2", "float64"), ("007 008", "object"),
     ("a b", "object"), ("NA NA", "object"), ("True false", "int8"), ("1234567890123456 1", "object")],
)  # fmt: skip
def test_what_cells_say_is_seen_from_all_of_them(read, cells, kind):
    first, second = cells.split()
    rows = ["g,s,t,hx,hy,rx,ry,v", f"1,a,0,0,0,0,0,{first}", f"2,a,0,0,0,0,0,{second}"]
    assert read(rows, WIDE + 'v = "v"\n').v.dtype == kind


def test_columns_of_one_variable_say_the_same_kind_of_thing(read):
    rows = ["g,s,t,hx,hy,rx,ry,a,b", "1,p,0,0,0,0,0,1,one", "1,p,1,0,0,0,0,2,"]
    with pytest.raises(FaultyLogError) as caught:
        read(rows, WIDE + 'v = {columns = {human = "a", robot = "b"}}\n')
    assert told(caught) == [("mixed-kinds", 2, "b")]


def test_whatever_metrics_read_has_a_place_in_the_table():
    wanted = {
        name.replace("{robot}", "{agent}").replace("{human}", "{agent}")
        for metric in METRICS.values()
        for need in (*metric.needs, *metric.reads)
        for name in need.split(" or ")
    }
    assert {name for name in wanted if name not in VARIABLES and known_variable(name) is None} == set()


@settings(max_examples=20)
@given(
    trials=st.lists(
        st.tuples(
            st.integers(-(2**40), 2**40),
            st.floats(allow_infinity=False),
            st.sampled_from(["open", "door", "a b", ""]),
            st.lists(st.tuples(st.booleans(), st.floats(-9, 9)), min_size=1, max_size=4),
        ),
        min_size=1,
        max_size=4,
    )
)
def test_what_is_written_into_a_table_is_read_from_it(tmp_path_factory, trials):
    import csv

    folder = tmp_path_factory.mktemp("variables")
    with (folder / "t.csv").open("w", newline="") as file:
        writer = csv.writer(file)
        writer.writerow(["g", "s", "t", "hx", "hy", "rx", "ry", "n", "v", "l", "f", "m"])
        for index, (n, v, layout, samples) in enumerate(trials):
            for time, (flag, m) in enumerate(samples):
                writer.writerow([index, "p", time, 0, 0, 0, 0, n, repr(v), layout, int(flag), repr(m)])
    (folder / "m.toml").write_text(
        WIDE
        + 'n = {column = "n", per = "trial", kind = "integer"}\nv = {column = "v", per = "trial", kind = "number"}\n'
        + 'l = {column = "l", per = "trial", kind = "text"}\nf = {column = "f", per = "sample", kind = "flag"}\n'
        + 'm = {column = "m", per = "sample", kind = "number"}\n'
    )
    write_log(read_tidy(folder / "t.csv", folder / "m.toml"), folder / "log.nc")
    with open_log(folder / "log.nc") as log:
        assert log.n.values.tolist() == [trial[0] for trial in trials]
        np.testing.assert_array_equal(log.v.values, [trial[1] for trial in trials])
        assert log.l.values.tolist() == [trial[2] for trial in trials]
        assert log.f.values.tolist() == [flag for trial in trials for flag, _ in trial[3]]
        assert log.m.values.tolist() == [m for trial in trials for _, m in trial[3]]
