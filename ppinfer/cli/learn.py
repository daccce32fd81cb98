"""``ppinfer learn``: a network that predicts the human's goal from the robot's plan, beside the model that does so."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ppinfer.cli.argument_types import share, whole_number
from ppinfer.cli.output import say

if TYPE_CHECKING:
    from ppinfer.studies.learning import LearningRow, LearningStudy

_DESCRIPTION = """\
Train a network on examples (see 'ppsim examples') to predict which goal the human will reach, given the
motion so far, the robot's plan and the goals, and write its weights (extra: pip install 'ppinfer[learned]').
Training stops early, once the loss on examples set aside no longer falls. The network is scored on examples
held out, beside the model-based prediction (Bayes for the prior goal, then the softmax conditional) as it is
and with its weights fitted, and beside even odds. With --sizes it is trained on growing numbers of examples:
how much data does learning need to match the model?
"""

_EPILOG = """\
examples:
  ppinfer learn DATA.zarr -o MODEL.safetensors
  ppinfer learn DATA.zarr -o MODEL.safetensors --sizes 100 1000 10000 --figure learning.png
"""


def add_parser(commands: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    """Add the command and its arguments."""
    parser = commands.add_parser(
        "learn",
        help="learn to predict the human's goal from the robot's plan",
        description=_DESCRIPTION,
        epilog=_EPILOG,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    add = parser.add_argument
    add("data", metavar="DATA.zarr", help="examples, as 'ppsim examples' writes them")
    add("-o", "--output", metavar="MODEL.safetensors", required=True, help="the weights to write")
    add(
        "--sizes",
        type=whole_number,
        nargs="+",
        default=[],
        metavar="N",
        help="numbers of examples to train on, each anew; the last network is written (default: all)",
    )
    add("--epochs", type=whole_number, default=40, metavar="E", help="epochs at most (default: %(default)s)")
    add(
        "--patience",
        type=whole_number,
        default=8,
        metavar="E",
        help="epochs without a better validation loss before it stops (default: %(default)s)",
    )
    add(
        "--hidden",
        type=whole_number,
        default=48,
        metavar="H",
        help="width of the network (default: %(default)s)",
    )
    add(
        "--held-out",
        type=share,
        default=0.2,
        metavar="SHARE",
        help="share of the examples that is only scored on (default: %(default)s)",
    )
    add("--seed", type=whole_number, default=0, metavar="S", help="seed of the training (default: 0)")
    add(
        "--threads",
        type=whole_number,
        default=1,
        metavar="T",
        help="threads; the same number gives the same weights (default: 1)",
    )
    add("--figure", metavar="FILE", help="also draw error and calibration against the amount of data")
    add("--json", action="store_true", help="print one JSON object instead of a table")
    parser.set_defaults(run=run)


def run(args: argparse.Namespace) -> int:
    """Train, write the weights, and print the scores."""
    from ppinfer.cli.output import print_json
    from ppinfer.cli.progress import progress_bar
    from ppinfer.goals.learned import Training, write_predictor
    from ppinfer.goals.learned.extra import require_torch
    from ppinfer.goals.learned.weights import check_weights_target
    from ppinfer.studies.learning import study_learning
    from ppinfer.studies.prediction_examples import ExampleStore

    check_weights_target(args.output)
    if args.figure:
        _check_figure(args.figure)
    training = Training(epochs=args.epochs, patience=args.patience, seed=args.seed, threads=args.threads)
    store = ExampleStore(args.data)
    require_torch()
    with progress_bar("learning") as progress:
        study = study_learning(
            store,
            sizes=args.sizes,
            hidden=args.hidden,
            training=training,
            held_out=args.held_out,
            progress=progress,
        )
    write_predictor(study.trained.predictor, args.output)
    if args.figure:
        from ppinfer.plots.learning_curve import plot_learning_curve

        figure: Any = plot_learning_curve(study.rows).figure
        figure.savefig(args.figure)
    if args.json:
        print_json(as_json(study, args))
    else:
        print_study(study, args)
    return 0


def _check_figure(name: str) -> None:
    from matplotlib.figure import Figure

    from ppinfer.errors import PPInferError

    # told before hours of training, not after
    known = Figure().canvas.get_supported_filetypes()
    if Path(name).suffix.removeprefix(".").lower() not in known:
        raise PPInferError(
            f"{name}: a figure is written as {', '.join(sorted(known))}; give it a name that ends so"
        )
    if not Path(name).absolute().parent.is_dir():
        raise PPInferError(f"{name}: there is no folder {str(Path(name).parent)!r}; make it first")


def as_json(study: LearningStudy, args: argparse.Namespace) -> dict[str, Any]:
    """Return what ``--json`` prints."""
    conditional = study.fitted.conditional
    return {
        "output": args.output,
        "data": args.data,
        "held_out": study.held_out,
        "rows": [row.to_json() for row in study.rows],
        "training": {
            "training_loss": list(study.trained.training_loss),
            "validation_loss": list(study.trained.validation_loss),
            "best_epoch": study.trained.best_epoch,
        },
        "fitted_model": {
            "human_weight": conditional.human_weight,
            "robot_weight": conditional.robot_weight,
            "stay_weight": conditional.stay_weight,
            "conditional_rationality": conditional.rationality,
            "rationality": study.fitted.rationality,
        },
    }


def print_study(study: LearningStudy, args: argparse.Namespace) -> None:
    """Print a row for each predictor."""
    from ppinfer.cli.output import print_table

    columns = (
        "prediction",
        "examples",
        "hours",
        "epochs",
        "loss",
        "mean log probability",
        "Brier",
        "calibration error",
    )
    print_table(
        f"{Path(args.data).name}: {study.held_out} examples held out",
        columns,
        [_cells(row) for row in study.rows],
    )
    say(
        "hours: of interaction simulated for the examples trained on, continuations included; loss: mean squared "
        "error; calibration error: expected, of all goals' probabilities"
    )
    say(f"{args.output}: the network of the last row")


def _cells(row: LearningRow) -> tuple[str, ...]:
    score = row.score
    return (
        row.prediction,
        str(row.examples) if row.examples else "",
        f"{row.interaction_hours:.2f}" if row.examples else "",
        str(row.epochs) if row.epochs else "",
        f"{score.loss:.4f}",
        f"{score.mean_log_probability:.3f}",
        f"{score.brier:.3f}",
        f"{score.expected_calibration_error:.3f}",
    )
