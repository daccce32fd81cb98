"""Writing strategic games as Gambit's ``.nfg`` files, which hold payoffs to be maximised: negative costs."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Literal, TypeAlias

import numpy as np

from ppinfer.distributions import Axis
from ppinfer.distributions.axis import first_cell
from ppinfer.errors import GameError
from ppinfer.games.game import Game

Form: TypeAlias = Literal["payoffs", "outcomes"]
"""The two kinds of ``.nfg`` files."""


def write_nfg(
    game: Game,
    path: str | Path | None = None,
    *,
    form: Form = "payoffs",
    title: str = "",
    comment: str = "",
    infinity: float | None = None,
) -> str:
    """Write a game as a Gambit ``.nfg`` file, from which `read_nfg` gives every float back exactly.

    Parameters
    ----------
    game : Game
        One game, without batch axes, all of whose profiles exist.
    path : str or Path, optional
        Where to write it; None: only the text is returned.
    form : {"payoffs", "outcomes"}
        Whether to list the payoffs of every profile, or the different outcomes and the number of each profile's.
    title, comment : str
        What Gambit shows of it.
    infinity : float, optional
        The cost to write in place of an infinite one; above all finite costs of the game. Reading it back with the same
        number gives the infinities back.

    Returns
    -------
    str
        The file's text. Plans labelled 0, 1, ... are written as counts, all others by name.

    Raises
    ------
    GameError
        If the game has batch axes or absent profiles, or a cost is infinite and there is no number to stand in for it;
        the message names the cell. Nothing is written then.

    Examples
    --------
    >>> print(write_nfg(Game([[[1.0, 2.0]], [[0.5, 0.0]]], ["robot", "human"]), title="Passing"), end="")
    NFG 1 R "Passing" { "robot" "human" }
    <BLANKLINE>
    { 1 2 }
    ""
    <BLANKLINE>
    -1 -0.5 -2 0
    """
    if form not in ("payoffs", "outcomes"):
        raise GameError(f"form is 'payoffs' or 'outcomes', not {form!r}")
    payoffs = _payoffs_of(game, infinity)
    players = " ".join(_quoted(player) for player in game.players)
    if all(axis.labels == range(len(axis)) for axis in game.plans):
        strategies = " ".join(str(len(axis)) for axis in game.plans)
    else:
        strategies = "\n  ".join(
            "{ " + " ".join(_quoted(str(label)) for label in axis.labels) + " }" for axis in game.plans
        )
    lines = [f"NFG 1 R {_quoted(title)} {{ {players} }}", "", f"{{ {strategies} }}", _quoted(comment), ""]
    if form == "payoffs":
        lines.append(" ".join(_number(payoff) for payoff in payoffs.ravel().tolist()))
    else:
        outcomes, which = np.unique(payoffs, axis=0, return_inverse=True)
        rows = [", ".join(map(_number, outcome)) for outcome in outcomes.tolist()]
        lines += ["{", *(f'{{ "" {row} }}' for row in rows), "}"]
        lines.append(" ".join(str(index + 1) for index in which.ravel().tolist()))
    text = "\n".join(lines) + "\n"
    if path is not None:
        Path(path).write_text(text, encoding="utf-8", newline="\n")
    return text


def _payoffs_of(game: Game, infinity: float | None) -> np.ndarray:
    """Return (profile, player) payoffs in the file's order, or say what a file cannot hold."""
    if game.batch:
        names = ", ".join(axis.name for axis in game.batch)
        raise GameError(
            f"a file holds one game, but this has batch axes ({names}); restrict({names}=...) picks one"
        )
    if game.present is not None:
        raise GameError(
            f"a file cannot leave profiles out, but {first_cell(game.plans, ~game.present)} is absent; restrict the "
            "plans to profiles that exist, or give it a cost"
        )
    costs = game.costs
    infinite = costs == np.inf
    if infinity is not None:
        stand_in = checked_infinity(infinity)
        beyond = (costs >= stand_in) & ~infinite
        if beyond.any():
            cell = first_cell((Axis("player", game.players), *game.plans), beyond)
            raise GameError(
                f"infinity={infinity} cannot stand in for infinite costs: the cost at {cell} is {costs[beyond][0]}; "
                "choose a number above all finite costs"
            )
        costs = np.where(infinite, stand_in, costs)
    elif infinite.any():
        cell = first_cell((Axis("player", game.players), *game.plans), infinite)
        raise GameError(
            f"a file cannot hold infinities, but the cost at {cell} is inf; give a cost to write in its place, as in "
            "infinity=1e6, and give it again to read the file"
        )
    count = len(game.players)
    # a cost of 0 is a payoff of 0, not of -0
    return np.asarray(0.0 - costs.transpose(*range(count, 0, -1), 0).reshape(-1, count))


def _number(payoff: float) -> str:
    """Return the shortest text that is this float again."""
    return repr(payoff).removesuffix(".0")


def _quoted(label: str) -> str:
    return '"' + label.replace("\\", "\\\\").replace('"', '\\"') + '"'


def checked_infinity(infinity: float) -> float:
    """Return the number that stands in for infinite costs, or say why it cannot.

    Examples
    --------
    >>> checked_infinity(1e6)
    1000000.0
    """
    value = float(infinity)
    if not math.isfinite(value):
        raise GameError(f"infinity= is the finite cost that stands in for an infinite one, not {infinity}")
    return value
