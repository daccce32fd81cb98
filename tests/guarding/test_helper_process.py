"""Files are read by a process of their own: whatever happens to it, this one goes on and says what was wrong."""

from __future__ import annotations

import json
import os
import subprocess
import sys
import tempfile
import threading
from pathlib import Path

import pytest

from ppinfer import guarding
from ppinfer.errors import LogError, PPInferError
from ppinfer.guarding import process
from ppinfer.guarding.answers import error_told, told_error
from ppinfer.studies.faults import Fault, Faults, FaultyLogError

ROOT = Path(__file__).parents[2]


@pytest.fixture(scope="module", autouse=True)
def light_helper():
    """Run helpers that load nothing in advance: they are started often here."""
    process.end_helper()
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(process, "PRELOADED", ())
        yield
        process.end_helper()


def ask(folder, what, name="bad.txt", **limits):
    """Ask for a reader that does what the file says."""
    path = Path(folder, name)
    path.write_text(what)
    with guarding.limited(**limits):
        return guarding.asked("misbehave", path)


def test_a_reader_answers_through_the_helper_process(tmp_path):
    answer = ask(tmp_path, "hello", memory=123_456_789)
    assert answer == {"said": "hello", "memory": 123_456_789}


@pytest.mark.parametrize("what", ["hang", "spin"])
def test_a_reader_that_does_not_end_is_refused_at_its_limit(tmp_path, what):
    with pytest.raises(
        LogError, match=r"bad.txt: reading it takes more than 0.3 s.*PPINFER_GUARD_SECONDS=3 "
    ):
        ask(tmp_path, what, seconds=0.3)
    assert ask(tmp_path, "hello")["said"] == "hello"


def test_a_reader_that_takes_too_much_memory_is_refused(tmp_path):
    with pytest.raises(
        LogError, match=r"takes more than 64 MiB of memory.*PPINFER_GUARD_MEMORY=1G .*GUARD=off"
    ):
        ask(tmp_path, "allocate", memory=1 << 26)
    assert ask(tmp_path, "hello")["said"] == "hello"


@pytest.mark.parametrize(
    ("what", "told"),
    [
        ("crash", r"crashed the library that reads it \(SIGSEGV\).*damaged"),
        ("exit", r"crashed the library that reads it \(exit status 3\)"),
        ("recurse", "nested too deeply"),
        ("stumble", "KeyError: 'a bug of the reader'; the file is damaged"),
        ("refuse", "bad.txt: line 1: says 'refuse'$"),
    ],
)
def test_what_goes_wrong_is_one_clear_error_and_the_next_file_is_read(tmp_path, what, told):
    with pytest.raises(LogError, match=told) as raised:
        ask(tmp_path, what)
    assert "\n" not in str(raised.value)
    assert ask(tmp_path, "hello")["said"] == "hello"


def test_a_reader_cannot_write(tmp_path):
    with pytest.raises(OSError, match="File too large"):
        ask(tmp_path, "write")
    assert not (tmp_path / "bad.txt.written").read_bytes()


def test_an_error_of_the_file_system_is_the_same_error_here(tmp_path):
    with pytest.raises(FileNotFoundError) as raised:
        ask(tmp_path, "missing")
    assert raised.value.filename == f"{tmp_path / 'bad.txt'}.none"


def test_faults_come_back_as_they_were():
    faults = Faults(
        Fault("not-finite", "x is inf", "mark a dropout", line=line, column="x") for line in range(30)
    )
    told = FaultyLogError("log.csv", faults)
    again = error_told(json.loads(json.dumps(told_error(told))))
    assert isinstance(again, FaultyLogError)
    assert (str(again), again.lines, again.counts) == (str(told), told.lines, told.counts)
    assert again.faults == told.faults


def test_progress_is_told_here(tmp_path):
    seen = []
    (tmp_path / "good.txt").write_text("hello")
    guarding.asked(
        "misbehave", tmp_path / "good.txt", progress=lambda done, total: seen.append((done, total))
    )
    assert seen == [(1, 2)]


def test_an_interruption_ends_the_helper_so_that_no_answer_is_taken_for_another(tmp_path):
    (tmp_path / "bad.txt").write_text("hello")

    def interrupt(done, total):
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        guarding.asked("misbehave", tmp_path / "bad.txt", progress=interrupt)
    assert ask(tmp_path, "again")["said"] == "again"


def test_a_helper_that_was_killed_is_replaced(tmp_path):
    ask(tmp_path, "hello")
    process._helper.process.kill()
    process._helper.process.wait()
    assert ask(tmp_path, "again")["said"] == "again"


def test_threads_wait_for_each_other(tmp_path):
    said = {}

    def one(index):
        said[index] = ask(tmp_path, f"number {index}", name=f"{index}.txt")["said"]

    threads = [threading.Thread(target=one, args=(index,)) for index in range(8)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert said == {index: f"number {index}" for index in range(8)}


@pytest.mark.skipif(not hasattr(os, "fork"), reason="this system has no fork")
def test_a_forked_copy_of_this_process_has_a_helper_of_its_own():
    code = """
import os
from ppinfer import guarding
from ppinfer.guarding import process
from pathlib import Path

Path("a.txt").write_text("hello")
guarding.asked("misbehave", "a.txt")
first = process._helper.process.pid
child = os.fork()
if child == 0:
    assert process._helper is None
    assert guarding.asked("misbehave", "a.txt")["said"] == "hello"
    assert process._helper.process.pid != first
    process.end_helper()
    os._exit(0)
assert os.waitpid(child, 0)[1] == 0
assert guarding.asked("misbehave", "a.txt")["said"] == "hello"
assert process._helper.process.pid == first
print(first)
"""
    ran = run_python(code)
    assert_gone(int(ran))


def test_the_helper_is_gone_when_its_process_was_killed(tmp_path):
    code = """
import os, signal
from ppinfer import guarding
from ppinfer.guarding import process
from pathlib import Path

Path("a.txt").write_text("hello")
guarding.asked("misbehave", "a.txt")
print(process._helper.process.pid, flush=True)
os.kill(os.getpid(), signal.SIGKILL)
"""
    assert_gone(int(run_python(code, status=-9)))


def test_nothing_is_imported_from_the_folder_that_somebody_is_in(tmp_path):
    (tmp_path / "numpy.py").write_text("print('gotcha')")
    (tmp_path / "json.py").write_text("print('gotcha')")
    code = f"""
import os, sys
from ppinfer import guarding
os.chdir({str(tmp_path)!r})
with open("a.txt", "w") as file:
    file.write("hello")
print(guarding.asked("misbehave", "a.txt")["said"])
"""
    assert run_python(code) == "hello"


def test_a_script_without_a_main_guard_is_not_run_again(tmp_path):
    script = tmp_path / "script.py"
    script.write_text(
        f"{LIGHT}from ppinfer import guarding\nprint('once')\n__import__('pathlib').Path('a.txt').write_text('hello')\n"
        "print(guarding.asked('misbehave', 'a.txt')['said'])\n"
    )
    ran = subprocess.run(
        [sys.executable, "script.py"],
        cwd=tmp_path,
        env=environment(),
        capture_output=True,
        text=True,
        check=True,
    )
    assert ran.stdout == "once\nhello\n"


def test_where_no_helper_can_be_started_the_file_is_not_opened(tmp_path, monkeypatch):
    process.end_helper()
    monkeypatch.setattr(process, "_START", "raise SystemExit('no such thing')")
    with pytest.raises(LogError, match=r"cannot be started \(no such thing\).*PPINFER_GUARD=off"):
        ask(tmp_path, "hello")
    monkeypatch.undo()
    assert ask(tmp_path, "hello")["said"] == "hello"


def test_without_forks_there_is_a_process_for_each_file(tmp_path, monkeypatch):
    process.end_helper()
    monkeypatch.setattr(process, "FORKING", False)
    assert ask(tmp_path, "hello")["said"] == "hello"
    with pytest.raises(LogError, match="says 'refuse'"):
        ask(tmp_path, "refuse")
    monkeypatch.setattr(process, "_GRACE_SECONDS", 0.1)
    with pytest.raises(LogError, match=r"takes more than 0\.3 s"):
        ask(tmp_path, "hang", seconds=0.3)
    assert process._helper is None


def test_a_file_that_is_there_already_is_asked_for_once(tmp_path):
    path = tmp_path / "known.txt"
    path.write_text("first")
    with guarding.admitted("misbehave", path) as known:
        assert known["said"] == "first"
    process.end_helper()
    with guarding.admitted("misbehave", path) as known:
        assert known["said"] == "first"
    assert process._helper is None
    path.write_text("other")
    with guarding.admitted("misbehave", path) as known:
        assert known["said"] == "other"


def test_a_file_that_is_changed_while_it_is_read_is_refused(tmp_path):
    path = tmp_path / "log.txt"
    path.write_text("first")
    with (
        pytest.raises(LogError, match="was changed while it was being read"),
        guarding.admitted("misbehave", path),
    ):
        path.write_text("second")


def test_what_this_process_wrote_or_trusts_is_not_asked_for(tmp_path, monkeypatch):
    path = tmp_path / "mine.txt"
    path.write_text("crash")
    guarding.remember_written(path)
    assert guarding.asked("misbehave", path) is None
    path.write_text(" crash ")
    with guarding.trusting():
        assert guarding.asked("misbehave", path) is None
    with pytest.raises(LogError, match="crashed"):
        guarding.asked("misbehave", path)
    monkeypatch.setenv("PPINFER_GUARD", "off")
    assert guarding.asked("misbehave", path) is None


@pytest.mark.parametrize(
    ("variable", "value", "told"),
    [
        ("PPINFER_GUARD", "maybe", "'on' or 'off' is expected"),
        ("PPINFER_GUARD_SECONDS", "soon", "expected a positive number such as '120'"),
        ("PPINFER_GUARD_SECONDS", "-1", "expected a positive number"),
        ("PPINFER_GUARD_MEMORY", "lots", "such as '8G' or a number of bytes"),
    ],
)
def test_a_setting_that_says_nothing_is_refused(tmp_path, monkeypatch, variable, value, told):
    monkeypatch.setenv(variable, value)
    with pytest.raises(PPInferError, match=told):
        ask(tmp_path, "hello")


@pytest.mark.parametrize(
    ("told", "expected"), [("2G", 2 << 30), ("512MiB", 512 << 20), ("1.5 K", 1536), ("4096", 4096)]
)
def test_memory_is_told_in_the_units_of_people(monkeypatch, told, expected):
    monkeypatch.setenv("PPINFER_GUARD_MEMORY", told)
    assert guarding.limits_for(10**9).memory == expected


def test_limits_grow_with_the_file():
    small, large = guarding.limits_for(1_000), guarding.limits_for(1_000_000_000)
    assert (small.seconds, large.seconds) == (pytest.approx(30.0, abs=0.01), 530.0)
    assert large.memory == (1 << 30) + 20_000_000_000


@pytest.mark.parametrize("limits", [{"seconds": 0}, {"memory": -1}])
def test_limits_are_positive(limits):
    with pytest.raises(PPInferError, match="limits are positive"), guarding.limited(**limits):
        pass


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="this system has no named pipes")
def test_a_pipe_is_refused_and_never_waited_for(tmp_path):
    os.mkfifo(tmp_path / "log.nc")
    with pytest.raises(LogError, match=r"log.nc: is a pipe; give a file"):
        guarding.asked("validate-log", tmp_path / "log.nc")
    with (
        guarding.trusting(),
        pytest.raises(LogError, match="is a pipe"),
        guarding.admitted("log", tmp_path / "log.nc"),
    ):
        pass


LIGHT = "from ppinfer.guarding import process\nprocess.PRELOADED = ()\n"


def environment():
    # an empty entry would be the folder that a test is in
    path = [str(ROOT), str(ROOT / "sim"), *filter(None, os.environ.get("PYTHONPATH", "").split(os.pathsep))]
    return os.environ | {"PYTHONPATH": os.pathsep.join(path)}


def run_python(code, status=0):
    """Return what a new interpreter prints; complaints count as failures."""
    ran = subprocess.run(
        [sys.executable, "-W", "error", "-c", LIGHT + code],
        cwd=tempfile.mkdtemp(),
        env=environment(),
        capture_output=True,
        text=True,
        check=False,
    )
    assert ran.returncode == status, ran.stderr
    assert not ran.stderr
    return ran.stdout.strip()


def assert_gone(pid):
    """Wait until a process that was told to end has ended."""
    for _ in range(2000):
        try:
            stat = Path(f"/proc/{pid}/stat").read_text() if Path("/proc").is_dir() else ""
            os.kill(pid, 0)
        except (ProcessLookupError, FileNotFoundError):
            return
        if ") Z " in stat:
            # it has ended; whoever adopted it has not looked yet
            return
        threading.Event().wait(0.01)
    raise AssertionError(f"process {pid} is still there")
