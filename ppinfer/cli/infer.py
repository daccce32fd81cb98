"""``ppinfer infer``: from a log to the posterior over an agent's goals, or over theta, whom its equilibria favour."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from ppinfer.cli import infer_personality
from ppinfer.cli.argument_types import whole_number
from ppinfer.cli.infer_logged import run_logged
from ppinfer.cli.model_options import (
    add_model_arguments,
    add_partner_argument,
    check_partner,
    model_from_options,
)
from ppinfer.cli.output import say
from ppinfer.errors import ModelError

if TYPE_CHECKING:
    from ppinfer.goals import GoalModel
    from ppinfer.studies.infer import Inference

_DESCRIPTION = """\
Infer the posterior over an agent's goals at every sample of a study log, and write it with the
log's trials and segments. Models: goal-lqr (noisily rational LQR agent), goal-kalman (the same from
noisy positions with dropouts and outliers), goal-coupled (a product of small experts, which sees what
the other agents do as well), nearest and heading (baselines), or a MODEL.toml written by 'ppinfer fit'.
Velocities and controls that were not logged are derived from earlier samples only.

With --logged NAME: nothing is inferred; the belief over goals of that name, which the log holds because
the study's own robot held it live, becomes a posterior that can be scored and compared like any other.

With --model personality: the posterior over theta (whom the other agent's equilibria favour) at every
replan of one agent, from the plans and costs that a world where agents plan has logged.
"""

_EPILOG = """\
examples:
  ppinfer infer LOG.nc -o POST.nc --model goal-lqr --set rationality=0.005 control_weight=100
  ppinfer infer LOG.nc -o POST.nc --model MODEL.toml --agent robot --mode smooth
  ppinfer infer LOG.nc -o POST.nc --model goal-coupled --set experts=motion,distance
  ppinfer infer LOG.nc -o LIVE.nc --logged belief_robot
  ppinfer infer PLAYS.nc -o POST.nc --model personality --variant literal --set rationality=5
"""


def add_parser(commands: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    """Add the command and its arguments."""
    parser = commands.add_parser(
        "infer",
        help="the posterior over an agent's goals, or over its personality, from a log",
        description=_DESCRIPTION,
        epilog=_EPILOG,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument(
        "log", metavar="LOG", help="a study log (.nc or .zarr), as 'ppinfer convert' writes it"
    )
    parser.add_argument("-o", "--output", metavar="POST.nc", required=True, help="the posterior to write")
    add_model_arguments(parser)
    infer_personality.add_personality_arguments(parser)
    parser.add_argument(
        "--agent",
        metavar="A",
        help="whose goals (default: human, or the only agent); with --model personality whose beliefs (default: robot, "
        "or the only agent that replanned)",
    )
    add_partner_argument(parser)
    parser.add_argument(
        "--logged",
        metavar="NAME",
        help="write this belief over goals of the log itself (its variable NAME, logged_NAME or live_NAME)",
    )
    parser.add_argument(
        "--mode",
        choices=("filter", "smooth"),
        default="filter",
        help="given the samples so far, or the whole row (default: filter)",
    )
    parser.add_argument(
        "--restart",
        choices=("goals", "segments"),
        default="goals",
        help="the belief starts anew in each trial and where its goals change; with 'segments' also at the bounds of "
        "the agent's segments (default: goals)",
    )
    parser.add_argument(
        "--carry", action="store_true", help="carry the belief over such a change, goal by goal"
    )
    parser.add_argument(
        "--seed", type=whole_number, default=0, metavar="S", help="recorded with the result (default: 0)"
    )
    parser.add_argument("--json", action="store_true", help="print one JSON object instead of a table")
    parser.set_defaults(run=run)


def run(args: argparse.Namespace) -> int:
    """Infer, write, and print what a person wants to see first."""
    from ppinfer.cli.output import print_json
    from ppinfer.cli.progress import progress_bar
    from ppinfer.cli.targets import check_output
    from ppinfer.studies.infer import infer_posterior

    if args.logged is not None:
        return run_logged(args)
    if args.model == infer_personality.NAME:
        if args.partner is not None:
            raise ModelError("--partner is for models of goals, not personality")
        return infer_personality.run(args)
    if args.variant is not None:
        raise ModelError(f"--variant is for --model personality, not {args.model}")
    check_output(args.output, suffix=".nc", inputs=[args.log])
    model = model_from_options(args.model, args.settings)
    check_partner(model, args.partner)
    with progress_bar("inferring goals") as progress:
        done = infer_posterior(
            args.log,
            args.output,
            model,
            agent=args.agent,
            mode=args.mode,
            restart=args.restart,
            carry=args.carry,
            seed=args.seed,
            partner=args.partner,
            progress=progress,
        )
    seen = done.samples - done.samples_missing
    if done.outliers_gated > 0.1 * seen:
        say(
            f"ppinfer infer: warning: {done.outliers_gated} of {seen} samples were set aside as outliers; is "
            "measurement_noise in the log's unit of position?",
            file=sys.stderr,
        )
    if args.json:
        print_json(as_json(done, model, args.output))
    else:
        print_inference(done, model.name, args.output, gates_outliers=model.gates_outliers)
    return 0


def as_json(done: Inference, model: GoalModel, output: str) -> dict[str, object]:
    """Return what ``--json`` prints."""
    from ppinfer.goals.configuration import parameters_of

    return {
        "output": output,
        "model": model.name,
        "parameters": parameters_of(model),
        "agent": done.agent,
        "trials": done.trials,
        "samples": done.samples,
        "segments": done.segments,
        "samples_missing": done.samples_missing,
        "outliers_gated": done.outliers_gated,
        "state_source": done.state_source,
    }


def print_inference(
    done: Inference,
    name: str,
    output: str,
    *,
    gates_outliers: bool = False,
    more: Sequence[tuple[str, str]] = (),
) -> None:
    """Print a short table, with the scores where the true goals are known."""
    from ppinfer.cli.output import print_table
    from ppinfer.errors import LogError
    from ppinfer.studies.posterior import open_posterior
    from ppinfer.studies.scores import score_posterior

    rows = [
        ("agent", done.agent),
        ("trials, samples, segments", f"{done.trials}, {done.samples}, {done.segments}"),
        ("samples missing", str(done.samples_missing)),
        ("states", done.state_source),
    ]
    rows += more
    if gates_outliers:
        rows.append(("outliers set aside", str(done.outliers_gated)))
    with open_posterior(output) as posterior:
        try:
            scores = score_posterior(posterior).overall
        except LogError:
            # no segment says which goal was the true one: there is nothing to score
            scores = ()
    rows += [
        (
            f"after {score.at:.0%} of a segment",
            f"accuracy {score.accuracy:.3f}, mean log posterior {score.mean_log_posterior:.3f}",
        )
        for score in scores
    ]
    print_table(f"{Path(output).name}: {name} on {done.log_name}", ("", ""), rows)
