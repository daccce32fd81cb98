"""Orthonormal contrasts: what each effect of a within-subject design compares, subject by subject."""

from __future__ import annotations

import itertools
from collections.abc import Iterator

import numpy as np
from jaxtyping import Float

from ppinfer.studies.statistics.measures import RepeatedMeasures


def orthonormal_contrasts(levels: int) -> Float[np.ndarray, "level contrast"]:
    """Return Helmert contrasts: orthonormal columns, each adding up to zero.

    Examples
    --------
    >>> C = orthonormal_contrasts(3)
    >>> bool(np.allclose(C.T @ C, np.eye(2)) and np.allclose(C.sum(axis=0), 0))
    True
    """
    C = np.zeros((levels, levels - 1))
    for column in range(levels - 1):
        C[: column + 1, column] = 1.0
        C[column + 1, column] = -(column + 1.0)
        C[:, column] /= np.sqrt((column + 1.0) * (column + 2.0))
    return C


def effects_of(factors: int) -> Iterator[tuple[int, ...]]:
    """Yield the effects of a full design: single factors first, then interactions of two, and so on.

    Examples
    --------
    >>> list(effects_of(2))
    [(0,), (1,), (0, 1)]
    """
    for size in range(1, factors + 1):
        yield from itertools.combinations(range(factors), size)


def effect_scores(
    values: Float[np.ndarray, "subject *level"], effect: tuple[int, ...]
) -> Float[np.ndarray, "subject contrast"]:
    r"""Return each subject's scores on the contrasts of an effect.

    The contrasts are the Kronecker product over factors of :math:`C_f` (factors in the effect) and of
    :math:`1/\sqrt{k_f}` (averaged factors), so squares of scores are sums of squares of the design.

    Examples
    --------
    >>> effect_scores(np.array([[3.0, 1.0], [5.0, 5.0]]), (0,)) / np.sqrt(0.5)
    array([[2.],
           [0.]])
    """
    scores = values
    for factor, levels in enumerate(values.shape[1:]):
        inside = factor in effect
        contrast = orthonormal_contrasts(levels) if inside else np.full((levels, 1), 1 / np.sqrt(levels))
        scores = np.moveaxis(np.tensordot(scores, contrast, axes=(factor + 1, 0)), -1, factor + 1)
    return scores.reshape(len(values), -1)


def marginal_values(
    measures: RepeatedMeasures, effect: tuple[int, ...]
) -> tuple[list[tuple[str, ...]], Float[np.ndarray, "subject cell"]]:
    """Return the cells of an effect by the names of their levels, and each subject's mean in each of them.

    Examples
    --------
    >>> design = RepeatedMeasures("y", np.array([[1.0, 3.0]]), ("ann",), ("robot",), (("old", "new"),))
    >>> marginal_values(design, (0,))
    ([('old',), ('new',)], array([[1., 3.]]))
    """
    others = tuple(axis + 1 for axis in range(len(measures.factors)) if axis not in effect)
    cells = list(itertools.product(*(measures.levels[factor] for factor in effect)))
    return cells, measures.values.mean(axis=others).reshape(len(measures.subjects), -1)
