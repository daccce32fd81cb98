"""A game: what every profile of plans costs every player, for one game or for a batch of them."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
from jaxtyping import Bool, Float

from ppinfer.distributions import Axis, Label
from ppinfer.distributions.axis import first_cell
from ppinfer.distributions.layout import positions_of
from ppinfer.errors import AxisError, GameError

if TYPE_CHECKING:
    from pathlib import Path


@dataclass(frozen=True, init=False, repr=False, eq=False)
class Game:
    """Costs of N players over the grid of their plans, to be minimised; with leading batch axes, many games.

    A profile (one plan for every player) is a cell of the grid of plan axes. Frozen: the arrays are read-only copies.

    Parameters
    ----------
    costs : array of float, shape (*batch, player, *plans)
        What each profile costs each player, s unless stated otherwise; +inf is allowed (a collision).
    players : sequence of str
        The players' names, in the order of the player dimension.
    plans : sequence of Axis, optional
        One axis of plans for each player; by default ``Axis(f"{player}_plan", k)``.
    batch : sequence of Axis, optional
        One axis for each leading dimension: these index independent games.
    present : array of bool, shape (*batch, *plans), optional
        Which profiles exist; all of them if None. One that does not is neither an equilibrium nor something that a
        player could deviate to. Its costs are not looked at, and read inf.

    Raises
    ------
    GameError
        If the shapes do not fit, players repeat, or a cost is NaN or -inf; the message names the cell.
    AxisError
        If two axes share a name.

    Examples
    --------
    >>> game = Game([[[1.0, np.inf], [np.inf, 2.0]], [[2.0, np.inf], [np.inf, 1.0]]], ["robot", "human"])
    >>> game
    Game of robot, human: robot_plan 2, human_plan 2
    >>> game.costs[game.player("human"), 1, 1].item()
    1.0
    """

    costs: Float[np.ndarray, "..."]
    players: tuple[str, ...]
    plans: tuple[Axis, ...] = ()
    batch: tuple[Axis, ...] = ()
    present: Bool[np.ndarray, "..."] | None = None

    def __init__(
        self,
        costs: Any,
        players: Sequence[str],
        plans: Sequence[Axis] | None = None,
        batch: Sequence[Axis] = (),
        present: Any = None,
    ) -> None:
        try:
            if np.iscomplexobj(costs):
                raise TypeError("they are complex")
            array = np.array(costs, dtype=np.float64, order="C")
        except (TypeError, ValueError) as error:
            raise GameError(f"costs must be real numbers on a rectangular grid: {error}") from None
        names = checked_players(players)
        apart = tuple(batch)
        if plans is None:
            sizes = array.shape[len(apart) + 1 :]
            if len(sizes) != len(names):
                raise GameError(_shape_message(array.shape, names, apart, None))
            own = plan_axes(names, sizes)
        else:
            own = tuple(plans)
        _check_axes(apart + own)
        expected = (*map(len, apart), len(names), *map(len, own))
        if len(own) != len(names) or array.shape != expected:
            raise GameError(_shape_message(array.shape, names, apart, own))
        exists = None if present is None else _checked_present(present, apart + own)
        if exists is not None:
            # inf, so that nobody's best reply is ever an absent profile
            np.copyto(array, np.inf, where=~np.expand_dims(exists, len(apart)))
        if not array.min() > -np.inf:  # NaN fails this as well
            _refuse_costs(array, names, apart, own)
        array.setflags(write=False)
        # frozen for everybody else
        vars(self).update(costs=array, players=names, plans=own, batch=apart, present=exists)

    @cached_property
    def axes(self) -> tuple[Axis, ...]:
        """The batch axes, then the plan axes: the grid that equilibria are marked on."""
        return self.batch + self.plans

    def player(self, name: str) -> int:
        """Return the position of a player; a GameError says who there is.

        Examples
        --------
        >>> Game([[[1.0]], [[2.0]]], ["robot", "human"]).player("human")
        1
        """
        try:
            return self.players.index(name)
        except ValueError:
            raise GameError(f"there is no player {name!r}; there are {', '.join(self.players)}") from None

    def restrict(self, **labels: Label | np.generic | Iterable[Any]) -> Game:
        """Keep some labels of some axes: one label or several (a list, a range).

        One label of a batch axis drops that axis. A plan axis always stays, because its player does.

        Examples
        --------
        >>> game = Game(np.arange(8.0).reshape(2, 2, 2), ["robot", "human"])
        >>> game.restrict(human_plan=1).costs[0]
        array([[1.],
               [3.]])
        """
        places = dict(zip(positions_of(self.axes, labels), labels.values(), strict=True))
        costs, present = self.costs, self.present
        batch, plans = list(self.batch), list(self.plans)
        # from the last dimension on, so that dropping one leaves the others where they are
        for position in sorted(places, reverse=True):
            chosen, axis = places[position], self.axes[position]
            several = isinstance(chosen, Iterable) and not isinstance(chosen, str)
            some: Iterable[Any] = chosen if several else [chosen]  # type: ignore[assignment]
            shorter, index = axis.restrict(some)
            is_plan = position >= len(self.batch)
            kept: Any = index if several or is_plan else int(index[0])
            costs = costs.take(kept, axis=position + is_plan)
            present = None if present is None else present.take(kept, axis=position)
            if is_plan:
                plans[position - len(self.batch)] = shorter
            elif several:
                batch[position] = shorter
            else:
                del batch[position]
        return Game(costs, self.players, plans, batch, present)

    @staticmethod
    def from_nfg(source: str | Path, *, infinity: float | None = None) -> Game:
        """Read a strategic game from a Gambit ``.nfg`` file; see `ppinfer.games.read_nfg`."""
        from ppinfer.games.gambit_reading import read_nfg

        return read_nfg(source, infinity=infinity)

    def to_nfg(
        self,
        path: str | Path | None = None,
        *,
        form: Literal["payoffs", "outcomes"] = "payoffs",
        title: str = "",
        comment: str = "",
        infinity: float | None = None,
    ) -> str:
        """Write it as a Gambit ``.nfg`` file, and return the text; see `ppinfer.games.write_nfg`."""
        from ppinfer.games.gambit_writing import write_nfg

        return write_nfg(self, path, form=form, title=title, comment=comment, infinity=infinity)

    def __eq__(self, other: object) -> bool:
        """Whether the other has the same players, axes, profiles and costs, exactly."""
        if not isinstance(other, Game):
            return NotImplemented
        return (
            (self.players, self.axes, len(self.batch)) == (other.players, other.axes, len(other.batch))
            and np.array_equal(self.costs, other.costs)
            and (self.present is None) == (other.present is None)
            and (self.present is None or np.array_equal(self.present, other.present))  # type: ignore[arg-type]
        )

    __hash__ = None  # type: ignore[assignment]  # compared by value, and values are floats

    def __repr__(self) -> str:
        sizes = ", ".join(f"{axis.name} {len(axis)}" for axis in self.axes)
        return f"Game of {', '.join(self.players)}: {sizes}"

    def _repr_html_(self) -> str:
        from ppinfer.games.tables import html_table

        return html_table(self)

    def __reduce__(self) -> tuple[Any, ...]:
        return (Game, (self.costs, self.players, self.plans, self.batch, self.present))


def checked_players(players: Sequence[str]) -> tuple[str, ...]:
    """Return players' names as a tuple, or say what is wrong with them."""
    if isinstance(players, str):
        raise GameError(f"players must be a sequence of names, not one string {players!r}")
    names = tuple(players)
    for position, name in enumerate(names):
        if not isinstance(name, str):
            raise GameError(f"player {position} is {name!r}; players are named by strings")
        if name in names[:position]:
            raise GameError(f"two players are called {name!r}; rename one of them")
    if not names:
        raise GameError("a game needs at least one player")
    return names


def plan_axes(players: Sequence[str], labels: Sequence[Any]) -> tuple[Axis, ...]:
    """Return an axis of plans for each player, named for the player as far as an axis can be.

    Examples
    --------
    >>> plan_axes(["robot", "Player 2"], [8, ["left", "right"]])
    (Axis('robot_plan', 8), Axis('Player_2_plan', ['left', 'right']))
    """
    axes: list[Axis] = []
    for player, some in zip(players, labels, strict=True):
        # a plan axis is picked by keyword, but a player may be called "Player 2"
        stem = "".join(letter if f"_{letter}".isidentifier() else "_" for letter in player)
        name = f"{stem}_plan" if f"{stem}_plan".isidentifier() else f"player_{stem}_plan"
        while any(axis.name == name for axis in axes):
            name = f"{name}_{len(axes) + 1}"
        axes.append(Axis(name, some))
    return tuple(axes)


def _check_axes(axes: tuple[Axis, ...]) -> None:
    for position, axis in enumerate(axes):
        if not isinstance(axis, Axis):
            raise AxisError(f"expected an Axis, got {axis!r}; write Axis(name, labels)")
        if any(axis.name == other.name for other in axes[:position]):
            raise AxisError(f"two axes of the game are called {axis.name!r}; rename one of them")


def _shape_message(
    shape: tuple[int, ...], players: tuple[str, ...], batch: tuple[Axis, ...], plans: tuple[Axis, ...] | None
) -> str:
    who = f"{len(players)} player{'s' if len(players) > 1 else ''} ({', '.join(players)})"
    if plans is None:
        return (
            f"costs have shape {shape}; {who} call for {len(batch) + 1 + len(players)} dimensions: "
            f"{len(batch)} of the batch, the player, and one for the plans of each player"
        )
    if len(plans) != len(players):
        return f"there are {who} and {len(plans)} plan axes; each player has one"
    expected = (*map(len, batch), len(players), *map(len, plans))
    named = ", ".join([axis.name for axis in batch] + ["player"] + [axis.name for axis in plans])
    return f"costs have shape {shape}, but ({named}) calls for {expected}"


def _checked_present(present: Any, axes: tuple[Axis, ...]) -> Bool[np.ndarray, "..."] | None:
    exists = np.array(present, order="C")
    shape = tuple(map(len, axes))
    if exists.dtype != np.bool_ or exists.shape != shape:
        raise GameError(
            f"present must be an array of bool of shape {shape}, one for each profile; got {exists.dtype} of "
            f"shape {exists.shape}"
        )
    exists.setflags(write=False)
    return None if exists.all() else exists


def _refuse_costs(
    costs: np.ndarray, players: tuple[str, ...], batch: tuple[Axis, ...], plans: tuple[Axis, ...]
) -> None:
    wrong = ~(costs > -np.inf)
    cell = first_cell((*batch, Axis("player", players), *plans), wrong)
    raise GameError(
        f"the cost is {costs[wrong][0]} at {cell}; costs are finite or +inf (a profile that does not exist is "
        "masked: present=)"
    )
