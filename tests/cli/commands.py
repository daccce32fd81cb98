"""Run one command as the terminal would, and check its JSON against its schema."""

from __future__ import annotations

import importlib
import json
from importlib.resources import files

import jsonschema

from ppinfer.cli import OneLineParser, run_command


def run_one(name, *argv):
    """Return the exit status of one command, whatever other commands there are."""
    parser = OneLineParser(prog="ppinfer")
    commands = parser.add_subparsers(dest="command", required=True)
    importlib.import_module(f"ppinfer.cli.{name}").add_parser(commands)
    return run_command(parser, [name, *map(str, argv)])


def checked_json(name, text):
    """Return the JSON that a command printed, once its schema holds."""
    schema = json.loads((files("ppinfer.cli") / "schemas" / f"{name}.schema.json").read_text())
    jsonschema.Draft202012Validator.check_schema(schema)
    value = json.loads(text)
    jsonschema.validate(value, schema, cls=jsonschema.Draft202012Validator)
    return value
