"""Survey tables and instruments for the tests."""

from __future__ import annotations

import csv
import io

import numpy as np
from hypothesis import strategies as st

from ppinfer.studies.surveys import Survey

ITEMS = ("easy", "quick", "slow")
INSTRUMENT = """
[columns]
subject = "user"
condition = "robot"

[anchors]
1 = "Strongly Disagree"
4 = "Agree"
5 = "Strongly Agree"

[items]
easy = {text = "It was easy."}
quick = {column = "how_quick"}
slow = {reversed = true}

[scales.fluency]
items = ["easy", "quick", "slow"]
"""
HEADER = ["user", "mail", "robot", "easy", "how_quick", "slow"]


def table(rows, header=HEADER, delimiter=","):
    """Return the text of a CSV file."""
    file = io.StringIO()
    writer = csv.writer(file, delimiter=delimiter, lineterminator="\n")
    writer.writerow(header)
    writer.writerows(rows)
    return file.getvalue()


@st.composite
def answers(draw, missing=True):
    """Draw the rows of a survey: participants, all under the same conditions, some answers missing."""
    users = draw(st.lists(st.text("abcxyz019", min_size=1), min_size=1, max_size=5, unique=True))
    robots = draw(st.sampled_from([["one"], ["one", "two"], ["one", "two", "three"]]))
    cell = st.sampled_from(["1", "2", "3", "4", "5"] + ([""] if missing else []))
    return [[user, f"{user}@mail", robot, *(draw(cell) for _ in ITEMS)] for robot in robots for user in users]


def survey_of(rows, instrument):
    """Return the survey that reading the rows of a table gives, without the file."""
    users = list(dict.fromkeys(row[0] for row in rows))
    return Survey(
        instrument,
        np.array([[float(cell) if cell else np.nan for cell in row[3:]] for row in rows]),
        np.array([users.index(row[0]) for row in rows]),
        tuple(users),
        tuple((row[2],) for row in rows),
        np.zeros(len(rows), np.int64),
        np.arange(len(rows)) + 2,
        "answers.csv",
    )
