"""What pure equilibria of many games cost: ours in one call, next to NumPy, a loop, pygambit and a pass over the bytes.

Run with ``python benchmarks/equilibria.py`` (``--quick`` for a glance, ``--json`` for one JSON object). One process on
one core. Games have two players of 8 plans; each row gives the least and median time of the repeats by the clock for
each game, the least processor time, which stands when others use the machine as well, and how many times ours that is.
The equilibria of the plain ways and of the peer are compared with ours before they are timed.
pygambit comes with the extra ``ppinfer[peers]``; without it, its row is left out and a line says so.
"""

from __future__ import annotations

import os

os.environ.update(dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"), "1"))

import argparse
import io
import json
import platform
import statistics
import sys
import time
import warnings
from collections.abc import Callable
from typing import Any

import numpy as np

from ppinfer import Axis
from ppinfer.games import Game, finite_profiles, pure_equilibria, undominated, write_nfg
from ppinfer.games.scans import pure_mask2

GAMES, PLANS, REPEATS = 100_000, 8, 25
PEER_GAMES, LOOP_GAMES = 200, 5_000
AIM_MICROSECONDS, AIM_TIMES_PEER = 0.15, 10_000


def random_games(rng: np.random.Generator, games: int) -> Game:
    """Make games as two arms have them: durations of the own plan, infinite where a third of the profiles collide."""
    costs = np.empty((games, 2, PLANS, PLANS))
    costs[:, 0] = rng.uniform(5.0, 20.0, (games, PLANS, 1))
    costs[:, 1] = rng.uniform(5.0, 20.0, (games, 1, PLANS))
    collide = rng.random((games, PLANS, PLANS)) < 1 / 3
    costs[np.broadcast_to(collide[:, None], costs.shape)] = np.inf
    return Game(costs, ["robot", "human"], batch=[Axis("scene", games)])


def plain_numpy(costs: np.ndarray) -> np.ndarray:
    """Mark the equilibria of a batch with two reductions and two comparisons."""
    first, second = costs[:, 0], costs[:, 1]
    best = (first <= first.min(axis=1, keepdims=True)) & (second <= second.min(axis=2, keepdims=True))
    return np.asarray(best)


def numpy_loop(costs: np.ndarray) -> np.ndarray:
    """Mark the equilibria of one game after another."""
    marked = np.empty((len(costs), *costs.shape[2:]), bool)
    for game, (first, second) in enumerate(costs):
        marked[game] = (first <= first.min(axis=0)) & (second <= second.min(axis=1, keepdims=True))
    return marked


def peer_games(game: Game, count: int) -> tuple[Any, list[Any]] | None:
    """Return pygambit and some of the games as its own, or None where it is not installed."""
    try:
        import pygambit
    except ImportError:
        return None
    # it holds no infinities; the answer is compared with ours for the same stand-in
    texts = [write_nfg(game.restrict(scene=scene), infinity=1e6) for scene in range(count)]
    return pygambit, [pygambit.read_nfg(io.StringIO(text)) for text in texts]


def timed(action: Callable[[], object], repeats: int) -> list[tuple[float, float]]:
    """Return the seconds of some calls, by the clock and of the processor, after one call that nobody counts."""
    action()
    seconds = []
    for _ in range(repeats):
        begin, begin_cpu = time.perf_counter(), time.process_time()
        action()
        cpu = time.process_time() - begin_cpu
        seconds.append((time.perf_counter() - begin, cpu))
    return seconds


def measure(games: int, loop: int, peers: int, repeats: int) -> dict[str, Any]:
    """Time every row, in seconds a game; the peer's is None where it is missing."""
    game = random_games(np.random.default_rng(0), games)
    costs = game.costs
    ours = pure_equilibria(game).log_values == 0.0
    rows: list[dict[str, Any]] = []

    def row(name: str, action: Callable[[], object], each: int, times: int = repeats) -> None:
        clock, cpu = zip(*timed(action, times), strict=True)
        least, median, least_cpu = min(clock), statistics.median(clock), min(cpu)
        rows.append(
            {
                "name": name,
                "games": each,
                "least": least / each,
                "median": median / each,
                "least_cpu": least_cpu / each,
            }
        )

    assert np.array_equal(ours, plain_numpy(costs))
    assert np.array_equal(ours[:loop], numpy_loop(costs[:loop]))
    row("ours: pure_equilibria(game), a factor", lambda: pure_equilibria(game), games)
    row("ours: the mask alone", lambda: pure_mask2(costs), games)
    row("ours: free of collisions and undominated too", lambda: coordinated(game), games)
    row("one pass over the bytes of the costs: least", costs.min, games)
    row("one pass over the bytes of the costs: sum", costs.sum, games)
    row("plain NumPy, all games at once", lambda: plain_numpy(costs), games, max(1, repeats // 5))
    row("plain NumPy, one game after another", lambda: numpy_loop(costs[:loop]), loop, max(1, repeats // 5))
    single = game.restrict(scene=0)
    row("ours: one game, pure_equilibria", lambda: [pure_equilibria(single) for _ in range(200)], 200)
    row("ours: one game, undominated too", lambda: [coordinated(single) for _ in range(200)], 200)
    found = peer_games(game, peers)
    if found is not None:
        pygambit, theirs = found
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            counts = [len(pygambit.nash.enumpure_solve(one).equilibria) for one in theirs]
            expected = pure_equilibria(peer_costs(game, peers)).sum("robot_plan", "human_plan").values.round()
            assert counts == expected.astype(int).tolist()
            solve = lambda: [pygambit.nash.enumpure_solve(one) for one in theirs]  # noqa: E731
            row("pygambit, enumpure_solve", solve, peers, max(1, repeats // 5))
    return {
        "python": platform.python_version(),
        "numpy": np.__version__,
        "plans": PLANS,
        "bytes_a_game": costs[0].nbytes,
        "pygambit": None if found is None else str(getattr(found[0], "__version__", "unknown")),
        "rows": rows,
    }


def coordinated(game: Game) -> object:
    """Return what agents coordinate among."""
    return undominated(game, pure_equilibria(game) * finite_profiles(game))


def peer_costs(game: Game, count: int) -> Game:
    """Return the games that the peer is given, with its number in the place of infinity."""
    costs = game.costs[:count]
    return Game(np.where(np.isinf(costs), 1e6, costs), game.players, batch=[Axis("scene", count)])


def main() -> None:
    """Print the table, or the JSON object."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--quick", action="store_true", help="few games and repeats: a glance, not a measure")
    parser.add_argument("--json", action="store_true", help="one JSON object, in seconds a game")
    arguments = parser.parse_args()
    if hasattr(os, "sched_setaffinity"):
        os.sched_setaffinity(0, {max(os.sched_getaffinity(0))})
    sizes = (2_000, 200, 5, 3) if arguments.quick else (GAMES, LOOP_GAMES, PEER_GAMES, REPEATS)
    result = measure(*sizes)
    if result["pygambit"] is None:
        print(
            "pygambit is not installed: its row is left out (pip install 'ppinfer[peers]')", file=sys.stderr
        )
    if arguments.json:
        print(json.dumps(result))
        return
    print(f"Python {result['python']}, NumPy {result['numpy']}, pygambit {result['pygambit'] or 'missing'}")
    print(f"games of 2 players with {PLANS} plans each; microseconds a game; one core")
    print(f"{'':<48} {'games':>8} {'least':>10} {'median':>10} {'least cpu':>10} {'x ours':>10}")
    ours = result["rows"][0]["least_cpu"]
    for one in result["rows"]:
        print(
            f"{one['name']:<48} {one['games']:>8,} {1e6 * one['least']:>10.3f} {1e6 * one['median']:>10.3f} "
            f"{1e6 * one['least_cpu']:>10.3f} {one['least_cpu'] / ours:>10,.2f}"
        )
    print(
        f"aim: below {AIM_MICROSECONDS} microseconds a game, and {AIM_TIMES_PEER:,} times faster than pygambit"
    )


if __name__ == "__main__":
    main()
