import json
from importlib.resources import files

import jsonschema
import pytest

from ppinfer.studies import open_log
from ppsim.cli import main

SHORT = ["record", "reaching", "--trials", "3", "--seed", "2", "--duration", "8"]


def test_a_log_is_recorded_and_its_json_fits_its_schema(tmp_path, capsys):
    target = tmp_path / "log.nc"
    assert main([*SHORT, "-o", str(target), "--json"]) == 0
    printed = capsys.readouterr()
    told = json.loads(printed.out)
    schema = json.loads((files("ppsim") / "schemas" / "record.schema.json").read_text())
    jsonschema.Draft202012Validator.check_schema(schema)
    jsonschema.validate(told, schema, cls=jsonschema.Draft202012Validator)
    assert printed.err == ""
    with open_log(target) as log:
        assert log.sizes["trial"] == told["trials"] == 3
        assert log.sizes["segment"] == sum(told["segments"].values())


def test_the_summary_names_the_next_command(tmp_path, capsys):
    target = tmp_path / "log.nc"
    assert main([*SHORT, "-o", str(target)]) == 0
    assert f"next: ppinfer infer {target} -o POST.nc" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("extra", "told"),
    [
        (["--trials", "0"], "trials must be at least 1; got 0"),
        (["--workers", "0"], "workers must be at least 1; got 0"),
        (["--goals", "1"], "1 goals are too few for 2 agents"),
        (["--stay", "1.5"], "stay must lie in [0, 1]; got 1.5"),
        (
            ["--dynamics", "rocket"],
            "dynamics must be one of single-integrator, double-integrator; got 'rocket'",
        ),
    ],
)
def test_bad_options_are_one_line_and_leave_nothing_behind(extra, told, tmp_path, capsys):
    assert main([*SHORT, *extra, "-o", str(tmp_path / "log.nc")]) == 1
    printed = capsys.readouterr()
    assert printed.err.count("\n") == 1
    assert told in printed.err
    assert printed.out == ""
    assert list(tmp_path.iterdir()) == []


def test_a_target_that_cannot_be_written_is_refused_before_anything_is_played(tmp_path, capsys):
    assert main([*SHORT, "-o", str(tmp_path / "nowhere" / "log.nc")]) == 1
    assert "there is no folder" in capsys.readouterr().err
    assert main([*SHORT, "-o", str(tmp_path / "log.csv")]) == 1
    assert "log.csv: a study log is written as .nc" in capsys.readouterr().err


def test_an_argument_that_is_no_number_is_a_usage_error(tmp_path, capsys):
    with pytest.raises(SystemExit) as stopped:
        main([*SHORT, "--noise", "loud", "-o", str(tmp_path / "log.nc")])
    assert stopped.value.code == 2
    assert capsys.readouterr().err.count("\n") == 1


def test_an_interruption_says_where_the_trials_are_and_how_to_keep_them(tmp_path, capsys, monkeypatch):
    from ppsim.reaching import ReachingStudy

    play = ReachingStudy.trial

    def trial(study, index):
        if index == 2:
            raise KeyboardInterrupt
        return play(study, index)

    target = tmp_path / "log.nc"
    with monkeypatch.context() as patched:
        patched.setattr(ReachingStudy, "trial", trial)
        assert main([*SHORT, "-o", str(target)]) == 130
    told = capsys.readouterr().err
    assert f"ppinfer convert {tmp_path / 'log.recording.jsonl'} -o {target} --from recording" in told
    assert main([*SHORT, "-o", str(target)]) == 0
    assert "went on from 2 trials" in capsys.readouterr().out
    assert [path.name for path in tmp_path.iterdir()] == ["log.nc"]


def test_help_shows_an_example(capsys):
    with pytest.raises(SystemExit):
        main(["record", "reaching", "--help"])
    told = capsys.readouterr().out
    assert "ppsim record reaching --trials 24 --seed 7 -o LOG.nc" in told
    assert "(default: 0.03)" in told
