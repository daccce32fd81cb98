"""``ppinfer anova``: repeated-measures analyses of variance of a table."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ppinfer.cli.argument_types import one_character, positive_number
from ppinfer.cli.output import say

if TYPE_CHECKING:
    from ppinfer.studies.statistics import Analysis

_DESCRIPTION = """\
Repeated-measures analysis of variance of each dependent variable of a table (CSV or Parquet, one row
for each subject and cell): F, sphericity (Mauchly) with the Greenhouse-Geisser and Huynh-Feldt
corrections, effect sizes, Bayes factors, Friedman's test for ordinal data; and, with --posthoc,
every pair of levels by a paired t-test. Several --within columns make a factorial design. Subjects
and levels are text; missing cells and repeated rows are named and refused unless you choose.
"""

_EPILOG = """\
example:
  ppinfer anova survey.csv --dv fluency trust --within robot --subject participant --posthoc holm
"""


def add_parser(commands: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    """Add the command and its arguments."""
    parser = commands.add_parser(
        "anova",
        help="repeated-measures analysis of variance, with post-hoc tests and Bayes factors",
        description=_DESCRIPTION,
        epilog=_EPILOG,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("table", metavar="TABLE.csv", type=Path, help="a CSV or Parquet (.parquet) table")
    parser.add_argument(
        "--dv",
        dest="dvs",
        metavar="NAME",
        nargs="+",
        action="extend",
        required=True,
        help="column of a dependent variable; several names, or the flag several times",
    )
    parser.add_argument(
        "--within",
        metavar="COL",
        nargs="+",
        action="extend",
        required=True,
        help="column of a within-subject factor; several for a factorial design",
    )
    parser.add_argument("--subject", metavar="COL", required=True, help="column that names the subject")
    parser.add_argument(
        "--posthoc",
        choices=("bonferroni", "holm"),
        help="also compare all pairs of levels, with p adjusted so",
    )
    parser.add_argument(
        "--missing",
        choices=("refuse", "drop-subjects", "drop-levels"),
        default="refuse",
        help="what to do where a subject lacks a cell, for each dependent variable by itself (default: refuse)",
    )
    parser.add_argument(
        "--repeated",
        choices=("refuse", "mean"),
        default="refuse",
        help="what to do with several rows of one subject and cell (default: refuse)",
    )
    parser.add_argument(
        "--prior-scale",
        metavar="R",
        type=positive_number,
        default=None,
        help="scale of the Bayes factors' Cauchy prior on the standardised effect (default: sqrt(1/2), 0.707)",
    )
    parser.add_argument(
        "--delimiter",
        metavar="C",
        type=one_character,
        default=",",
        help="what separates CSV cells (default: ,)",
    )
    parser.add_argument(
        "--decimal", choices=(".", ","), default=".", help="the decimal mark of CSV numbers (default: .)"
    )
    parser.add_argument("--json", action="store_true", help="print one JSON object instead of tables")
    parser.set_defaults(run=run)


def run(args: argparse.Namespace) -> int:
    """Analyse the table and print the result."""
    from ppinfer.cli.faults_in_line import faults_in_line
    from ppinfer.cli.output import print_json
    from ppinfer.studies.faults import FaultyLogError
    from ppinfer.studies.readers.mapping import FileOptions
    from ppinfer.studies.statistics import analyse, read_measures
    from ppinfer.studies.statistics.bayes_factors import PRIOR_SCALE

    prior_scale = PRIOR_SCALE if args.prior_scale is None else args.prior_scale
    try:
        measures = read_measures(
            args.table,
            args.dvs,
            within=args.within,
            subject=args.subject,
            repeated=args.repeated,
            options=FileOptions(delimiter=args.delimiter, decimal=args.decimal),
        )
        analysis = analyse(measures, posthoc=args.posthoc, missing=args.missing, prior_scale=prior_scale)
    except FaultyLogError as error:
        say(f"ppinfer anova: {faults_in_line(error)}{_remedy(error, args)}", file=sys.stderr)
        return 1
    for warning in analysis.warnings:
        say(f"ppinfer anova: warning: {warning}", file=sys.stderr)
    if args.json:
        print_json(_with_provenance(analysis, args, prior_scale))
    else:
        _print(analysis, args)
    return 0


def _remedy(error: Any, args: argparse.Namespace) -> str:
    if "missing-cell" in error.counts:
        ways = "--missing drop-subjects" + (" or drop-levels" if len(args.within) == 1 else "")
        return f"; fill them in, or choose {ways}"
    if "repeated-cell" in error.counts:
        return " (--repeated mean)"
    if "delimiter" in error.counts:
        return "; see --delimiter"
    if "not-a-number" in error.counts and args.decimal == ".":
        commas = any("," in line.partition("got ")[2] for line in error.lines)
        return "; for decimal commas give --decimal ," if commas else ""
    return ""


def _with_provenance(analysis: Analysis, args: argparse.Namespace, prior_scale: float) -> dict[str, Any]:
    from ppinfer import __version__
    from ppinfer.studies.checksums import file_sha256

    return {
        **analysis.to_json(),
        "input": str(args.table),
        "input_sha256": file_sha256(args.table),
        "ppinfer_version": __version__,
        "options": {
            "dv": args.dvs,
            "within": args.within,
            "subject": args.subject,
            "posthoc": args.posthoc,
            "missing": args.missing,
            "repeated": args.repeated,
            "prior_scale": prior_scale,
            "delimiter": args.delimiter,
            "decimal": args.decimal,
        },
        "warnings": list(analysis.warnings),
    }


def _print(analysis: Analysis, args: argparse.Namespace) -> None:
    from ppinfer.cli.output import print_table
    from ppinfer.studies.statistics import tables

    title = f"{args.table.name}: effects within subjects"
    print_table(title, tables.EFFECT_COLUMNS, tables.effect_rows(analysis))
    for effect, columns, rows in tables.mean_tables(analysis):
        print_table(f"means (± SE) by {effect}", columns, rows)
    if analysis.posthoc:
        adjusted = f"p adjusted by {args.posthoc} within each variable and factor"
        print_table(
            f"pairs of levels, paired t-tests (95 % interval of each alone; {adjusted})",
            tables.PAIR_COLUMNS,
            tables.pair_rows(analysis),
        )
