"""Whatever participants, conditions, goals and trials are called is text: on terminals, in tables, in pictures."""

from __future__ import annotations

import csv
import json
import re
from html.parser import HTMLParser

import numpy as np
import pytest

from ppinfer import plots
from ppinfer.cli import main
from ppinfer.goals import GoalLQR
from ppinfer.studies import infer_log, infer_log_conditional, read_log, write_log
from ppinfer.studies.calibration import calibrate_posterior
from ppinfer.studies.interaction import read_interaction, stretches
from ppinfer.studies.metrics import trial_metrics
from ppinfer.studies.posterior import open_posterior, write_posterior
from ppinfer.studies.scores import score_posterior
from ppinfer.testing import example_interaction_log, example_log, example_planned_log

from .hostile_names import GOALS, NAMES, hostile


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """Logs and a posterior in which everything has a hostile name."""
    where = tmp_path_factory.mktemp("hostile")
    log = hostile(example_log(participants=9, trials=2))
    write_log(log, where / "log.nc")
    write_log(hostile(example_interaction_log(trials=4)), where / "game.nc")
    write_log(hostile(example_planned_log(trials=4, replans=2)), where / "plays.nc")
    write_posterior(infer_log(log, GoalLQR()), where / "post.nc")
    write_posterior(infer_log(log, GoalLQR(rationality=0.001)), where / "other.nc")
    return where


COMMANDS = {
    "validate": ("validate", "log.nc"),
    "infer": ("infer", "log.nc", "-o", "{out}.nc"),
    "infer personality": ("infer", "plays.nc", "--model", "personality", "-o", "{out}.nc"),
    "fit": ("fit", "log.nc", "--model", "nearest", "-o", "{out}.toml"),
    "score": ("score", "post.nc", "--by-participant"),
    "compare": ("compare", "post.nc", "other.nc"),
    "metrics": ("metrics", "game.nc", "--by", "condition", "-o", "{out}.csv"),
    "metrics by participant": ("metrics", "log.nc", "--by", "participant", "--learning-by", "condition"),
    "report": ("report", "post.nc", "-o", "{out}"),
    "report on a log": ("report", "game.nc", "-o", "{out}"),
    "report on plays": ("report", "plays.nc", "-o", "{out}"),
}


REPORTS = tuple(name for name in COMMANDS if name.startswith("report"))


def ran(name, folder, out, capsys, *more):
    argv = [part.replace("{out}", str(out / "made")) for part in COMMANDS[name]]
    argv = [str(folder / part) if (folder / part).is_file() else part for part in argv]
    status = main([*argv, *more])
    told = capsys.readouterr()
    assert status == 0, told.err
    return told


def acts_on_a_terminal(text):
    return not text.replace("\n", "").isprintable()


@pytest.mark.parametrize("name", COMMANDS)
def test_what_a_command_prints_acts_on_no_terminal_and_is_no_markup(folder, tmp_path, capsys, name):
    told = ran(name, folder, tmp_path, capsys)
    assert not acts_on_a_terminal(told.out)
    assert not acts_on_a_terminal(told.err)
    if name in REPORTS:
        hold_the_page(tmp_path / "made")
        return
    told = ran(name, folder, tmp_path, capsys, "--json")
    assert not acts_on_a_terminal(told.out)
    json.loads(told.out)


def test_names_are_printed_as_they_are_and_come_back_from_json_exactly(folder, tmp_path, capsys):
    assert "[bold]x[/bold]" in ran("score", folder, tmp_path, capsys).out
    found = json.loads(ran("score", folder, tmp_path, capsys, "--json").out)
    assert NAMES[6] in json.dumps(found, ensure_ascii=False).replace("\\u001b", "\x1b").replace(
        "\\u0007", "\x07"
    )


@pytest.mark.parametrize(
    "argv",
    [
        ("infer", "log.nc", "-o", "x.nc", "--agent", "\x1b[31m"),
        ("score", "\x1b[31m.nc"),
        ("metrics", "log.nc", "--by", "\x1b[31m"),
        ("report", "post.nc", "-o", "x", "--trials", "\x1b[31m"),
        ("convert", "log.nc", "--from", "eth", "-o", "x.nc"),
    ],
)
def test_a_refusal_is_one_printable_line(folder, monkeypatch, capsys, argv):
    monkeypatch.chdir(folder)
    try:
        status = main(list(argv))
    except SystemExit as left:
        status = left.code
    assert status
    told = capsys.readouterr()
    assert told.err.count("\n") == 1 or argv[0] == "convert"
    assert not acts_on_a_terminal(told.err)


class Page(HTMLParser):
    """What a browser would make of a page: elements, attributes that run, and text."""

    def __init__(self, text):
        super().__init__()
        self.running, self.text = [], ""
        self.feed(text)

    def handle_starttag(self, tag, attrs):
        if tag in ("script", "iframe", "object", "embed", "base", "form"):
            self.running.append(tag)
        self.running += [
            name for name, value in attrs if name.startswith("on") or "javascript:" in (value or "")
        ]

    def handle_data(self, data):
        self.text += data


def hold_the_page(folder):
    """Hold that a report shows names as text, runs nothing, and calls its pictures what it likes."""
    text = (folder / "index.html").read_text(encoding="utf-8")
    page = Page(text)
    assert not page.running
    assert "<b>$" not in text
    assert "alert(1)" in page.text
    assert not acts_on_a_terminal(text.replace("\u00a0", " "))
    for figure in (folder / "figures").iterdir():
        assert re.fullmatch(r"[a-z0-9-]+\.(png|json)", figure.name), figure.name


def test_no_cell_of_a_table_is_a_formula(folder, tmp_path, capsys):
    ran("metrics", folder, tmp_path, capsys)
    with (tmp_path / "made.csv").open(newline="", encoding="utf-8") as file:
        rows = list(csv.reader(file))
    cells = [cell for row in rows for cell in row]
    assert any("cmd()" in cell for cell in cells)
    number = re.compile(r"[+-]?[0-9.]+(e[+-]?[0-9]+)?")
    for cell in cells:
        assert not cell.startswith(tuple("=+-@\t\r")) or number.fullmatch(cell), cell
        assert not acts_on_a_terminal(cell), cell


def pictures(folder):
    """Yield every picture of `ppinfer.plots` that a log or a posterior can give, by its function's name."""
    log, game, plays = (read_log(folder / f"{name}.nc") for name in ("log", "game", "plays"))
    with open_posterior(folder / "post.nc", load=True) as posterior:
        scores = score_posterior(posterior, at=[0.5])
        yield plots.plot_posterior_over_time(posterior, 3)
        yield plots.plot_path(posterior, 3)
        yield plots.plot_reliability(calibrate_posterior(posterior).top_label)
        yield plots.plot_score_over_share(scores.overall, "accuracy")
        yield plots.plot_participants(scores.by_participant)
    beliefs = infer_log_conditional(game)
    yield plots.plot_conditional_belief(
        read_interaction(game, beliefs, stretches(game, "human")[1]), title=NAMES[4]
    )
    metrics = trial_metrics(log)
    yield plots.plot_metric_by_condition(metrics, resamples=50)
    yield plots.plot_learning_effects(metrics)
    yield plots.plot_log_paths(log)
    for trial in range(len(NAMES)):
        yield plots.plot_trial_paths(log, trial)
    for trial in range(4):
        yield plots.plot_personality(plays, trial)
        yield plots.plot_hand_distance(plays, trial)


def test_pictures_show_names_as_text(folder):
    drawn = 0
    for axes in pictures(folder):
        for ax in np.atleast_1d(axes):
            # names that are formulas would fail here, and letters that no font has would warn
            ax.figure.canvas.draw()
            drawn += 1
    assert drawn > 30


@pytest.mark.parametrize("name", [*NAMES, *GOALS])
def test_a_label_draws_alone(name):
    from ppinfer.plots.labels import as_plain_text, label
    from ppinfer.plots.palette import new_axes

    ax = new_axes()
    ax.plot([0, 1], label=f"goal {name}")
    ax.set_title(name)
    ax.set_xticks([0, 1], labels=[name, "b"])
    ax.annotate(name, (0, 0))
    ax.legend()
    as_plain_text(ax)
    ax.figure.canvas.draw()
    assert ax.get_xticklabels()[0].get_text() == label(name)
    assert len(label(name)) <= 60
    assert label(name, most=10**6).isprintable() or "\n" in name
    assert "$" not in name or "$" in ax.get_title()
