"""The faces that a factor shows: xarray outside, a small table with bars in a notebook."""

from __future__ import annotations

import html
import math
from typing import Any

import numpy as np
import xarray as xr

from ppinfer.distributions.axis import Axis
from ppinfer.distributions.layout import Axes
from ppinfer.distributions.logspace import Array
from ppinfer.errors import AxisError

MOST_ROWS = 12
"""Rows of a table before its middle is elided."""


def signature(head: str, axes: Axes) -> str:
    """Return for example ``f(goal, trial): goal 3, trial 40``."""
    inside = ", ".join(axis.name for axis in axes)
    sizes = ", ".join(f"{axis.name} {len(axis)}" for axis in axes) or "a scalar"
    return f"{head}({inside}): {sizes}"


def to_xarray(axes: Axes, log_values: Array, *, name: str, attrs: dict[str, Any]) -> xr.DataArray:
    """Return a copy of the values with labelled dimensions; ``range(n)`` axes stay without a coordinate."""
    coords = {axis.name: axis.label_array() for axis in axes if axis.labels != range(len(axis))}
    return xr.DataArray(
        log_values.copy(), dims=[axis.name for axis in axes], coords=coords, name=name, attrs=attrs
    )


def axes_of_xarray(array: xr.DataArray) -> Axes:
    """Return the axes that an array's dimensions and coordinates describe.

    Raises
    ------
    AxisError
        If a dimension's name or labels cannot be an axis's.
    """
    axes = []
    for dimension, length in zip(array.dims, array.shape, strict=True):
        if not isinstance(dimension, str):
            raise AxisError(f"dimension {dimension!r} is not named by a string; rename it first")
        if dimension in array.indexes:
            axes.append(Axis(dimension, array.indexes[dimension].tolist()))
        else:
            axes.append(Axis(dimension, length))
    return tuple(axes)


def html_table(title: str, axes: Axes, log_values: Array, unit: str) -> str:
    """Return a small table, one row a cell with its labels, value and bar; many rows are elided.

    Parameters
    ----------
    title : str
        Above the table.
    axes : tuple of Axis
        The columns of labels.
    log_values : array
        One dimension an axis.
    unit : {"probability", "log value"}
        What the column of values shows. Bars are relative to the largest value shown.
    """
    flat = log_values.reshape(-1)
    shown = _shown_rows(len(flat))
    kept = [row for row in shown if row is not None]
    peak = max(float(flat[row]) for row in kept)
    head = "".join(f"<th>{html.escape(axis.name)}</th>" for axis in axes)
    rows = [f"<tr>{head}<th>{unit}</th><th></th></tr>"]
    for row in shown:
        if row is None:
            hidden = len(flat) - len(kept)
            rows.append(f'<tr><td colspan="{len(axes) + 2}">&hellip; {hidden} more &hellip;</td></tr>')
            continue
        value = float(flat[row])
        share = math.exp(value - peak) if peak > -math.inf else 0.0
        index = np.unravel_index(row, log_values.shape) if axes else ()
        labels = "".join(
            f"<td>{html.escape(str(axis.labels[int(i)]))}</td>" for axis, i in zip(axes, index, strict=True)
        )
        text = f"{math.exp(value):.4g}" if unit == "probability" else f"{value:.4g}"
        bar = f'<div style="background:#4477aa;height:0.8em;width:{100 * share:.1f}px"></div>'
        rows.append(
            f'<tr>{labels}<td style="text-align:right">{text}</td><td style="text-align:left">{bar}</td></tr>'
        )
    return f"<div><code>{html.escape(title)}</code><table>{''.join(rows)}</table></div>"


def _shown_rows(count: int) -> list[int | None]:
    """Return which rows to show, None standing for those left out of the middle."""
    if count <= MOST_ROWS:
        return list(range(count))
    half = MOST_ROWS // 2
    return [*range(half), None, *range(count - half, count)]
