"""What robot and human of a simulated game took each other for, each robot in its own way, as far as a log says."""

from __future__ import annotations

import json
from dataclasses import asdict, dataclass, replace
from typing import Any

import xarray as xr

from ppinfer.goals import GoalLQR
from ppinfer.goals.conditional import SoftmaxConditional
from ppinfer.goals.mental_model import paper_agent
from ppinfer.goals.rationality import SWITCHING_RATIONALITIES
from ppinfer.goals.reacted import ReactedConditional

_SOFTMAX, _REACTED = SoftmaxConditional(), ReactedConditional()
# how sure the switching robot wants to be that the human is resolute
_RESOLUTE = 0.5


@dataclass(frozen=True)
class AssumedReaction:
    """How one robot takes the human to react to its goal.

    Parameters
    ----------
    conditional : SoftmaxConditional or ReactedConditional, optional
        The reaction; None where it expects none, and b_post is its belief.
    unsure : SoftmaxConditional or ReactedConditional, optional
        The reaction while the human looks unsure; None where that makes no difference.
    rationalities : tuple of float
        What it considers the human's rationality to be (1/cost), where it does: its belief about goals is the marginal
        then, and the human looks unsure while the greatest of these is less probable than `resolute`.
    resolute : float
        That probability.
    told : bool
        Whether the log says so. Of a robot of one's own it does not: what it held live is in the log alone.

    Examples
    --------
    >>> AssumedReaction(None).said, AssumedReaction(ReactedConditional()).said
    ('none', 'reacted')
    """

    conditional: SoftmaxConditional | ReactedConditional | None
    unsure: SoftmaxConditional | ReactedConditional | None = None
    rationalities: tuple[float, ...] = ()
    resolute: float = _RESOLUTE
    told: bool = True

    @property
    def said(self) -> str:
        """The reaction in a few words."""
        name = "none" if self.conditional is None else self.conditional.name
        if self.unsure is not None:
            name = f"{name}, {self.unsure.name} while the human looks unsure"
        return name if self.told else f"{name} (the log does not say; what it held live is its own)"


def assumed_agent(log: xr.Dataset) -> GoalLQR:
    """Return what robot and human took each other for in a simulated game, as its log says; else `paper_agent`.

    Examples
    --------
    >>> from ppinfer.testing import example_interaction_log
    >>> assumed_agent(example_interaction_log()) == paper_agent()
    True
    """
    said = _configuration(log)
    if said.get("world") != "reaching-game":
        return paper_agent()
    named = ("control_weight", "state_weight", "rationality")
    values: dict[str, Any] = {name: float(said[name]) for name in named if name in said}
    return replace(paper_agent(), **values)


def assumed_reaction(log: xr.Dataset, robot: str) -> AssumedReaction:
    """Return how a robot took the human to react: a function of a game's configuration and the robot's name.

    In a log that is of no simulated game, every robot is taken to expect a `SoftmaxConditional`.

    Parameters
    ----------
    log : xarray.Dataset
        A study log.
    robot : str
        What the log's ``controller`` calls it.

    Examples
    --------
    >>> import json
    >>> from ppinfer.testing import example_interaction_log
    >>> log = example_interaction_log()
    >>> assumed_reaction(log, "naive").said
    'softmax'
    >>> log.attrs["configuration"] = json.dumps({"world": "reaching-game", "reaction": "reacted"})
    >>> [assumed_reaction(log, robot).said for robot in ("naive", "influence", "courtesy")]
    ['none', 'reacted', 'softmax']
    """
    said = _configuration(log)
    if said.get("world") != "reaching-game":
        return AssumedReaction(_SOFTMAX)
    reaction = _REACTED if said.get("reaction") == ReactedConditional.name else _SOFTMAX
    known = {
        "naive": AssumedReaction(None),
        "reactive": AssumedReaction(None),
        "influence": AssumedReaction(reaction),
        "expected-cost": AssumedReaction(reaction),
        "courtesy": AssumedReaction(_SOFTMAX),
        "joint": AssumedReaction(_REACTED),
        "switching": AssumedReaction(_SOFTMAX, unsure=reaction, rationalities=SWITCHING_RATIONALITIES),
    }
    return known.get(robot, AssumedReaction(reaction, told=False))


def assumed_reactions(log: xr.Dataset, partner: str) -> tuple[tuple[str, AssumedReaction], ...]:
    """Return the name of the partner in every trial, empty where the log has none, and how it took the human to react.

    Examples
    --------
    >>> from ppinfer.testing import example_interaction_log
    >>> [name for name, _ in assumed_reactions(example_interaction_log(), "robot")]
    ['', '']
    """
    names = [""] * log.sizes["trial"]
    if "controller" in log:
        agents = log["agent"].values.astype(str).tolist()
        names = log["controller"].values[:, agents.index(partner)].astype(str).tolist()
    found = {name: assumed_reaction(log, name) for name in dict.fromkeys(names)}
    return tuple((name, found[name]) for name in names)


def told_reactions(robots: tuple[tuple[str, AssumedReaction], ...]) -> dict[str, Any]:
    """Return what a configuration says of reactions: the one that all expect, or that of each robot.

    Examples
    --------
    >>> told_reactions((("naive", AssumedReaction(None)),))["by_robot"]
    {'naive': 'none'}
    >>> told_reactions((("", AssumedReaction(SoftmaxConditional())),))["name"]
    'softmax'
    """
    first = robots[0][1] if robots else AssumedReaction(None)
    alike = all(reaction == AssumedReaction(first.conditional) for _, reaction in robots)
    if alike and first.conditional is not None:
        return {"name": first.conditional.name, "parameters": asdict(first.conditional)}
    return {"parameters": asdict(_SOFTMAX), "by_robot": {name: reaction.said for name, reaction in robots}}


def robots_of_ones_own(log: xr.Dataset, partner: str) -> tuple[str, ...]:
    """Return the robots of which the log does not say how they took the human to react.

    Examples
    --------
    >>> from ppinfer.testing import example_interaction_log
    >>> robots_of_ones_own(example_interaction_log(), "robot")
    ()
    """
    return tuple(dict.fromkeys(name for name, assumed in assumed_reactions(log, partner) if not assumed.told))


def _configuration(log: xr.Dataset) -> dict[str, Any]:
    try:
        said = json.loads(str(log.attrs.get("configuration", "{}")))
    except ValueError:
        return {}
    return said if isinstance(said, dict) else {}
