"""The face that a game shows in a notebook: its cost table, with the equilibria marked."""

from __future__ import annotations

import html
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from ppinfer.games.game import Game

MOST_CELLS = 144
"""Profiles of a two-player game that are still shown as a table."""


def html_table(game: Game) -> str:
    """Return one game of two players as its cost table, equilibria in bold; any other as its title alone.

    Examples
    --------
    >>> from ppinfer.games import Game
    >>> "<b>1, 2</b>" in html_table(Game([[[1.0, 3.0]], [[2.0, 2.5]]], ["robot", "human"]))
    True
    """
    title = f"<code>{html.escape(repr(game))}</code>"
    if game.batch or len(game.players) != 2 or game.costs[0].size > MOST_CELLS:
        return f"<div>{title}</div>"
    from ppinfer.games.equilibria import pure_equilibria

    equilibrium = np.isfinite(pure_equilibria(game).log_values)
    rows_axis, columns_axis = game.plans
    head = "".join(f"<th>{html.escape(str(label))}</th>" for label in columns_axis.labels)
    corner = f"{html.escape(rows_axis.name)} \\ {html.escape(columns_axis.name)}"
    rows = [f"<tr><th>{corner}</th>{head}</tr>"]
    for i, label in enumerate(rows_axis.labels):
        cells = []
        for j in range(len(columns_axis)):
            text = ", ".join(f"{cost:.4g}" for cost in game.costs[:, i, j])
            if game.present is not None and not game.present[i, j]:
                text = "absent"
            cells.append(f"<td>{f'<b>{text}</b>' if equilibrium[i, j] else text}</td>")
        rows.append(f"<tr><th>{html.escape(str(label))}</th>{''.join(cells)}</tr>")
    return f"<div>{title}<table>{''.join(rows)}</table></div>"
