"""`ppsim watch`: one trial as a moving picture."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

ARMS = """\
Play one trial of two arms, or take one from a log, and draw it: the arms and what they carry, the plans that the
robot considers, the one it chose, its posterior over whom the human's equilibria favour, and the safety stops.
"""

ARMS_EPILOG = """\
examples:
  ppsim watch arms --seed 4
  ppsim watch arms --seed 4 --robot bayes-risk --human selfish --plan-sets independent -o trial.mp4
  ppsim watch arms --log LOG.nc --trial scene-3/shared/bayes/selfish -o trial.gif
"""


REACHING = """\
Play one reaching game, or take one from a log, and draw it: goals, agents and the goal of each, the robot's candidate
trajectories, its belief about the human's goal, what it takes the human to think its own goal is, where the human will
go for each goal that the robot may go for, score and collisions.

Trajectories are made anew from the log, for every frame with a seed of its own: safe ones are blue, others dotted
red, the chosen one is thick. Beliefs are those that the robot held where the log has them.
"""

REACHING_EPILOG = """\
examples:
  ppsim watch reaching --seed 4
  ppsim watch reaching --seed 4 --robot influence --human stubborn --goals 5 -o game.mp4
  ppsim watch reaching --log LOG.nc --trial game-0/3-goals/naive/stubborn -o game.gif
"""


def add_parser(commands: argparse._SubParsersAction[Any]) -> None:
    """Add ``watch`` and its worlds."""
    watch = commands.add_parser("watch", help="draw a trial as GIF or MP4")
    worlds = watch.add_subparsers(title="worlds", dest="world", metavar="WORLD", required=True)
    _add_arms(worlds)
    _add_reaching(worlds)


def _add_arms(worlds: argparse._SubParsersAction[Any]) -> None:
    from ppsim.arms.execution import PLAN_SETS

    parser = worlds.add_parser(
        "arms",
        help="two arms that pick and place",
        description=ARMS,
        epilog=ARMS_EPILOG,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    add = parser.add_argument
    add("--seed", type=int, default=0, metavar="S", help="seed of the trial (default: 0)")
    add("--robot", default="bayes", metavar="NAME", help="the robot's policy (default: %(default)s)")
    add("--human", default="selfish", metavar="NAME", help="the simulated human's (default: %(default)s)")
    add(
        "--plan-sets",
        default="shared",
        choices=PLAN_SETS,
        metavar="NAME",
        help="shared (default) or independent",
    )
    add("--log", type=Path, metavar="LOG.nc", help="draw a trial of this log instead")
    add("--trial", metavar="ID", help="which trial of the log, by its id (default: the first)")
    add(
        "-o",
        "--output",
        type=Path,
        metavar="FILE",
        help=".gif, or .mp4 (extra: video) (default: arms-SEED.gif)",
    )
    parser.set_defaults(run=run_watch_arms)


def run_watch_arms(args: argparse.Namespace) -> int:
    """Draw one trial."""
    from ppinfer.cli.output import say
    from ppinfer.cli.progress import progress_bar
    from ppinfer.studies import open_log
    from ppsim.arms.study import ArmsStudy
    from ppsim.arms.watching import draw_trial
    from ppsim.one_trial import one_trial
    from ppsim.study import log_of_study

    if args.log is None:
        study = ArmsStudy(
            scenes=1, robots=(args.robot,), humans=(args.human,), plan_sets=(args.plan_sets,), seed=args.seed
        )
        log = log_of_study(study, [0])
        output = args.output or Path(f"arms-{args.seed}.gif")
    else:
        log = one_trial(open_log(args.log, verify=True), args.trial, where=str(args.log))
        output = args.output or args.log.with_suffix(".gif")
    with progress_bar("drawing") as progress:
        draw_trial(log, output, progress=progress)
    stops = int(log["stops"].values[0])
    say(
        f"{output}: {log['trial_id'].values[0]}, {log['outcome'].values[0]} after {log['time'].values[-1]:.1f} s, "
        f"{stops} safety stops"
    )
    return 0


def _add_reaching(worlds: argparse._SubParsersAction[Any]) -> None:
    parser = worlds.add_parser(
        "reaching",
        help="a robot and a human among goals",
        description=REACHING,
        epilog=REACHING_EPILOG,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    add = parser.add_argument
    add("--seed", type=int, default=0, metavar="S", help="seed of the game (default: 0)")
    add("--robot", default="expected-cost", metavar="NAME", help="the robot (default: %(default)s)")
    add("--human", default="moving", metavar="NAME", help="the simulated human (default: %(default)s)")
    add("--goals", type=int, default=3, metavar="N", help="goals at a time (default: 3)")
    add(
        "--duration",
        type=float,
        default=30.0,
        metavar="S",
        help="length of the game, s (default: %(default)s)",
    )
    add("--log", type=Path, metavar="LOG.nc", help="draw a game of this log instead")
    add("--trial", metavar="ID", help="which trial of the log, by its id (default: the first)")
    add(
        "-o",
        "--output",
        type=Path,
        metavar="FILE",
        help=".gif, or .mp4 (extra: video) (default: reaching-SEED.gif, or the log's name)",
    )
    parser.set_defaults(run=run_watch_reaching)


def run_watch_reaching(args: argparse.Namespace) -> int:
    """Draw one game."""
    from ppinfer.cli.output import say
    from ppinfer.cli.progress import progress_bar
    from ppinfer.studies import open_log
    from ppsim.one_trial import one_trial
    from ppsim.reaching import GameStudy
    from ppsim.reaching.watching import draw_game
    from ppsim.study import log_of_study

    if args.log is None:
        study = GameStudy(
            robots=(args.robot,),
            humans=(args.human,),
            goals=(args.goals,),
            seed=args.seed,
            duration=args.duration,
        )
        log = log_of_study(study, [0])
        output = args.output or Path(f"reaching-{args.seed}.gif")
    else:
        log = one_trial(open_log(args.log, verify=True), args.trial, where=str(args.log))
        output = args.output or args.log.with_suffix(".gif")
    with progress_bar("drawing") as progress:
        draw_game(log, output, progress=progress)
    told = [f"{log['time'].values[-1]:.1f} s"]
    for name, what in (("team_score", "point"), ("collisions", "collision")):
        if name in log:
            count = int(log[name].values[0])
            told.append(f"{count} {what}{'' if count == 1 else 's'}")
    say(f"{output}: {log['trial_id'].values[0]}, {', '.join(told)}")
    return 0
