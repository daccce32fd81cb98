"""``ppinfer score``: how well a posterior names the goal."""

from __future__ import annotations

import argparse
import sys
from typing import TYPE_CHECKING

from ppinfer.cli.output import say
from ppinfer.cli.selection_options import add_selection_arguments, add_share_argument

if TYPE_CHECKING:
    from ppinfer.studies.calibration import Calibration
    from ppinfer.studies.scores import Score, Scores
    from ppinfer.studies.segment_selection import SegmentOptions

_DESCRIPTION = """\
Score a posterior over goals on the segments whose true goal is known. After a share f of a segment
of T samples, that is after max(3, ceil(f T)) of them: accuracy (is the most probable goal the true
one? a tie of k goals counts 1/k) and the mean natural logarithm of the true goal's probability,
over all segments, with standard errors over participants. Also the expected calibration error of
the most probable goal's probability, over all samples of these segments.
"""

_EPILOG = """\
example:
  ppinfer score POST.nc --at 0.25 0.5 0.75 --min-samples 8 --min-distance 2 --json
"""


def add_parser(commands: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    """Add the command and its arguments."""
    parser = commands.add_parser(
        "score",
        help="accuracy, mean log posterior and calibration of a posterior",
        description=_DESCRIPTION,
        epilog=_EPILOG,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("posterior", metavar="POST.nc", help="a posterior, as 'ppinfer infer' writes it")
    add_share_argument(parser)
    add_selection_arguments(parser)
    parser.add_argument("--by-participant", action="store_true", help="also the scores of each participant")
    parser.add_argument("--json", action="store_true", help="print one JSON object instead of tables")
    parser.set_defaults(run=run)


def run(args: argparse.Namespace) -> int:
    """Score the posterior and print the result."""
    from ppinfer.cli.output import print_json
    from ppinfer.studies.calibration import calibrate_posterior
    from ppinfer.studies.posterior import open_posterior
    from ppinfer.studies.scores import score_posterior

    selection: SegmentOptions = {
        "min_samples": args.min_samples,
        "min_distance": args.min_distance,
        "participants": args.participants,
        "exclude": args.exclude,
    }
    with open_posterior(args.posterior, verify=True) as posterior:
        scores = score_posterior(posterior, at=args.at, **selection)
        calibration = calibrate_posterior(posterior, at=args.at, **selection)
    for warning in scores.warnings:
        say(f"ppinfer score: warning: {warning}", file=sys.stderr)
    if args.json:
        print_json(as_json(scores, calibration, by_participant=args.by_participant))
    else:
        print_scores(args.posterior, scores, calibration, by_participant=args.by_participant)
    return 0


def as_json(scores: Scores, calibration: Calibration, *, by_participant: bool) -> dict[str, object]:
    """Return what ``--json`` prints."""
    out: dict[str, object] = {
        "scores": scores.to_json(),
        "calibration": calibration.to_json(),
        "left_out": scores.left_out,
        "warnings": scores.warnings,
    }
    if by_participant:
        out["by_participant"] = [
            {
                "participant": each.participant,
                "at": each.at,
                "accuracy": each.accuracy,
                "mean_log_posterior": each.mean_log_posterior,
                "segments": each.segments,
            }
            for each in scores.by_participant
        ]
    return out


def print_scores(path: str, scores: Scores, calibration: Calibration, *, by_participant: bool) -> None:
    """Print tables for people."""
    from ppinfer.cli.output import print_table
    from ppinfer.studies.segment_selection import describe_left_out

    columns = ("seen", "accuracy", "mean log posterior", "segments", "participants")
    rows = [(*_cells(score), str(score.segments), str(score.participants)) for score in scores.overall]
    print_table(f"{path}: goal scores (± standard error over participants)", columns, rows)
    say(
        f"expected calibration error {calibration.expected_calibration_error:.3f} (most probable goal), "
        f"{calibration.one_vs_rest.expected_calibration_error:.3f} (all goals)"
    )
    if left_out := describe_left_out(scores.left_out):
        say(left_out)
    if by_participant:
        print_table(
            "by participant (± standard error over segments)",
            ("participant", "seen", "accuracy", "mean log posterior", "segments"),
            [(each.participant, *_cells(each), str(each.segments)) for each in scores.by_participant],
        )


def _cells(score: Score) -> tuple[str, str, str]:
    return (
        f"{score.at:.4g}",
        _with_error(score.accuracy, score.accuracy_se),
        _with_error(score.mean_log_posterior, score.mean_log_posterior_se),
    )


def _with_error(value: float, error: float) -> str:
    # NaN is the error of a single participant, or of a mean that is infinite
    return f"{value:.3f}" if error != error else f"{value:.3f} ± {error:.3f}"
