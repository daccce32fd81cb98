"""Reading strategic games from Gambit's ``.nfg`` files; these hold payoffs to be maximised, and a cost is minus one."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np

from ppinfer.errors import GameFileError
from ppinfer.games.gambit_tokens import Tokens
from ppinfer.games.gambit_writing import checked_infinity
from ppinfer.games.game import Game, plan_axes
from ppinfer.guarding import refuse_special


def read_nfg(source: str | Path, *, infinity: float | None = None) -> Game:
    """Read a strategic game, of any number of players, from either kind of ``.nfg`` file.

    A file lists the payoffs of every profile, or outcomes and the number of each profile's outcome (0 is the outcome
    that pays everybody nothing); in both the first player's strategy varies fastest.

    Parameters
    ----------
    source : Path or str
        The file. A str that holds a brace or several lines is the text of a game itself.
    infinity : float, optional
        Costs of at least this are read as infinite, since a file cannot hold infinities. None: none are.

    Returns
    -------
    Game
        Its costs are the payoffs' negatives; rationals are rounded to the nearest float. Strategies that are only
        counted become plans 0, 1, ...; one whose name is empty is called by its number, from 1, as Gambit shows it.
        Player "robot" gets the plan axis ``robot_plan``. The title and the comment are not kept.

    Raises
    ------
    GameFileError
        If the file cannot be read as a strategic game; the message names file, line and column, what was expected and
        what is there.

    See Also
    --------
    write_nfg : the way back.

    Examples
    --------
    >>> game = read_nfg('NFG 1 R "Dilemma" { "row" "column" } { 2 2 }  9 9  10 0  0 10  1 1')
    >>> game.costs[game.player("row")]
    array([[ -9.,   0.],
           [-10.,  -1.]])
    """
    name, text = _text_of(source)
    tokens = Tokens(name, text)
    _read_head(tokens)
    players = _read_players(tokens)
    labels = _read_strategies(tokens, players)
    if tokens.kind == "text":
        tokens.label("a comment")
    sizes = tuple(some if isinstance(some, int) else len(some) for some in labels)
    if tokens.next_is("{"):
        payoffs = _read_outcomes(tokens, players, math.prod(sizes))
    else:
        payoffs = _read_payoffs(tokens, players, math.prod(sizes))
    if not tokens.at_end():
        tokens.refuse(f"the end of the file after all {math.prod(sizes)} profiles")
    # the first player's strategy varies fastest: the axes of the table are reversed
    count = len(players)
    costs = 0.0 - payoffs.reshape(*sizes[::-1], count).transpose(count, *range(count - 1, -1, -1))
    if infinity is not None:
        costs = np.where(costs >= checked_infinity(infinity), np.inf, costs)
    return Game(costs, players, plan_axes(players, labels))


def _text_of(source: str | Path) -> tuple[str, str]:
    """Return what to call the file, and its text, with line feeds alone between lines."""
    if isinstance(source, str) and ("{" in source or "\n" in source):
        name, text = "the game's text", source.removeprefix("\ufeff")
    else:
        name = str(source)
        try:
            refuse_special(source, GameFileError)
            data = Path(source).read_bytes()
        except (OSError, ValueError) as error:  # a name may be one that no file can have
            reason = error.strerror if isinstance(error, OSError) else error
            raise GameFileError(f"{name}: cannot be read: {reason}") from None
        try:
            text = data.decode("utf-8-sig")
        except UnicodeDecodeError as error:
            line = data.count(b"\n", 0, error.start) + 1
            column = error.start - data.rfind(b"\n", 0, error.start)
            raise GameFileError(
                f"{name}: line {line}, column {column}: expected text in UTF-8, got the byte "
                f"0x{data[error.start]:02x}; save the file as UTF-8"
            ) from None
    return name, text.replace("\r\n", "\n").replace("\r", "\n")


def _read_head(tokens: Tokens) -> None:
    tokens.keyword(("NFG",), "NFG, which begins a strategic game")
    tokens.keyword(("1",), "1, the version of the format")
    tokens.keyword(("R", "D"), "R or D, the kind of its numbers")
    tokens.label("the title")


def _read_players(tokens: Tokens) -> list[str]:
    tokens.symbol("{", "before the players")
    players: list[str] = []
    while not players or not tokens.next_is("}"):
        position = tokens.position
        # Gambit shows a player without a name by its number
        name = tokens.label("a player's name" if players else "at least one player's name")
        name = name or f"Player {len(players) + 1}"
        if name in players:
            tokens.refuse_at(
                position, f"expected another name, got {name!r}, which is player {players.index(name) + 1}"
            )
        players.append(name)
    tokens.symbol("}", "after the players")
    return players


def _read_strategies(tokens: Tokens, players: list[str]) -> list[Any]:
    """Return the names of each player's strategies, or how many there are where that is all the file says."""
    tokens.symbol("{", "before the strategies")
    named = tokens.next_is("{")
    labels: list[Any] = []
    for player in players:
        if not named:
            labels.append(tokens.integer(1, f"the number of strategies of {player!r}, at least 1"))
            tokens.skip_comma()
            continue
        tokens.symbol("{", f"before the names of the strategies of {player!r}")
        names: list[str] = []
        places: list[int] = []
        while not names or not tokens.next_is("}"):
            places.append(tokens.position)
            names.append(tokens.label(f"the name of a strategy of {player!r}"))
        tokens.symbol("}", "")
        labels.append(_numbered(tokens, player, names, places))
    tokens.symbol("}", f"after the strategies of {len(players)} players")
    return labels


def _numbered(tokens: Tokens, player: str, names: list[str], places: list[int]) -> list[str]:
    """Return strategies' names with a number for each empty one; refuse repeated ones."""
    taken = set(names)
    unique: dict[str, int] = {}
    for number, (name, place) in enumerate(zip(names, places, strict=True), start=1):
        if not name:
            name = str(number)
            while name in taken:
                name = f"_{name}"
            taken.add(name)
        if name in unique:
            first = unique[name]
            tokens.refuse_at(
                place, f"expected another name, got {name!r}, which is strategy {first} of {player!r} already"
            )
        unique[name] = number
    return list(unique)


def _read_payoffs(tokens: Tokens, players: list[str], profiles: int) -> np.ndarray:
    """Return (profile, player) payoffs, profiles as the file has them."""
    # nothing is made room for that the file does not hold, whatever sizes it claims
    numbers: list[float] = []
    count = profiles * len(players)
    while len(numbers) < count:
        profile, player = divmod(len(numbers), len(players))
        numbers.append(
            tokens.number(f"the payoff of {players[player]!r} in profile {profile + 1} of {profiles}")
        )
        tokens.skip_comma()
    return np.array(numbers)


def _read_outcomes(tokens: Tokens, players: list[str], profiles: int) -> np.ndarray:
    """Return (profile, player) payoffs by way of the outcomes."""
    tokens.symbol("{", "before the outcomes")
    # number 0 pays nothing
    outcomes = [[0.0] * len(players)]
    while not tokens.next_is("}"):
        tokens.symbol("{", "before an outcome, or } after the last")
        tokens.label("the name of an outcome")
        payoffs = []
        for player in players:
            payoffs.append(tokens.number(f"the payoff of {player!r} in outcome {len(outcomes)}"))
            tokens.skip_comma()
        tokens.symbol("}", f"after the payoffs of {len(players)} players")
        outcomes.append(payoffs)
    tokens.symbol("}", "after the outcomes")
    which: list[int] = []
    while len(which) < profiles:
        position = tokens.position
        what = (
            f"the outcome of profile {len(which) + 1} of {profiles}, a number from 0 to {len(outcomes) - 1}"
        )
        index = tokens.integer(0, what)
        if index >= len(outcomes):
            tokens.refuse_at(position, f"expected {what}, got {index}")
        which.append(index)
        tokens.skip_comma()
    return np.array(outcomes)[which]
