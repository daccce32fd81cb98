"""Bars of answers: where they begin and end, and labels that are text."""

import numpy as np
import pytest

from ppinfer.errors import LogError
from ppinfer.plots import plot_likert
from ppinfer.studies.surveys import Instrument, read_survey

INSTRUMENT = """
columns = {subject = "user", condition = "robot"}
anchors = {1 = "no $x$", %d = "yes"}
items = {easy = {text = "It cost $5 and $6."}, slow = {reversed = true}}
conditions.robot = {b = "the $b$ robot", a = ""}
"""


def survey_of(folder, cells, top=5):
    text = "user,robot,easy,slow\n" + "".join(
        f"u{at},{robot},{cell},{cell}\n" for robot in "ab" for at, cell in enumerate(cells)
    )
    (folder / "answers.csv").write_text(text)
    return read_survey(folder / "answers.csv", Instrument.parse(INSTRUMENT % top))


def bars(ax):
    """Return from where to where each bar goes, by the height at which it is drawn."""
    found = {}
    for bar in ax.patches:
        found.setdefault(round(bar.get_y() + bar.get_height() / 2, 6), []).append(
            (bar.get_x(), bar.get_x() + bar.get_width())
        )
    return found


@pytest.mark.parametrize("top", [4, 5, 7])
def test_bars_add_up_to_all_answers_and_are_split_at_the_middle_of_the_scale(tmp_path, top):
    cells = [1, 2, 2, 3, top, top, top, top]
    ax = plot_likert(survey_of(tmp_path, cells, top))
    rows = bars(ax)
    assert len(rows) == 4
    below = (
        100
        * (sum(c < (top + 1) / 2 for c in cells) + sum(c == (top + 1) / 2 for c in cells) / 2)
        / len(cells)
    )
    for row in rows.values():
        assert len(row) == top
        assert row[0][0] == pytest.approx(-below)
        assert row[-1][1] - row[0][0] == pytest.approx(100)
        np.testing.assert_allclose([a[1] for a in row[:-1]], [b[0] for b in row[1:]], atol=1e-9)


def test_missing_answers_are_left_out_and_an_item_nobody_answered_has_no_bar(tmp_path):
    rows = bars(plot_likert(survey_of(tmp_path, ["", 5, 5, ""])))
    assert all(row[-1] == pytest.approx((0, 100)) for row in rows.values())
    empty = bars(plot_likert(survey_of(tmp_path, [""])))
    assert all(end == start for row in empty.values() for start, end in row)


def test_texts_of_the_instrument_are_never_read_as_mathematics(tmp_path):
    ax = plot_likert(survey_of(tmp_path, [1, 5]))
    ax.figure.canvas.draw()
    texts = [*ax.get_yticklabels(), *ax.get_legend().get_texts(), *ax.texts]
    assert any(text.get_text() == "the $b$ robot" for text in texts)
    assert any("$5" in text.get_text() for text in texts)
    for text in texts:
        assert "$" not in text.get_text() or not text.get_parse_math()


def test_conditions_have_the_order_and_titles_of_the_instrument(tmp_path):
    ax = plot_likert(survey_of(tmp_path, [1, 5]), ["slow"])
    assert [label.get_text() for label in ax.get_yticklabels()] == ["the $b$ robot", "a"]
    assert any(text.get_text() == "slow (scored in reverse)" for text in ax.texts)


def test_a_scale_of_many_points_is_drawn_without_numbers(tmp_path):
    ax = plot_likert(survey_of(tmp_path, [1, 50, 100], 100))
    assert len(ax.get_legend().get_texts()) == 2


def test_what_cannot_be_drawn_together_is_refused(tmp_path):
    survey = survey_of(tmp_path, [1, 5])
    with pytest.raises(LogError, match="no item 'fast'; there are easy, slow"):
        plot_likert(survey, ["fast"])
    with pytest.raises(LogError, match="no items"):
        plot_likert(survey, [])
    other = Instrument.parse((INSTRUMENT % 5).replace("reversed = true", "anchors = {0 = 'a', 5 = 'b'}"))
    mixed = read_survey(tmp_path / "answers.csv", other)
    with pytest.raises(LogError, match="answered on different numbers"):
        plot_likert(mixed)
