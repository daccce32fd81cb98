"""Tables of others: tidy trajectories with their mapping, measures, and answers with their instrument."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from .case import Case, converted, made, same_log_of_a_table

MAPPING = """
title = "reaches"

[file]
delimiter = ";"

[columns]
trial = "g"
participant = "s"
time = "t"
condition = "c"
round = "n"

[agents.human]
x = "hx"
y = "hy"
true_goal = "tg"

[agents.robot]
x = "rx"
y = "ry"
vx = "rvx"
vy = "rvy"

[units]
time = "ms"
position = "cm"

[goals_file]
path = "goals.csv"
trial = "g"
goal = "goal"
x = "x"
y = "y"
from_time = "from"

[variables]
team_score = "score"
layout = {column = "place", per = "trial", kind = "text"}
busy = "busy"
collision = "hit"
finish_time = {columns = {human = "hdone", robot = "rdone"}}
"""
MEASURES = "who;robot;score\n" + "".join(
    f"p{who};{robot};{1 + (who * 7 + index * 3) % 5}.5\n"
    for who in range(5)
    for index, robot in enumerate("abc")
)
INSTRUMENT = """
title = "Fluency"
columns = {subject = "who", condition = "robot"}
anchors = {1 = "Strongly Disagree", 3 = "Neutral", 5 = "Strongly Agree"}

[items.easy]
text = "The robot was easy to work with."

[items.slow]
text = "The robot was slow."
reversed = true

[scales.fluency]
items = ["easy", "slow"]
"""
ANSWERS = "who,robot,easy,slow\n" + "".join(
    f"p{who},{robot},{1 + (who * 3 + index) % 5},{'Strongly Agree' if who == 2 else 1 + (who + index * 2) % 5}\n"
    for who in range(6)
    for index, robot in enumerate("ab")
)


def tables() -> list[Case]:
    """Tidy tables, CSV and Parquet, with the mapping and the table of goals beside them; and measures."""
    import pyarrow.csv as arrow_csv
    import pyarrow.parquet as pq

    from ppinfer.studies import read_tidy
    from ppinfer.studies.readers.mapping import FileOptions
    from ppinfer.studies.statistics.reading import read_measures
    from ppinfer.studies.surveys.instrument import Instrument
    from ppinfer.studies.surveys.reading import read_survey

    rows = ["g;s;t;c;n;hx;hy;tg;rx;ry;rvx;rvy;score;place;busy;hit;hdone;rdone"]
    for trial in range(3):
        rows += [
            f"{trial};p{trial};{100 * step};near;{trial};{step};{2 * step};{'cup' if step else ''};{-step};0;1.5;-.5"
            f";{2.5 * trial};{'ab'[trial % 2]};{step};{step % 2};{100 * trial};"
            for step in range(6)
        ]
    text = "\n".join(rows) + "\n"
    goals = "g;goal;x;y;from\n" + "".join(
        f"{trial};{goal};{trial}.5;{index};0\n"
        for trial in range(3)
        for index, goal in enumerate(("cup", "pan"))
    )

    def parquet(folder: Path) -> None:
        (folder / "reaches.csv").write_text(text)
        (folder / "goals.csv").write_text(goals)
        (folder / "m.toml").write_text(MAPPING)
        table = arrow_csv.read_csv(
            folder / "reaches.csv", parse_options=arrow_csv.ParseOptions(delimiter=";")
        )
        pq.write_table(table, folder / "reaches.parquet")

    files = made(parquet)
    csv_files = {name: content for name, content in files.items() if name != "reaches.parquet"}
    parquet_files = {name: content for name, content in files.items() if name != "reaches.csv"}

    def read(path: Path) -> Any:
        return read_tidy(path, path.with_name("m.toml"))

    def measures(path: Path) -> Any:
        found = read_measures(
            path, ["score"], within=["robot"], subject="who", options=FileOptions(delimiter=";")
        )
        assert np.isfinite(found[0].values[~np.isnan(found[0].values)]).all()
        return {
            (subject, level): value
            for one in found
            for subject, row in zip(one.subjects, one.values.tolist(), strict=True)
            for level, value in zip(one.levels[0], row, strict=True)
        }

    survey = Instrument.parse(INSTRUMENT)

    def answers(path: Path) -> Any:
        found = read_survey(path, survey, keep_ids=True)
        people = [found.participants[index] for index in found.participant]
        told = zip(people, found.conditions, found.values.tolist(), strict=True)
        return {(who, condition): str(row) for who, condition, row in told}

    return [
        Case("read_survey", {"answers.csv": ANSWERS.encode()}, answers),
        Case("Instrument", {"instrument.toml": INSTRUMENT.encode()}, Instrument.load),
        Case("read_tidy csv", csv_files, converted(read), "reaches.csv", {"same": same_log_of_a_table}),
        Case(
            "read_tidy parquet",
            parquet_files,
            converted(read),
            "reaches.parquet",
            {"same": same_log_of_a_table},
        ),
        Case("read_measures", {"scores.csv": MEASURES.encode()}, measures),
    ]
