"""What is true of every page, whatever it is about."""

import re
from html.parser import HTMLParser

import numpy as np
import pytest

from ppinfer.errors import LogError
from ppinfer.report import write_report
from ppinfer.report.parts import SECTIONS
from ppinfer.studies import infer_log_personality, write_log, write_posterior, write_theta_posterior
from ppinfer.studies.recording import RecordingHeader, RecordingWriter
from ppinfer.studies.storage import write_signed
from ppinfer.studies.trials import Trial
from ppinfer.testing import example_interaction_log
from ppinfer.testing.example_plays import example_planned_log

from ..plots.plays import make_plays
from ..studies.posteriors import make_posterior
from .logs import reaches
from .pages import Page

HOSTILE = "<script>alert('1')</script> $x^{ =cmd()"


def _unsound():
    log = reaches()
    log["time"].values[5] = -1.0
    return log


def _with_other_names(log):
    names = {"robot": "arm", "human": "person"}
    log = log.assign_coords(agent=[names[str(name)] for name in log["agent"].values])
    told = [names[str(name)] for name in log["replan_agent"].values]
    return log.assign(replan_agent=("replan", np.array(told, dtype=object)))


LOGS = {
    "one agent with goals": reaches,
    "goals in 3-d": lambda: reaches(space=("x", "y", "z")),
    "goals on a line": lambda: reaches(space=("x",)),
    "no goals": lambda: reaches(goals=()),
    "no goals on a line": lambda: reaches(goals=(), space=("x",)),
    "three agents": lambda: reaches(agents=("walker", "cart", "dog")),
    "one participant": lambda: reaches(participants=("p1",)),
    "one condition": lambda: reaches(conditions=("a",)),
    "one trial": lambda: reaches(participants=("p1",), conditions=("a",), rounds=1),
    "two agents among goals": example_interaction_log,
    "parallel play": lambda: make_plays(robots=("norm", "bayes"), humans=("norm", "selfish"), scenes=1),
    "plans of agents without a part": lambda: _with_other_names(example_planned_log(trials=2, replans=3)),
    "an unsound log": _unsound,
}


class Headings(HTMLParser):
    """The headings of the sections of a page, in order."""

    def __init__(self, text):
        super().__init__()
        self.found, self._inside = [], False
        self.feed(text)

    def handle_starttag(self, tag, attrs):
        self._inside = tag == "h2"

    def handle_data(self, data):
        if self._inside:
            self.found.append(data)
            self._inside = False


def _check(report, given):
    text = report.page.read_text()
    page = Page(text)
    assert Headings(text).found == list(SECTIONS.values())
    assert page.tags.count("img") == len(report.figures)
    assert "script" not in page.tags
    assert all(re.match(r"#|data:image/png;base64,", address) for address in page.addresses)
    assert f"ppinfer report {given} -o report --at 0.25 0.5 0.75" in page.words
    assert re.search(r"file's SHA-256 [0-9a-f]{64}", page.words)
    assert " nan" not in page.words
    assert "None" not in page.words
    # no section is left empty
    assert not re.search(r"</h2>\s*</section>", text)
    return page


@pytest.mark.parametrize("kind", LOGS)
def test_every_kind_of_log_has_a_page_with_the_same_sections(tmp_path, kind):
    write_signed(LOGS[kind](), tmp_path / "log.nc")
    seen = []
    report = write_report(
        tmp_path / "log.nc", tmp_path / "report", progress=lambda done, total: seen.append((done, total))
    )
    _check(report, "log.nc")
    assert seen == [(done, len(report.figures)) for done in range(1, len(report.figures) + 1)]


def test_posteriors_have_the_same_sections(tmp_path):
    write_posterior(make_posterior(), tmp_path / "goals.nc")
    write_theta_posterior(
        infer_log_personality(example_planned_log(trials=2, replans=3)), tmp_path / "theta.nc"
    )
    for name in ("goals.nc", "theta.nc"):
        page = _check(write_report(tmp_path / name, tmp_path / name.removesuffix(".nc")), name)
        assert "The posterior is sound: its checks found nothing" in page.words
        assert "The command that made the posterior:" in page.words


def test_a_log_of_zarr_and_a_recording_have_the_page_of_their_netcdf(tmp_path):
    log = reaches()
    write_log(log, tmp_path / "log.nc")
    write_log(log, tmp_path / "log.zarr")
    told = write_report(tmp_path / "log.nc", tmp_path / "report").to_json()
    zarr = write_report(tmp_path / "log.zarr", tmp_path / "zarr")
    _check(zarr, "log.zarr")
    assert zarr.to_json()["scores"] == told["scores"]
    assert zarr.to_json()["metrics"] == told["metrics"]


def test_a_recording_of_a_running_study_has_a_page(tmp_path):
    with RecordingWriter(tmp_path / "study.jsonl", RecordingHeader(agents=("human",))) as recording:
        for name in ("a", "b"):
            position = np.cumsum(np.full((4, 1, 2), 0.1), axis=0)
            recording.append(Trial(name, "p1", time=0.1 * np.arange(4), position=position))
    with (tmp_path / "study.jsonl").open("ab") as file:
        file.write(b'{"crc": "torn')
    report = write_report(tmp_path / "study.jsonl", tmp_path / "report")
    page = _check(report, "study.jsonl")
    assert report.fault_warnings[0].kind == "torn-line"
    assert "torn-line" in page.words
    assert report.trials == ("a", "b")
    (row,) = (row for row in report.to_json()["metrics"]["groups"] if row["metric"] == "duration_s")
    assert (row["mean"], row["trials"]) == (pytest.approx(0.3), 2)


def test_an_unsound_log_has_its_sheet_and_its_faults_and_no_conclusions(tmp_path):
    write_signed(_unsound(), tmp_path / "log.nc")
    report = write_report(tmp_path / "log.nc", tmp_path / "report")
    page = _check(report, "log.nc")
    assert [fault.kind for fault in report.faults] == ["time-not-increasing"]
    assert report.figures == ()
    assert report.scores is None
    assert report.metrics is None
    assert report.tests is None
    for part in (
        "trials 12 participants 3",
        "The log is not sound: its checks found 1 fault",
        "time-not-increasing trial p1-a-0, sample 5, column time 1",
        "Nothing is concluded from an unsound log.",
    ):
        assert part in page.words, part


def test_a_log_that_lacks_what_a_sheet_is_made_of_has_a_page_with_its_sizes(tmp_path):
    log = reaches().drop_vars(["participant"])
    write_signed(log, tmp_path / "log.nc")
    page = _check(write_report(tmp_path / "log.nc", tmp_path / "report"), "log.nc")
    assert "missing-variable" in page.words
    assert "sample 144" in page.words


def test_damaged_files_are_refused_and_nothing_is_written(tmp_path):
    log = reaches()
    write_signed(log, tmp_path / "log.nc")
    log["time"].values[5] += 0.001
    log.attrs["content_sha256"] = "0" * 64
    log.to_netcdf(tmp_path / "edited.nc", engine="h5netcdf")
    whole = (tmp_path / "log.nc").read_bytes()
    (tmp_path / "torn.nc").write_bytes(whole[: len(whole) // 2])
    (tmp_path / "text.nc").write_text("no log")
    for name in ("edited", "torn", "text", "nowhere"):
        with pytest.raises(LogError):
            write_report(tmp_path / f"{name}.nc", tmp_path / "report")
    assert not (tmp_path / "report").exists()


@pytest.mark.parametrize("options", [{}, {"human": HOSTILE}])
def test_names_from_a_log_are_text_on_the_page_and_in_pictures(tmp_path, options, drawn_figures):
    log = reaches(
        agents=(HOSTILE, "_cart"),
        space=("<b>x</b>", "$y", "_z"),
        goals=(HOSTILE, "_pan"),
        participants=(HOSTILE, "p2"),
        conditions=(HOSTILE, "$b"),
        rounds=1,
    )
    log.attrs |= {"title": HOSTILE, "source": HOSTILE, "configuration": HOSTILE, "notes": HOSTILE}
    log.attrs[HOSTILE] = HOSTILE
    write_log(log, tmp_path / "log.nc")
    report = write_report(tmp_path / "log.nc", tmp_path / "report", **options)
    text = report.page.read_text()
    assert "<script" not in text
    page = Page(text)
    assert "<b>x" not in text
    assert page.words.count(HOSTILE) > 8


def test_what_is_asked_of_a_file_that_has_no_use_for_it_is_refused(tmp_path):
    write_log(reaches(goals=()), tmp_path / "log.nc")
    write_posterior(make_posterior(), tmp_path / "post.nc")
    for name, options, message in (
        ("log.nc", {"at": [0.3]}, "at chooses segments with a goal"),
        ("log.nc", {"model": "nearest"}, "model chooses how goals are inferred, and this log has none"),
        ("log.nc", {"human": "cat"}, "--human cat: there is no such agent in the log; there are walker"),
        ("log.nc", {"trials": ["t9"]}, "unknown trial 't9'"),
        ("log.nc", {"participants": ["p9"]}, "unknown participant 'p9'"),
        ("post.nc", {"model": "nearest"}, "model chooses what is inferred of a log"),
        ("post.nc", {"robot": "arm"}, "robot chooses what is inferred of a log"),
    ):
        with pytest.raises(LogError, match=re.escape(message)):
            write_report(tmp_path / name, tmp_path / "report", **options)
    assert not (tmp_path / "report").exists()
