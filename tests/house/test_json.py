"""What every command prints with `--json` is described by a schema of its own."""

from __future__ import annotations

import argparse
import json
from importlib.resources import files

import jsonschema
import pytest

from ppinfer.cli import COMMANDS, build_parser
from ppinfer.studies import write_log
from ppinfer.testing import example_log
from ppinfer.testing.example_plays import example_planned_log
from ppinfer.testing.prediction_examples import example_store

from .pages import ROOT, run_command

SMALL = ROOT / "data" / "reaching-small.nc"
TABLE = "game,person,t,px,py,aim\n" + "".join(
    f"g{game},p{game % 2},{step / 10},{step * (1 - game % 2) / 10},{step / 20},{'pan' if game % 2 else 'cup'}\n"
    for game in range(4)
    for step in range(20)
)
MAPPING = """
[columns]
trial = "game"
participant = "person"
time = "t"
x = "px"
y = "py"
true_goal = "aim"

[constants]
agent = "human"

[units]
time = "s"
position = "m"

[goals]
cup = [0.0, 1.0]
pan = [2.0, 1.0]
"""

ANSWERS = "person,robot,easy,slow\n" + "".join(
    f"p{person},{robot},{1 + (person + at) % 5},{5 - (2 * person + at) % 5}\n"
    for person in range(4)
    for at, robot in enumerate(("one", "two"))
)
INSTRUMENT = """
columns = {subject = "person", condition = "robot"}
anchors = {1 = "no", 5 = "yes"}
items = {easy = {}, slow = {reversed = true}}
scales.ease.items = ["easy", "slow"]
"""
ORDERS = "person,first,second\np0,one,two\np1,two,one\np2,one,\n"


def schema_of(command):
    """Return the schema of a command."""
    return json.loads(
        (files("ppinfer.cli") / "schemas" / f"{command}.schema.json").read_text(encoding="utf-8")
    )


def parser_of(command):
    """Return the argument parser of a command."""
    actions = build_parser()._actions
    choices = next(action.choices for action in actions if isinstance(action, argparse._SubParsersAction))
    return choices[command]


def objects_of(schema):
    """Yield every object that a schema describes."""
    if schema.get("type") == "object" or "properties" in schema:
        yield schema
    for part in (
        *schema.get("properties", {}).values(),
        schema.get("items"),
        *schema.get("$defs", {}).values(),
    ):
        if isinstance(part, dict):
            yield from objects_of(part)


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """Return a folder with two logs, two posteriors and a fitted model, made by the commands themselves."""
    folder = tmp_path_factory.mktemp("commands")
    log = folder / "log.nc"
    if SMALL.exists():
        log.write_bytes(SMALL.read_bytes())
    else:
        write_log(example_log(), log)
    write_log(example_planned_log(trials=2, replans=3), folder / "plays.nc")
    example_store(folder / "examples.zarr", 60)
    (folder / "table.csv").write_text(TABLE)
    (folder / "mapping.toml").write_text(MAPPING)
    for name, text in (("answers.csv", ANSWERS), ("survey.toml", INSTRUMENT), ("orders.csv", ORDERS)):
        (folder / name).write_text(text)
    for name, model in (("near", "nearest"), ("lqr", "goal-lqr")):
        status, _, err = run_command(f"ppinfer infer {log} -o {folder / name}.nc --model {model}")
        assert status == 0, err
    return folder


LINES = {
    "convert": ["convert {0}/table.csv -o {0}/made.nc --from tidy --mapping {0}/mapping.toml"],
    "validate": ["validate {0}/log.nc", "validate {0}/near.nc", "validate {0}/plays.nc"],
    "fit": [
        "fit {0}/log.nc --model nearest -o {0}/near.toml",
        "fit {0}/log.nc --model heading --folds 0 -o {0}/head.toml",
        "fit {0}/log.nc --model goal-lqr --objective likelihood --folds 0 -o {0}/lqr.toml",
    ],
    "infer": [
        "infer {0}/log.nc -o {0}/again.nc --model goal-lqr --mode smooth --set stay=0.98",
        "infer {0}/log.nc -o {0}/again.nc --model goal-kalman",
        "infer {0}/log.nc -o {0}/again.nc --model heading",
        "infer {0}/plays.nc -o {0}/theta.nc --model personality",
        "infer {0}/plays.nc -o {0}/theta.nc --model personality --agent human --variant literal",
    ],
    "score": ["score {0}/lqr.nc --at 0.5 1 --by-participant"],
    "compare": ["compare {0}/near.nc {0}/lqr.nc --at 0.5 --resamples 100"],
    "anova": [
        "anova {0}/table.csv --dv px py --within person --subject t --repeated mean --posthoc holm",
    ],
    "metrics": [
        "metrics {0}/log.nc --by participant --learning-by participant --resamples 100 -o {0}/trials.csv",
        "metrics {0}/plays.nc --names total_s stops",
    ],
    "survey": [
        "survey {0}/answers.csv --instrument {0}/survey.toml --orders {0}/orders.csv -o {0}/scores.csv",
        "survey {0}/answers.csv --instrument {0}/survey.toml --keep-ids --missing drop-responses",
    ],
    "report": ["report {0}/lqr.nc -o {0}/report"],
    "notebooks": ["notebooks {0}/books --copy-only", "notebooks --list"],
    "learn": ["learn {0}/examples.zarr -o {0}/m.safetensors --epochs 1 --hidden 4 --sizes 10 20"],
}


def test_every_command_is_tried():
    assert set(LINES) == set(COMMANDS)


@pytest.mark.parametrize(("command", "line"), [(name, line) for name in LINES for line in LINES[name]])
def test_a_command_prints_one_json_object_that_its_schema_describes(folder, command, line):
    if command == "learn":
        pytest.importorskip("torch", reason="needs the extra: pip install 'ppinfer[learned]'")
    status, out, err = run_command(f"ppinfer {line.format(folder)} --json")
    assert status == 0, err
    jsonschema.validate(json.loads(out), schema_of(command), cls=jsonschema.Draft202012Validator)


@pytest.mark.parametrize("command", COMMANDS)
def test_a_schema_leaves_nothing_open(command):
    schema = schema_of(command)
    jsonschema.Draft202012Validator.check_schema(schema)
    assert schema["$schema"] == "https://json-schema.org/draft/2020-12/schema"
    assert schema["title"] == f"What ppinfer {command} --json prints"
    for described in objects_of(schema):
        assert "additionalProperties" in described, described
    assert schema["additionalProperties"] is False
    assert set(schema["required"]) <= set(schema["properties"])


@pytest.mark.parametrize("command", COMMANDS)
def test_every_command_has_help_with_an_example_and_json(command):
    help_text = parser_of(command).format_help()
    assert f"ppinfer {command} " in help_text.partition("example")[2]
    assert "--json" in help_text
    for action in parser_of(command)._actions:
        assert action.help, f"ppinfer {command}: {action.dest} has no help"


@pytest.mark.parametrize("command", COMMANDS)
def test_the_documentation_describes_every_argument_and_every_property(command):
    text = (ROOT / "docs" / "commands.md").read_text(encoding="utf-8")
    section = text.partition(f"\n## ppinfer {command}\n")[2].partition("\n## ")[0]
    assert section, f"docs/commands.md has no section on ppinfer {command}"
    flags = {
        flag
        for action in parser_of(command)._actions
        for flag in action.option_strings
        if flag.startswith("--")
    }
    common = text.partition("\n## ")[0]
    missing = [flag for flag in sorted(flags) if f"`{flag}" not in section and f"`{flag}" not in common]
    missing += [name for name in schema_of(command)["properties"] if f"`{name}`" not in section]
    assert not missing, f"docs/commands.md, ppinfer {command}: say what {', '.join(missing)} is"
