"""How long it takes to find all equilibria of many agents who meet in collisions of pairs.

Run with ``python benchmarks/many_agents.py`` (``--quick`` for a glance, ``--json`` for one JSON object). One process.
Each row is the least and the median time over seeded games: costs uniform between 2 and 15 s, and each pair of plans of
two agents colliding with the same chance. Where the table of all profiles is small enough, the same equilibria are
found from it too, and counted. The aim: 8 agents of 8 plans each, a tenth of pairs colliding, under a second.
"""

from __future__ import annotations

import argparse
import json
import os
import platform
import statistics
import time
from collections.abc import Callable
from itertools import combinations
from typing import Any

# the libraries' threads would only be noise; this has to come before NumPy
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import numpy as np

from ppinfer.games import PairwiseGame, finite_profiles, pairwise_equilibria, pure_equilibria

SIZES = [
    (2, 8, 0.1), (4, 8, 0.1), (5, 8, 0.1), (6, 8, 0.1),
    (8, 8, 0.05), (8, 8, 0.1), (8, 8, 0.2), (8, 8, 0.3), (10, 8, 0.1), (12, 8, 0.1), (8, 12, 0.1), (10, 10, 0.3),
]  # fmt: skip
QUICK = [(4, 8, 0.1), (8, 8, 0.1)]
MOST_IN_TABLE = 300_000


def drawn(agents: int, plans: int, density: float, seed: int) -> PairwiseGame:
    """Draw a game."""
    rng = np.random.default_rng(seed)
    pairs = {pair: rng.random((plans, plans)) < density for pair in combinations(range(agents), 2)}
    return PairwiseGame(rng.uniform(2.0, 15.0, (agents, plans)), pairs, [f"agent{i}" for i in range(agents)])


def seconds(action: Callable[[], object]) -> float:
    """Time one call."""
    begin = time.perf_counter()
    action()
    return time.perf_counter() - begin


def measured(agents: int, plans: int, density: float, games: int) -> dict[str, Any]:
    """Time the search, and the table where it fits, over a few games."""
    some = [drawn(agents, plans, density, seed) for seed in range(games)]
    found = [pairwise_equilibria(game) for game in some]
    times = [seconds(lambda game=game: pairwise_equilibria(game)) for game in some]
    row: dict[str, Any] = {
        "agents": agents,
        "plans": plans,
        "density": density,
        "profiles": plans**agents,
        "table_bytes": 8 * agents * plans**agents,
        "equilibria": statistics.mean(map(len, found)),
        "least": min(times),
        "median": statistics.median(times),
    }
    if plans**agents <= MOST_IN_TABLE:

        def from_table(game: PairwiseGame) -> int:
            dense = game.to_game()
            return int((pure_equilibria(dense) * finite_profiles(dense)).values.sum())

        assert [from_table(game) for game in some] == list(map(len, found))
        row["table_median"] = statistics.median(seconds(lambda game=game: from_table(game)) for game in some)
    return row


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument(
        "--quick", action="store_true", help="two sizes and two games: a glance, not a measure"
    )
    parser.add_argument("--json", action="store_true", help="one JSON object, in seconds and bytes")
    arguments = parser.parse_args()
    rows = [
        measured(*size, games=2 if arguments.quick else 10) for size in (QUICK if arguments.quick else SIZES)
    ]
    if arguments.json:
        print(json.dumps({"python": platform.python_version(), "numpy": np.__version__, "rows": rows}))
        return
    print(f"Python {platform.python_version()}, NumPy {np.__version__}; milliseconds")
    print("agents  plans  colliding    profiles   table GB   equilibria     least    median   by table")
    for row in rows:
        table = f"{1e3 * row['table_median']:10.2f}" if "table_median" in row else f"{'-':>10}"
        print(
            f"{row['agents']:6d} {row['plans']:6d} {row['density']:10.2f} {row['profiles']:11.3g} "
            f"{row['table_bytes'] / 1e9:10.2g} {row['equilibria']:12.1f} "
            f"{1e3 * row['least']:9.2f} {1e3 * row['median']:9.2f} {table}"
        )


if __name__ == "__main__":
    main()
