"""``ppinfer infer --logged``: a belief that the log holds, as a posterior."""

from __future__ import annotations

import argparse
from typing import TYPE_CHECKING

from ppinfer.errors import ModelError

if TYPE_CHECKING:
    from ppinfer.studies.logged_beliefs import LoggedBelief


def run_logged(args: argparse.Namespace) -> int:
    """Write the belief, and print what became of it.

    Raises
    ------
    ModelError
        Where an option says how something is to be inferred.
    """
    from ppinfer.cli.infer import print_inference
    from ppinfer.cli.output import print_json
    from ppinfer.cli.progress import progress_bar
    from ppinfer.cli.targets import check_output
    from ppinfer.studies.logged_beliefs import write_logged_belief

    asked = {
        "--model": args.model != "goal-lqr",
        "--set": bool(args.settings),
        "--partner": args.partner is not None,
        "--variant": args.variant is not None,
        "--mode": args.mode != "filter",
        "--restart": args.restart != "goals",
        "--carry": args.carry,
    }
    for flag, given in asked.items():
        if given:
            raise ModelError(f"{flag} says how to infer, and --logged takes the belief as the log holds it")
    check_output(args.output, suffix=".nc", inputs=[args.log])
    with progress_bar("reading beliefs") as progress:
        done = write_logged_belief(args.log, args.output, args.logged, agent=args.agent, progress=progress)
    if args.json:
        print_json(as_json(done, args.output))
        return 0
    told = [
        ("probabilities of zero", str(done.zeros)),
        ("samples that did not sum to one", str(done.normalised)),
    ]
    print_inference(done.inference, done.variable, args.output, more=told)
    return 0


def as_json(done: LoggedBelief, output: str) -> dict[str, object]:
    """Return what ``--json`` prints."""
    inference = done.inference
    return {
        "output": output,
        "model": f"logged {done.variable}",
        "parameters": {},
        "logged": {"variable": done.variable, "zeros": done.zeros, "normalised": done.normalised},
        "agent": inference.agent,
        "trials": inference.trials,
        "samples": inference.samples,
        "segments": inference.segments,
        "samples_missing": inference.samples_missing,
        "outliers_gated": inference.outliers_gated,
        "state_source": inference.state_source,
    }
