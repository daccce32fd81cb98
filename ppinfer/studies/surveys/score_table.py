"""The scores of a survey as a table that other commands read: one row a response."""

from __future__ import annotations

import os
from typing import Any

from ppinfer.studies.csv_writing import write_csv
from ppinfer.studies.surveys.survey import Survey


def score_table(survey: Survey) -> dict[str, list[Any]]:
    r"""Return the columns of the table of scores.

    ``participant``, the instrument's condition columns, ``position`` where the instrument has one, each item after
    reversing (called ``NAME_reversed`` where that changed it) and the score of each scale; NaN where there is none.
    Rows are sorted by participant and condition, not as in the file.

    Examples
    --------
    >>> from ppinfer.studies.surveys import Instrument, read_survey
    >>> from pathlib import Path
    >>> _ = Path("answers.csv").write_text("user,robot,easy,way\nann,a,5,1\nann,b,2,4\n")
    >>> instrument = Instrument.parse('''
    ...     columns = {subject = "user", condition = "robot"}
    ...     anchors = {1 = "no", 5 = "yes"}
    ...     items = {easy = {}, way = {reversed = true}}
    ...     scales.fluency.items = ["easy", "way"]
    ... ''')
    >>> for name, column in score_table(read_survey("answers.csv", instrument)).items():
    ...     print(name, column)
    participant ['P01', 'P01']
    robot ['a', 'b']
    easy [5.0, 2.0]
    way_reversed [5.0, 2.0]
    fluency [5.0, 2.0]
    """
    instrument = survey.instrument
    names = [survey.participants[who] for who in survey.participant]
    ranks = {row: rank for rank, rows in enumerate(survey.groups().values()) for row in rows.tolist()}
    rows = sorted(range(survey.n_responses), key=lambda row: (names[row], ranks[row]))
    columns: dict[str, list[Any]] = {"participant": [names[row] for row in rows]}
    for at, factor in enumerate(instrument.factors):
        columns[factor] = [survey.conditions[row][at] for row in rows]
    if instrument.columns.position is not None:
        columns["position"] = [int(survey.position[row]) or None for row in rows]
    turned, scores = survey.turned[rows], survey.scores()[rows]
    columns |= {name: turned[:, at].tolist() for at, name in enumerate(instrument.score_names)}
    return columns | {name: scores[:, at].tolist() for at, name in enumerate(instrument.scales)}


def write_scores(path: str | os.PathLike[str], survey: Survey) -> None:
    r"""Write the table of scores as CSV, complete or not at all.

    Examples
    --------
    >>> from ppinfer.studies.surveys import Instrument, read_survey
    >>> from pathlib import Path
    >>> _ = Path("answers.csv").write_text("user,easy\nann,5\n")
    >>> instrument = Instrument.parse('''
    ...     columns = {subject = "user"}
    ...     anchors = {1 = "no", 5 = "yes"}
    ...     items.easy = {}
    ... ''')
    >>> write_scores("scores.csv", read_survey("answers.csv", instrument))
    >>> print(Path("scores.csv").read_text())
    participant,easy
    P01,5.0
    <BLANKLINE>
    """
    write_csv(path, score_table(survey))
