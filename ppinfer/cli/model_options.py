"""``--model`` and ``--set``: which model, with which parameters."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from typing import TYPE_CHECKING

from ppinfer.errors import ModelError

if TYPE_CHECKING:
    from ppinfer.goals import GoalModel


def add_model_arguments(parser: argparse.ArgumentParser) -> None:
    """Add ``--model MODEL`` and ``--set name=value ...``."""
    parser.add_argument(
        "--model",
        default="goal-lqr",
        metavar="MODEL",
        help="a model's name or a MODEL.toml (default: goal-lqr)",
    )
    parser.add_argument(
        "--set",
        nargs="+",
        action="extend",
        default=[],
        metavar="NAME=VALUE",
        dest="settings",
        help="parameters of the model, e.g. rationality=0.01 stay=0.98, or experts=motion,distance stay=0.8",
    )


def add_partner_argument(parser: argparse.ArgumentParser) -> None:
    """Add ``--partner NAME``."""
    parser.add_argument(
        "--partner",
        metavar="NAME",
        help="the other agent that goal-coupled looks at (default: all other agents of the log)",
    )


def check_partner(model: GoalModel, partner: str | None) -> None:
    """Refuse a partner for a model that would not look at it.

    Raises
    ------
    ModelError
        Where one is named for nothing.

    Examples
    --------
    >>> from ppinfer.goals import GoalCoupled
    >>> check_partner(GoalCoupled(), "robot")
    """
    if partner is not None and not model.needs_partner:
        raise ModelError(
            f"--partner {partner}: model {model.name!r} as it is looks at no other agent; leave --partner out, or take "
            "a model that does (--model goal-coupled)"
        )


def parse_settings(settings: Sequence[str]) -> dict[str, str]:
    """Return the parameters given as ``name=value``.

    Raises
    ------
    ModelError
        Where an item has no name or no value, or a name occurs twice.

    Examples
    --------
    >>> parse_settings(["stay=0.98"])
    {'stay': '0.98'}
    """
    parameters: dict[str, str] = {}
    for item in settings:
        name, equals, value = item.partition("=")
        if not (name and equals and value):
            raise ModelError(f"--set takes NAME=VALUE; got {item!r}")
        if name in parameters:
            raise ModelError(f"--set gives {name!r} twice")
        parameters[name] = value
    return parameters


def model_from_options(model: str, settings: Sequence[str]) -> GoalModel:
    """Return a model by its name, or a MODEL.toml (its name has a dot or a slash), with ``--set`` on top."""
    from ppinfer.goals.configuration import make_model, parameters_of, read_model

    parameters = parse_settings(settings)
    if "/" in model or "." in model:
        fitted = read_model(model)
        return make_model(fitted.name, {**parameters_of(fitted), **parameters}) if parameters else fitted
    return make_model(model, parameters)
