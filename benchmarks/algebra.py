"""What the algebra costs next to bare NumPy arithmetic on the same numbers.

Run with ``python benchmarks/algebra.py`` (``--quick`` for a glance). One process; each row is timed in
alternation with its bare counterpart, and the least and the median of the repeats are printed. The aims: a
12x40x20 grid within 3x of the bare arithmetic, and an update of 3 labels under 10 microseconds.
"""

from __future__ import annotations

import argparse
import platform
import statistics
import timeit
from collections.abc import Callable
from functools import partial

import numpy as np

from ppinfer import Axis, Distribution, Factor
from ppinfer.distributions import filter_states, forward_filter, smooth

REPEATS = 15
SAMPLES = 1_000_000
Compare = Callable[[str, Callable[[], object], Callable[[], object], int], None]


def seconds(action: Callable[[], object], number: int) -> float:
    """Time one call, on average over a number of calls."""
    return timeit.timeit(action, number=number) / number


def print_comparison(
    name: str, ours: Callable[[], object], bare: Callable[[], object], number: int, *, repeats: int = REPEATS
) -> None:
    """Print the cost of ours and of the bare arithmetic, in microseconds, and their ratio."""
    number = max(1, number * repeats // REPEATS)
    # whatever compiles does it now
    ours()
    pairs = [(seconds(ours, number), seconds(bare, number)) for _ in range(repeats)]
    mine, theirs = zip(*pairs, strict=True)
    ratio = statistics.median(a / b for a, b in pairs)
    print(
        f"{name:<44} {1e6 * min(mine):9.2f} {1e6 * statistics.median(mine):9.2f} "
        f"{1e6 * min(theirs):9.2f} {ratio:8.2f}x"
    )


def normalised(log_values: np.ndarray, over: tuple[int, ...] | None) -> np.ndarray:
    """Normalise with bare NumPy."""
    centred = log_values - log_values.max(axis=over, keepdims=True)
    log_p: np.ndarray = centred - np.log(np.exp(centred).sum(axis=over, keepdims=True))
    return log_p


def grids(rng: np.random.Generator, compare: Compare) -> None:
    """Time what a control step composes dozens of."""
    axes = [Axis("robot_plan", 12), Axis("human_plan", 40), Axis("goal", 20)]
    a, b = rng.normal(size=(2, 12, 40, 20))
    row = rng.normal(size=40)
    f, g, h = Factor(axes, a), Factor(axes, b), Factor([axes[1]], row)
    again = Factor([Axis(axis.name, axis.labels) for axis in axes], b)
    compare("12x40x20: f * g", lambda: f * g, lambda: a + b, 2000)
    compare("12x40x20: f * g, axes made separately", lambda: f * again, lambda: a + b, 2000)
    compare("12x40x20: f * h, h over one axis", lambda: f * h, lambda: a + row[:, None], 2000)
    compare(
        "12x40x20: normalise over all axes", lambda: f.normalize(*f.names), lambda: normalised(a, None), 300
    )
    compare(
        "12x40x20: normalise over one axis", lambda: f.normalize("goal"), lambda: normalised(a, (2,)), 300
    )
    compare("12x40x20: sum over one axis", lambda: f.sum("goal"), lambda: np.log(np.exp(a).sum(axis=2)), 300)
    array, other = f.to_xarray(), g.to_xarray()
    compare("12x40x20: f * g as xarray (for the record)", lambda: array + other, lambda: a + b, 200)


def labels(rng: np.random.Generator, compare: Compare) -> None:
    """Time what a robot does at each step."""
    goal = Axis("goal", ["cup", "bowl", "mug"])
    prior, log_likelihood = Distribution.uniform(goal), rng.normal(size=3)
    likelihood, log_prior = Factor([goal], log_likelihood), prior.log_values
    bare = lambda: normalised(log_prior + log_likelihood, None)  # noqa: E731
    compare("3 labels: update", lambda: prior.update(likelihood), bare, 5000)
    compare(
        "3 labels: factor made and update", lambda: prior.update(Factor([goal], log_likelihood)), bare, 5000
    )
    moves = Factor([goal, goal.rename("next_goal")], rng.normal(size=(3, 3))).normalize("next_goal")
    table = moves.values
    compare(
        "3 labels: predict", lambda: prior.predict(moves), lambda: np.log(np.exp(log_prior) @ table), 2000
    )


def scans(rng: np.random.Generator, compare: Compare, samples: int) -> None:
    """Offline: five goals in rows of a thousand samples, next to a copy of the same bytes."""
    rows, k = samples // 1000, 5
    name = f"{samples:,} samples, 5 goals"
    log_likelihood = rng.normal(size=(samples, k))
    sizes, priors = np.full(rows, samples // rows), np.zeros((rows, k))
    stay = np.log(0.98 * np.eye(k) + 0.02 / k)[None]
    copy = log_likelihood.copy
    compare(
        f"{name}: filter, no transition",
        lambda: forward_filter(log_likelihood, sizes, priors),
        copy,
        1,
    )
    compare(f"{name}: filter", lambda: forward_filter(log_likelihood, sizes, priors, stay), copy, 1)
    compare(f"{name}: smooth", lambda: smooth(log_likelihood, sizes, priors, stay), copy, 1)
    goal = Axis("goal", k)
    factor = Factor(
        [Axis("trial", rows), Axis("sample", samples // rows), goal], log_likelihood.reshape(rows, -1, k)
    )
    prior = Distribution.uniform(goal)
    compare(f"{name}: filter_states", lambda: filter_states(prior, None, factor), copy, 1)


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument(
        "--quick", action="store_true", help="few repeats and samples: a glance, not a measure"
    )
    quick = parser.parse_args().quick
    repeats = 1 if quick else REPEATS
    compare = partial(print_comparison, repeats=repeats)
    print(f"Python {platform.python_version()}, NumPy {np.__version__}; microseconds, {repeats} repeats")
    print(f"{'':<44} {'ours min':>9} {'median':>9} {'bare min':>9} {'ratio':>9}")
    rng = np.random.default_rng(0)
    grids(rng, compare)
    labels(rng, compare)
    scans(rng, compare, SAMPLES // 100 if quick else SAMPLES)


if __name__ == "__main__":
    main()
