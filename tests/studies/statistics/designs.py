"""Data sets with published analyses, and strategies that draw designs."""

import numpy as np
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from ppinfer.studies.statistics import RepeatedMeasures


def design(values, dv="score", factors=None):
    """Return measures whose subjects and levels have made-up names."""
    values = np.asarray(values, float)
    factors = factors or tuple(f"factor {number}" for number in range(values.ndim - 1))
    levels = tuple(
        tuple(f"{letter}{number}" for number in range(count))
        for letter, count in zip("abcd", values.shape[1:], strict=False)
    )
    subjects = tuple(f"p{number}" for number in range(len(values)))
    return RepeatedMeasures(dv, values, subjects, factors, levels)


# Field, Discovering Statistics: seconds until retching, by stick insect, kangaroo testicle, fish eye, witchetty grub
BUSHTUCKER = design(
    [
        [8, 7, 1, 6],
        [9, 5, 2, 5],
        [6, 2, 3, 8],
        [5, 3, 1, 9],
        [8, 4, 5, 8],
        [7, 5, 6, 7],
        [10, 2, 7, 2],
        [12, 6, 8, 1],
    ]
)
# the same, marks of four tutors for eight essays
TUTORS = design(
    [
        [62, 58, 63, 64],
        [63, 60, 68, 65],
        [65, 61, 72, 65],
        [68, 64, 58, 61],
        [69, 65, 54, 59],
        [71, 67, 65, 50],
        [78, 66, 67, 50],
        [75, 73, 75, 45],
    ]
)
# the same, attitudes to beer, wine and water after positive, negative and neutral imagery
ATTITUDES = design(
    np.reshape(
        [
            [1, 6, 5, 38, -5, 4, 10, -14, -2],
            [43, 30, 8, 20, -12, 4, 9, -10, -13],
            [15, 15, 12, 20, -15, 6, 6, -16, 1],
            [40, 30, 19, 28, -4, 0, 20, -10, 2],
            [8, 12, 8, 11, -2, 6, 27, 5, -5],
            [17, 17, 15, 17, -6, 6, 9, -6, -13],
            [30, 21, 21, 15, -2, 16, 19, -20, 3],
            [34, 23, 28, 27, -7, 7, 12, -12, 2],
            [34, 20, 26, 24, -10, 12, 12, -9, 4],
            [26, 27, 27, 23, -15, 14, 21, -6, 0],
            [1, -19, -10, 28, -13, 13, 33, -2, 9],
            [7, -18, 6, 26, -16, 19, 23, -17, 5],
            [22, -8, 4, 34, -23, 14, 21, -19, 0],
            [30, -6, 3, 32, -22, 21, 17, -11, 4],
            [40, -6, 0, 24, -9, 19, 15, -10, 2],
            [15, -9, 4, 29, -18, 7, 13, -17, 8],
            [20, -17, 9, 30, -17, 12, 16, -4, 10],
            [9, -12, -5, 24, -15, 18, 17, -4, 8],
            [14, -11, 7, 34, -14, 20, 19, -1, 12],
            [15, -6, 13, 23, -15, 15, 29, -1, 10],
        ],
        (20, 3, 3),
    ),
    factors=("drink", "imagery"),
)
# R's `sleep`: extra hours of sleep of ten patients with two drugs
SLEEP = design(
    np.transpose(
        [
            [0.7, -1.6, -0.2, -1.2, -0.1, 3.4, 3.7, 0.8, 0.0, 2.0],
            [1.9, 0.8, 1.1, 0.1, -0.1, 4.4, 5.5, 1.6, 4.6, 3.4],
        ]
    )
)


@st.composite
def whole_numbers(draw, *, factors=(1, 2), levels=(2, 4), subjects=(2, 7)):
    """Draw the values of a design as integers (Likert-like: ties and degenerate designs are likely)."""
    shape = (
        draw(st.integers(*subjects)),
        *draw(st.lists(st.integers(*levels), min_size=factors[0], max_size=factors[1])),
    )
    return draw(arrays(np.int64, shape, elements=st.integers(-4, 9)))
