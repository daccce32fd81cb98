"""``ppinfer fit``: rationality, cost weights and the weighing of evidence, from people whose goals are known."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ppinfer.cli.argument_types import whole_number
from ppinfer.cli.model_options import (
    add_model_arguments,
    add_partner_argument,
    check_partner,
    model_from_options,
    parse_settings,
)
from ppinfer.cli.output import say
from ppinfer.cli.selection_options import (
    add_participant_arguments,
    add_segment_arguments,
    add_share_argument,
)
from ppinfer.errors import ModelError

if TYPE_CHECKING:
    from ppinfer.studies.fit import StudyFit

_DESCRIPTION = """\
Fit a goal model to the segments of a log whose goal is known, and write it as MODEL.toml for
'ppinfer infer --model'. What is maximised is either the log posterior of the true goal, averaged over
the samples of each segment and over segments (predictive, the default: what a user of the posterior
is scored by), or the likelihood of the controls (likelihood, goal-lqr only). They differ a lot on real
people, whose residuals are correlated from sample to sample. The fit is cross-validated: participants
are left out one at a time (or in 20 groups) and predicted by a fit to the others.
"""

_EPILOG = """\
examples:
  ppinfer fit LOG.nc --model goal-lqr -o MODEL.toml
  ppinfer fit LOG.nc --model goal-coupled -o MODEL.toml --held-out HELD-OUT.nc
  ppinfer fit LOG.nc --model goal-coupled --set experts=motion,distance motion.outliers=0.05 -o MODEL.toml
  ppinfer fit LOG.nc --model goal-lqr --set stay=1 evidence_floor=0 -o MODEL.toml --exclude p7
"""


def add_parser(commands: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    """Add the command and its arguments."""
    parser = commands.add_parser(
        "fit",
        help="fit a goal model to people whose goals are known",
        description=_DESCRIPTION,
        epilog=_EPILOG,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("log", metavar="LOG", help="a study log with segments and their true goals")
    parser.add_argument("-o", "--output", metavar="MODEL.toml", required=True, help="the model to write")
    add_model_arguments(parser)
    parser.add_argument(
        "--objective",
        choices=("predictive", "likelihood"),
        default="predictive",
        help="what to maximise (default: predictive); parameters given by --set stay as they are",
    )
    parser.add_argument("--agent", metavar="A", help="whose motion (default: human, or the only agent)")
    add_partner_argument(parser)
    parser.add_argument(
        "--held-out",
        metavar="POST.nc",
        help="also write the posterior of the participants left out, each by the fit that had not seen them, for "
        "'ppinfer score' and 'ppinfer compare'",
    )
    parser.add_argument(
        "--restart",
        choices=("goals", "segments"),
        default="goals",
        help="where the belief starts anew within a trial, as in 'ppinfer infer' (default: goals)",
    )
    parser.add_argument(
        "--folds",
        type=whole_number,
        metavar="K",
        help="groups of participants left out in turn (default: one each, at most 20); 0 or 1 for no cross-validation",
    )
    add_participant_arguments(parser.add_argument_group("whom to fit to"))
    scored = parser.add_argument_group(
        "which segments of participants left out are scored (all are fitted to)"
    )
    add_share_argument(scored)
    add_segment_arguments(scored)
    parser.add_argument(
        "--seed",
        type=whole_number,
        default=0,
        metavar="S",
        help="deals participants into groups (default: 0)",
    )
    parser.add_argument("--json", action="store_true", help="print one JSON object instead of tables")
    parser.set_defaults(run=run)


def run(args: argparse.Namespace) -> int:
    """Fit, write the model, and print what it predicts of people left out."""
    from ppinfer.cli.output import print_json
    from ppinfer.cli.progress import progress_bar
    from ppinfer.cli.targets import check_output
    from ppinfer.goals.configuration import check_target, write_model
    from ppinfer.studies import read_log
    from ppinfer.studies.checksums import file_sha256
    from ppinfer.studies.fit import fit_study
    from ppinfer.studies.posterior import write_posterior

    model = model_from_options(args.model, args.settings)
    check_partner(model, args.partner)
    check_output(args.output, suffix=".toml", inputs=[args.log])
    check_target(args.output)
    if args.held_out is not None:
        check_output(args.held_out, suffix=".nc", inputs=[args.log])
        if args.folds in (0, 1):
            raise ModelError(f"--held-out needs a cross-validation, and --folds {args.folds} asks for none")
    log = read_log(args.log)
    with progress_bar(f"fitting {model.name}") as progress:
        fitted = fit_study(
            log,
            model,
            agent=args.agent,
            objective=args.objective,
            fixed=list(parse_settings(args.settings)),
            participants=args.participants,
            exclude=args.exclude,
            restart=args.restart,
            folds=args.folds,
            seed=args.seed,
            at=args.at,
            min_samples=args.min_samples,
            min_distance=args.min_distance,
            partner=args.partner,
            progress=progress,
        )
    write_model(fitted.fit.model, args.output, _notes(fitted, args, file_sha256(args.log)))
    if args.held_out is not None:
        if fitted.held_out_posterior is None:
            raise ModelError("--held-out needs a cross-validation, which takes two participants at least")
        write_posterior(fitted.held_out_posterior, args.held_out)
    if not fitted.folds and args.folds != 0:
        say(
            "ppinfer fit: warning: there was no cross-validation: it takes two participants and two folds at least",
            file=sys.stderr,
        )
    for name in fitted.fit.at_bound:
        say(
            f"ppinfer fit: warning: {name} ended at the bound of the search; the data do not determine it (is another "
            "parameter fixed in the wrong unit?)",
            file=sys.stderr,
        )
    if args.json:
        print_json(as_json(fitted, args.output, args.held_out))
    else:
        print_fit(fitted, args.output)
    return 0


def as_json(fitted: StudyFit, output: str, held_out: str | None = None) -> dict[str, Any]:
    """Return what ``--json`` prints."""
    from ppinfer.goals.configuration import parameters_of

    fit = fitted.fit
    return {
        "output": output,
        **({"held_out": held_out} if held_out is not None else {}),
        "model": fit.model.name,
        "parameters": parameters_of(fit.model),
        "objective": fit.objective,
        "value": fit.value,
        "converged": fit.converged,
        "at_bound": list(fit.at_bound),
        "participants": len(fitted.participants),
        "segments": fitted.segments,
        "samples": fitted.samples,
        "cross_validation": {
            "folds": len(fitted.folds),
            "scores": [_score_record(score) for score in fitted.held_out],
            "expected_calibration_error": fitted.expected_calibration_error,
        },
    }


def print_fit(fitted: StudyFit, output: str) -> None:
    """Print the parameters, and the scores of participants left out."""
    from ppinfer.cli.output import print_table
    from ppinfer.goals.configuration import parameters_of

    fit = fitted.fit
    means = {
        "predictive": "mean log posterior of the true goal",
        "likelihood": "mean log likelihood of a control",
    }
    rows = [
        (name, f"{value:.6g}" if isinstance(value, float) else str(value))
        for name, value in parameters_of(fit.model).items()
    ]
    rows.append(
        (
            f"{means[fit.objective]} (maximised)",
            f"{fit.value:.4f}" + ("" if fit.converged else ", not converged"),
        )
    )
    people = len(fitted.participants)
    title = (
        f"{Path(output).name}: {fit.model.name} fitted to {fitted.segments} segments of {people} participants"
    )
    print_table(title, ("parameter", "value"), rows)
    if fitted.folds:
        print_table(
            f"participants left out, in {len(fitted.folds)} folds (± standard error over participants)",
            ("seen", "accuracy", "mean log posterior", "segments"),
            [
                (
                    f"{score.at:.4g}",
                    f"{score.accuracy:.3f} ± {score.accuracy_se:.3f}",
                    f"{score.mean_log_posterior:.3f} ± {score.mean_log_posterior_se:.3f}",
                    str(score.segments),
                )
                for score in fitted.held_out
            ],
        )
        say(f"expected calibration error of participants left out {fitted.expected_calibration_error:.3f}")


def _notes(fitted: StudyFit, args: argparse.Namespace, sha256: str) -> dict[str, Any]:
    """Return how the model came about, for MODEL.toml; TOML has no nan, so what is not known is left out."""
    from ppinfer import __version__
    from ppinfer.goals.configuration import parameters_of

    record = as_json(fitted, args.output)
    return {
        "fit": {
            "ppinfer_version": __version__,
            "input": Path(args.log).name,
            "input_sha256": sha256,
            "seed": args.seed,
            **{key: record[key] for key in ("objective", "value", "converged", "segments", "samples")},
            "participants": list(fitted.participants),
        },
        "cross_validation": {
            "folds": len(fitted.folds),
            **({"expected_calibration_error": fitted.expected_calibration_error} if fitted.folds else {}),
            "scores": record["cross_validation"]["scores"],
            "parameters": [parameters_of(fold.model) for fold in fitted.folds],
        },
    }


def _score_record(score: Any) -> dict[str, Any]:
    names = (
        "at",
        "accuracy",
        "accuracy_se",
        "mean_log_posterior",
        "mean_log_posterior_se",
        "segments",
        "participants",
    )
    return {name: getattr(score, name) for name in names}
