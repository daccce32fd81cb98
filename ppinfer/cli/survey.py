"""``ppinfer survey``: what participants answered, whether scales hang together, and whether orders were balanced."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ppinfer.cli.argument_types import whole_number
from ppinfer.cli.output import say

if TYPE_CHECKING:
    from ppinfer.studies.surveys import SurveyAnalysis
    from ppinfer.studies.surveys.survey_orders import SurveyOrders

_DESCRIPTION = """\
Summarise the answers to a survey: each item by condition, the scores of scales and their Cronbach's
alpha, and what the orders balance in which participants met the conditions. The instrument (TOML) says
which column is what, what the numbers mean and which items are reversed; other columns are not read.
Participants are called P01, P02, ... by what they answered, not by name nor in the table's order.
"""

_EPILOG = """\
example:
  ppinfer survey answers.csv --instrument survey.toml --orders orders.csv -o scores.csv

an instrument, survey.toml (all of it is in docs/surveys.md):
  columns = {subject = "user", condition = "robot"}
  anchors = {1 = "Strongly Disagree", 5 = "Strongly Agree"}

  [items]
  easy = {text = "The robot was easy to work with."}
  in_the_way = {text = "The robot was in my way.", reversed = true}

  [scales]
  fluency = {items = ["easy", "in_the_way"]}
"""


def add_parser(commands: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    """Add the command and its arguments."""
    parser = commands.add_parser(
        "survey",
        help="answers to a survey by condition, scores, Cronbach's alpha, counterbalancing",
        description=_DESCRIPTION,
        epilog=_EPILOG,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument(
        "table", metavar="TABLE.csv", type=Path, help="a CSV or Parquet table, one row a response"
    )
    parser.add_argument(
        "--instrument", metavar="I.toml", type=Path, required=True, help="what the columns and numbers mean"
    )
    parser.add_argument(
        "--by",
        metavar="COL",
        nargs="+",
        help="condition columns to tell apart (default: all that the instrument names)",
    )
    parser.add_argument(
        "--orders",
        metavar="ORDERS.csv",
        type=Path,
        help="the order in which each participant met the conditions",
    )
    parser.add_argument(
        "--missing",
        choices=("refuse", "drop-responses", "mean-of-answered"),
        default="refuse",
        help="what to do where an answer is missing (default: refuse)",
    )
    parser.add_argument(
        "-o",
        "--output",
        metavar="SCORES.csv",
        help="write items after reversing and scores, one row a response",
    )
    parser.add_argument("--keep-ids", action="store_true", help="call participants what the table calls them")
    parser.add_argument(
        "--seed", type=whole_number, default=0, metavar="S", help="seed of the pseudonyms' order (default: 0)"
    )
    parser.add_argument("--json", action="store_true", help="print one JSON object instead of tables")
    parser.set_defaults(run=run)


def run(args: argparse.Namespace) -> int:
    """Analyse the survey, print what it says, and write the scores."""
    from ppinfer.cli.faults_in_line import faults_in_line
    from ppinfer.cli.output import print_json
    from ppinfer.cli.targets import check_output
    from ppinfer.studies.faults import FaultyLogError
    from ppinfer.studies.surveys import Instrument, analyse_survey, read_survey, write_scores
    from ppinfer.studies.surveys.survey_orders import check_survey_orders

    if args.output is not None:
        inputs = [str(path) for path in (args.table, args.instrument, args.orders) if path is not None]
        check_output(args.output, suffix=".csv", inputs=inputs)
    try:
        instrument = Instrument.load(args.instrument)
        identified = read_survey(args.table, instrument, keep_ids=True)
        names = {who: who for who in identified.participants} if args.keep_ids else None
        named = identified if args.keep_ids else identified.pseudonymised(args.seed)
        analysis = analyse_survey(named, missing=args.missing, by=args.by)
        orders = None
        if args.orders is not None or instrument.columns.position is not None:
            orders = check_survey_orders(identified, args.orders, names=names, by=args.by, seed=args.seed)
    except FaultyLogError as error:
        say(f"ppinfer survey: {faults_in_line(error)}", file=sys.stderr)
        return 1
    if args.output is not None:
        write_scores(args.output, analysis.survey)
    if args.json:
        told = analysis.to_json()
        told["counterbalancing"] = None if orders is None else orders.to_json()
        told["notes"] += [] if orders is None else orders.lines()
        print_json({**told, "output": args.output, **_provenance(args)})
    else:
        print_analysis(analysis, orders)
    for warning in analysis.warnings:
        say(f"ppinfer survey: warning: {warning}", file=sys.stderr)
    return 0


def _provenance(args: argparse.Namespace) -> dict[str, Any]:
    from ppinfer import __version__
    from ppinfer.studies.checksums import file_sha256

    return {
        "input": str(args.table),
        "input_sha256": file_sha256(args.table),
        "instrument_sha256": file_sha256(args.instrument),
        "ppinfer_version": __version__,
        "options": {
            "instrument": str(args.instrument),
            "by": args.by,
            "orders": None if args.orders is None else str(args.orders),
            "missing": args.missing,
            "keep_ids": args.keep_ids,
            "seed": args.seed,
        },
    }


def print_analysis(analysis: SurveyAnalysis, orders: SurveyOrders | None) -> None:
    """Print tables for people."""
    from ppinfer.cli.output import print_table

    survey = analysis.survey
    instrument = survey.instrument
    title = f"{instrument.title}: " if instrument.title else ""
    told = f"{title}{survey.n_responses} responses of {len(survey.participants)} participants"
    print_table(
        f"{told}; answers as given, standard error over participants",
        ("item", "condition", "n", "mean", "SEM", "SD", "median", "answers"),
        [
            (
                row.name,
                row.condition,
                str(row.n),
                *(_number(value) for value in (row.mean, row.sem, row.sd, row.median)),
                "  ".join(f"{number}: {count}" for number, count in (row.counts or {}).items() if count),
            )
            for row in analysis.items
        ],
    )
    if analysis.scales:
        print_table(
            "scores: means of items, reversed ones turned",
            ("scale", "condition", "n", "mean", "SEM", "SD", "median"),
            [
                (
                    row.name,
                    row.condition,
                    str(row.n),
                    *(_number(value) for value in (row.mean, row.sem, row.sd, row.median)),
                )
                for row in analysis.scales
            ],
        )
        print_table(
            "Cronbach's alpha, with Feldt's 95 % interval",
            ("scale", "of", "responses", "alpha", "interval", "standardized", "item-rest correlations"),
            [
                (
                    row.scale,
                    row.condition if row.of == "condition" else row.of,
                    str(row.alpha.responses),
                    _number(row.alpha.alpha),
                    "" if row.alpha.low is None else f"[{_number(row.alpha.low)}, {_number(row.alpha.high)}]",
                    _number(row.alpha.standardized),
                    "  ".join(_number(item.item_rest_correlation) for item in row.items),
                )
                for row in analysis.reliability
            ],
        )
        for row in analysis.reliability:
            if row.alpha.reason:
                say(f"{row.scale}, {row.condition or row.of}: {row.alpha.reason}")
        for note in analysis.notes:
            say(note)
    if orders is not None:
        _print_orders(orders)


def _print_orders(orders: SurveyOrders) -> None:
    from ppinfer.cli.output import print_table

    found = orders.found
    k = len(found.conditions)
    print_table(
        f"participants who met each condition at each position, and right after which one ({found.design})",
        ("condition", *map(str, range(1, k + 1)), *(f"then {name}" for name in found.conditions)),
        [
            (name, *map(str, found.positions[at]), *map(str, found.following[at]))
            for at, name in enumerate(found.conditions)
        ],
    )
    for line in orders.lines():
        say(line)


def _number(value: float | None) -> str:
    return "" if value is None or value != value else f"{value:.2f}"
