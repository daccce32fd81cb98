"""``ppinfer infer --model personality``: from a log with replans to the posterior over theta at each of them."""

from __future__ import annotations

import argparse
import json
from pathlib import Path
from typing import TYPE_CHECKING

from ppinfer.cli.model_options import parse_settings
from ppinfer.errors import ModelError

if TYPE_CHECKING:
    from ppinfer.coordination import PersonalityModel
    from ppinfer.studies.personality_inference import PersonalityInference

NAME = "personality"
AS_LOGGED = "as-logged"
VARIANTS = {
    "repaired": "personality",
    "literal": "personality-literal",
    "predictive": "personality-predictive",
}


def add_personality_arguments(parser: argparse.ArgumentParser) -> None:
    """Add ``--variant``."""
    parser.add_argument(
        "--variant",
        choices=(AS_LOGGED, *VARIANTS),
        help="for --model personality: the model of all trials; by default (as-logged) each trial's is the one that "
        "its agent used live, with its parameters, and the repaired one where it used none",
    )


def run(args: argparse.Namespace) -> int:
    """Infer, write, and print what a person wants to see first."""
    from ppinfer.cli.output import print_json
    from ppinfer.cli.progress import progress_bar
    from ppinfer.cli.targets import check_output
    from ppinfer.studies.personality_inference import infer_personalities

    check_output(args.output, suffix=".nc", inputs=[args.log])
    model = _model(args)
    with progress_bar("inferring personalities") as progress:
        done = infer_personalities(
            args.log, args.output, model, agent=args.agent, seed=args.seed, progress=progress
        )
    variant = AS_LOGGED if model is None else args.variant
    if args.json:
        print_json(as_json(done, variant, args.output))
    else:
        print_inference(done, variant, args.output)
    return 0


def _model(args: argparse.Namespace) -> PersonalityModel | None:
    from ppinfer.studies.personality_models import make_personality

    for flag, given in (
        ("--mode smooth", args.mode != "filter"),
        ("--restart segments", args.restart != "goals"),
        ("--carry", args.carry),
    ):
        if given:
            raise ModelError(
                f"{flag} is for models of goals; beliefs over theta gather from replan to replan"
            )
    settings = parse_settings(args.settings)
    if args.variant in (None, AS_LOGGED):
        if settings:
            raise ModelError(
                "--set changes one model for all trials: say which with --variant repaired, literal or predictive"
            )
        return None
    return make_personality(VARIANTS[args.variant], settings)


def as_json(done: PersonalityInference, variant: str, output: str) -> dict[str, object]:
    """Return what ``--json`` prints."""
    return {
        "output": output,
        "model": NAME,
        "variant": variant,
        "agent": done.agent,
        "theta": list(done.theta),
        "trials": done.trials,
        "replans": done.replans,
        "applied": [{**json.loads(text), "trials": trials} for text, trials in done.models.items()],
        "live_replans": done.live_replans,
        "live_difference": done.live_difference,
    }


def print_inference(done: PersonalityInference, variant: str, output: str) -> None:
    """Print a short table."""
    from ppinfer.cli.output import print_table

    rows = [
        ("agent", done.agent),
        ("theta", ", ".join(done.theta)),
        ("trials, replans", f"{done.trials}, {done.replans}"),
        *((json.loads(text)["model"], f"{trials} trials") for text, trials in done.models.items()),
    ]
    if done.live_difference is not None:
        rows.append(
            (
                "offline against live",
                f"max |difference| of a probability {done.live_difference:.1e}, at {done.live_replans} replans",
            )
        )
    print_table(f"{Path(output).name}: {NAME} ({variant}) on {done.log_name}", ("", ""), rows)
