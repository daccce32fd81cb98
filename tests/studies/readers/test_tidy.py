import numpy as np
import pytest
from hypothesis import given, settings

from ppinfer.errors import LogError
from ppinfer.studies import FaultyLogError, log_of_trials, read_tidy, validate_log
from ppinfer.testing.log_strategies import studies

from ..logs import plain

LONG = """
[columns]
trial = "g"
participant = "s"
time = "t"
x = "px"
y = "py"
true_goal = "tg"

[constants]
agent = "human"

[units]
time = "ms"
position = "cm"

[goals]
cup = [10.0, 42]
pan = [1.0, 2.0]
"""

WIDE = """
[file]
delimiter = ";"
decimal = ","

[columns]
trial = "g"
participant = "s"
time = "t"

[agents.human]
x = "hx"
y = "hy"
true_goal = "tg"

[agents.robot]
x = "rx"
y = "ry"
vx = "rvx"
vy = "rvy"

[goal_columns.a]
x = "ax"
y = "ay"

[goal_columns.b]
x = "bx"
y = "by"
"""

BY_AGENT = """
missing = "dropout"

[columns]
trial = "g"
participant = "s"
time = "t"
agent = "who"
x = "px"
y = "py"
true_goal = "tg"

[goals_file]
path = "goals.csv"
trial = "g"
goal = "goal"
x = "x"
y = "y"
from_time = "from"
"""


@pytest.fixture
def read(tmp_path):
    """Write a table, its mapping and further files, and read it."""

    def written(table, mapping, **others):
        (tmp_path / "reaches.csv").write_text(table)
        (tmp_path / "m.toml").write_text(mapping)
        for name, text in others.items():
            (tmp_path / f"{name}.csv").write_text(text)
        return read_tidy(tmp_path / "reaches.csv", tmp_path / "m.toml")

    return written


def places(caught):
    return [(fault.kind, fault.file, fault.line, fault.column) for fault in caught.value.faults]


def test_rows_of_interleaved_trials_become_samples_in_si_units(read):
    log = read(
        "g,s,t,px,py,tg\n1,a,0,1,2,cup\n2,b,0,5,6,\n1,a,100,3,4,cup\n1,a,300,3,4,pan\n2,b,50,7,8,pan\n\n",
        LONG,
    )
    assert validate_log(log).ok
    assert log.trial_id.values.tolist() == ["1", "2"]
    assert log.participant.values.tolist() == ["a", "b"]
    assert log.time.values.tolist() == [0, 0.1, 0.3, 0, 0.05]
    assert log.position.values[:, 0].tolist() == [
        [0.01, 0.02],
        [0.03, 0.04],
        [0.03, 0.04],
        [0.05, 0.06],
        [0.07, 0.08],
    ]
    assert log.goal_position.values[1].tolist() == [[0.1, 0.42], [0.01, 0.02]]


def test_runs_of_one_true_goal_are_segments(read):
    log = read(
        "g,s,t,px,py,tg\n1,a,0,1,2,cup\n1,a,1,1,2,cup\n1,a,2,1,2,\n1,a,3,1,2,cup\n1,a,4,1,2,pan\n2,a,0,1,2,pan\n",
        LONG,
    )
    found = zip(
        log.segment_trial.values,
        log.segment_start.values,
        log.segment_stop.values,
        log.true_goal.values,
        strict=True,
    )
    assert [tuple(segment) for segment in found] == [
        (0, 0, 2, "cup"),
        (0, 3, 4, "cup"),
        (0, 4, 5, "pan"),
        (1, 0, 1, "pan"),
    ]


def test_a_wide_table_has_columns_for_each_agent_and_goal(read):
    log = read(
        "g;s;t;hx;hy;tg;rx;ry;rvx;rvy;ax;ay;bx;by\n"
        "1;p;0;1,5;2;a;3;4;5;6;0;0;1;1\n"
        "1;p;1;1,25;2;a;3;4;5;6;0;0;;\n",
        WIDE,
    )
    assert validate_log(log).ok
    assert log.position.values[:, 0, 0].tolist() == [1.5, 1.25]
    assert log.has_velocity.values.tolist() == [0, 1]
    assert log.goal_present.dims == ("sample", "goal")
    assert log.goal_present.values.tolist() == [[1, 1], [1, 0]]
    assert log.segment_agent.values.tolist() == ["human"]


def test_agents_by_row_share_samples_and_goals_move_with_time(read):
    log = read(
        "g,s,t,who,px,py,tg\n1,p,0,h,1,2,cup\n1,p,0,r,3,4,\n1,p,1,h,1,2,cup\n1,p,2,h,,,\n1,p,2,r,3,4,pan\n",
        BY_AGENT,
        goals="g,goal,x,y,from\n1,cup,1,2,0\n1,pan,5,6,0\n1,cup,,,2\n",
    )
    assert validate_log(log).ok
    assert log.observed.values.tolist() == [[1, 1], [1, 0], [0, 1]]
    assert log.goal_position.values[:, 0].tolist()[:2] == [[1, 2], [1, 2]]
    assert log.goal_present.values.tolist() == [[1, 1], [1, 1], [0, 1]]
    assert log.segment_agent.values.tolist() == ["h", "r"]
    assert (log.segment_start.values.tolist(), log.segment_stop.values.tolist()) == ([0, 2], [2, 3])


def test_segments_may_come_from_a_table_of_their_own(read):
    mapping = (
        LONG.replace('true_goal = "tg"\n', "")
        + """
[segments_file]
path = "segments.csv"
trial = "g"
start = "from"
stop = "to"
true_goal = "goal"
"""
    )
    table = "g,s,t,px,py\n" + "".join(f"1,a,{time},1,2\n" for time in (0, 100, 200, 300))
    log = read(table, mapping, segments="g,from,to,goal\n1,50,250,cup\n1,300,301,pan\n")
    assert (log.segment_start.values.tolist(), log.segment_stop.values.tolist()) == ([1, 3], [3, 4])
    with pytest.raises(FaultyLogError) as caught:
        read(table, mapping, segments="g,from,to,goal\n9,0,1,cup\n1,x,1,spoon\n")
    assert places(caught) == [
        ("unknown-trial", "segments.csv", 2, "g"),
        ("unknown-goal", "segments.csv", 3, "goal"),
        ("not-a-number", "segments.csv", 3, "from"),
    ]
    for out_of_trial in ("1,100,99000,cup", "1,-300,200,cup", "1,200,100,cup"):
        with pytest.raises(FaultyLogError) as caught:
            read(table, mapping, segments=f"g,from,to,goal\n{out_of_trial}\n")
        assert [place[:3] for place in places(caught)] == [("segment-range", "segments.csv", 2)]
    # a stop that is one time step after the last sample is how a segment says that it holds that sample
    assert read(table, mapping, segments="g,from,to,goal\n1,0,400,cup\n").segment_stop.values.tolist() == [4]


@pytest.mark.parametrize(
    ("table", "expected"),
    [
        (
            '1,"a\nb",0,1,x,cup\n2,a,0,1,2,\n1,"a\nb",1,,2,cop\n2,b,1,inf,2,pan\n',
            [
                ("not-a-number", "reaches.csv", 7, "px"),
                ("missing-value", "reaches.csv", 5, "px"),
                ("not-a-number", "reaches.csv", 2, "py"),
                ("unknown-goal", "reaches.csv", 5, "tg"),
                ("not-constant", "reaches.csv", 7, "s"),
            ],
        ),
        (
            "1,a,0,1,2,\n2,a,0,1,2,\n1,a,0,1,2,\n2,a,-1,1,2,\n",
            [("time-not-increasing", "reaches.csv", line, "t") for line in (4, 5)],
        ),
        (
            "1,a,zero,1,2,\n1,a,,x,2,\n",
            [
                ("not-a-number", "reaches.csv", 2, "t"),
                ("missing-value", "reaches.csv", 3, "t"),
                ("not-a-number", "reaches.csv", 3, "px"),
            ],
        ),
        ("1,a,0,1,2\n\n1,a,1,1,2,,\n", [("wrong-length", "reaches.csv", line, None) for line in (2, 4)]),
        (",a,0,1,2,\n", [("missing-value", "reaches.csv", 2, "g")]),
        ("", [("empty", "reaches.csv", None, None)]),
    ],
)  # fmt: skip
def test_every_fault_of_a_table_is_told_at_once_with_line_and_column(read, table, expected):
    with pytest.raises(FaultyLogError) as caught:
        read("g,s,t,px,py,tg\n" + table, LONG)
    assert sorted(places(caught), key=str) == sorted(expected, key=str)


def test_columns_that_are_not_there_are_told_with_the_likeliest_ones(read):
    with pytest.raises(FaultyLogError) as caught:
        read("g,s,time_ms,Px,py,goal\n1,a,0,1,2,cup\n", LONG)
    lines = caught.value.lines
    assert len(lines) == 3
    assert "did you mean 'Px'? there are 'g', 's', 'time_ms', 'Px', 'py', 'goal'" in "".join(lines)


def test_a_dropout_must_be_asked_for(read):
    table = "g,s,t,px,py,tg\n1,a,0,1,2,\n1,a,1,,,\n"
    with pytest.raises(FaultyLogError, match='missing = "dropout"'):
        read(table, LONG)
    assert read(table, 'missing = "dropout"\n' + LONG).observed.values.tolist() == [[1], [0]]


def test_an_agent_without_a_row_is_a_dropout_or_a_fault(read):
    table = "g,s,t,who,px,py,tg\n1,p,0,h,1,2,\n1,p,0,r,3,4,\n1,p,1,h,1,2,\n"
    with pytest.raises(FaultyLogError, match="no row of 'r' at 1 s"):
        read(table, BY_AGENT.replace("dropout", "fault"), goals="g,goal,x,y,from\n1,cup,1,2,0\n")
    since_1970 = table.replace(",0,", ",1700000000.0,").replace(",1,h", ",1700000000.1,h")
    with pytest.raises(FaultyLogError, match=r"no row of 'r' at 1700000000\.1 s"):
        read(since_1970, BY_AGENT.replace("dropout", "fault"), goals="g,goal,x,y,from\n1,cup,1,2,0\n")


@pytest.mark.parametrize(
    ("mapping", "told"),
    [
        (LONG + "[colums]\n", "no entry 'colums'; did you mean 'columns'"),
        (LONG.replace("agent =", "agnt ="), "no entry 'constants.agnt'; did you mean 'agent'"),
        (LONG.replace('agent = "human"', ""), "whose motion it is"),
        (LONG.replace('"cm"', '"furlong"'), "expected a positive number or one of m, cm"),
        (LONG.replace("42]", '"far"]'), "'goals.cup.1': Input should be a valid number"),
        (LONG.replace("42]", "42, 7]"), "'goals.cup' has 3 coordinates, expected 2"),
        (LONG.replace('x = "px"', ""), "'columns.x' is missing"),
        (LONG.replace('x = "px"', 'x = "px"\nvx = "v"'), "a velocity has all of vx, vy"),
        (LONG.replace('participant = "s"', ""), "'participant' is missing"),
        (LONG[: LONG.index("[goals]")], "not where the goals are"),
        (
            LONG + '[goals_file]\npath = "g.csv"\ngoal = "g"\nx = "x"\ny = "y"\n',
            "in one way where the goals are",
        ),
        (LONG + '[goals_file]\npath = "g.csv"\n', "'goals_file.goal' is missing"),
        (LONG + "x = = 3", "is not TOML"),
    ],
)
def test_a_mapping_that_cannot_work_is_told_before_the_table_is_read(read, mapping, told):
    with pytest.raises(FaultyLogError) as caught:
        read("", mapping)
    assert told in "\n".join(caught.value.lines)


def test_all_faults_of_a_mapping_are_told_at_once(read):
    with pytest.raises(FaultyLogError) as caught:
        read("", LONG.replace('time = "t"', "").replace('"cm"', "-1").replace('agent = "human"', ""))
    assert caught.value.counts == {"mapping": 3}


@pytest.mark.parametrize("content", [b"", b"\xff\xfe\x00", b'g,s,t,px,py,tg\n1,"a', b"PAR1", b"\x00" * 100])
@pytest.mark.parametrize("name", ["reaches.csv", "reaches.parquet"])
def test_a_file_that_is_no_table_is_one_clear_error(tmp_path, name, content):
    (tmp_path / name).write_bytes(content)
    (tmp_path / "m.toml").write_text(LONG)
    with pytest.raises(LogError, match=name):
        read_tidy(tmp_path / name, tmp_path / "m.toml")


@pytest.mark.parametrize("suffix", [".csv", ".parquet"])
@settings(max_examples=15)
@given(study=studies())
def test_a_log_told_as_a_table_reads_as_the_same_log(tmp_path_factory, suffix, study):
    import pandas as pd

    trials, options = study
    log = log_of_trials(trials, **options)
    agents = options["agents"]
    row_size = log.row_size.values
    columns = {
        "trial": np.repeat([f"trial {index}" for index in range(row_size.size)], row_size),
        "time": log.time.values,
    }
    lines = [
        'missing = "dropout"',
        "[constants]",
        'participant = "p"',
        "[columns]",
        'trial = "trial"',
        'time = "time"',
    ]
    for index, agent in enumerate(agents):
        lines.append(f"[agents.{agent}]")
        for axis, name in enumerate("xy"):
            columns[f"{agent}_{name}"] = log.position.values[:, index, axis]
            lines.append(f'{name} = "{agent}_{name}"')
    folder = tmp_path_factory.mktemp("tidy")
    table = pd.DataFrame(columns)
    path = folder / f"table{suffix}"
    table.to_csv(path, index=False) if suffix == ".csv" else table.to_parquet(path)
    (folder / "m.toml").write_text("\n".join(lines))
    found = plain(read_tidy(path, folder / "m.toml"))
    for name in ("row_size", "time", "position", "observed"):
        assert found[name].identical(plain(log)[name]), name
