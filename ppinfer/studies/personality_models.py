"""Models of personality by name and parameters: from the command line, and from what a log says of its robots."""

from __future__ import annotations

import dataclasses
import json
from collections.abc import Mapping
from typing import Any, get_type_hints

from ppinfer.coordination import (
    LiteralPersonality,
    Personality,
    PersonalityModel,
    PredictivePersonality,
)
from ppinfer.errors import LogError, ModelError

PERSONALITIES: dict[str, type[PersonalityModel]] = {
    model.name: model for model in (Personality, LiteralPersonality, PredictivePersonality)
}
"""Models by the names that logs have for them."""

AS_LOGGED = "as-logged"
"""How posteriors say that each trial was inferred with the model of its own log."""


def make_personality(name: str, parameters: Mapping[str, Any]) -> PersonalityModel:
    """Return the model called `name` with these parameters, given as values or as text.

    Raises
    ------
    ModelError
        Where the model or a parameter is unknown, or a value has the wrong type or is out of range.

    Examples
    --------
    >>> make_personality("personality", {"stay": "0.9"}).stay
    0.9
    """
    from pydantic import TypeAdapter, ValidationError

    if name not in PERSONALITIES:
        raise ModelError(f"unknown model {name!r} of personality: expected one of {', '.join(PERSONALITIES)}")
    kind = PERSONALITIES[name]
    hints = get_type_hints(kind)
    known = [item.name for item in dataclasses.fields(kind)]  # type: ignore[arg-type]
    values = {}
    for key, value in parameters.items():
        if key not in known:
            raise ModelError(f"model {name!r} has no parameter {key!r}: expected one of {', '.join(known)}")
        try:
            values[key] = TypeAdapter(hints[key]).validate_python(None if value == "none" else value)
        except ValidationError as error:
            reason = error.errors()[0]["msg"]
            raise ModelError(f"model {name!r}: {key} cannot be {value!r}: {reason}") from error
    return kind(**values)


def personality_text(model: PersonalityModel) -> str:
    """Return a model as the JSON text that logs and posteriors hold.

    Raises
    ------
    ModelError
        Where JSON cannot hold a parameter.

    Examples
    --------
    >>> personality_text(LiteralPersonality())
    '{"model": "personality-literal", "parameters": {"rationality": 10.0, "dominance": "weak"}}'
    """
    # a model of one's own need not be a dataclass
    parameters: dict[str, Any] = dataclasses.asdict(model) if dataclasses.is_dataclass(model) else {}
    try:
        return json.dumps({"model": model.name, "parameters": parameters}, allow_nan=False)
    except (TypeError, ValueError) as error:
        raise ModelError(
            f"parameters of {model.name!r} cannot be written as JSON, so no log can keep the model: {error}; make them "
            "finite numbers, strings, lists or None"
        ) from error


def personality_of_text(text: str) -> PersonalityModel:
    """Return the model that a log names; empty text stands for the default `Personality`.

    Raises
    ------
    LogError
        Where the text names no model that there is.

    Examples
    --------
    >>> personality_of_text('{"model": "personality", "parameters": {"stay": 0.5}}').stay
    0.5
    """
    if not text:
        return Personality()
    try:
        told = json.loads(text)
        return make_personality(told["model"], told.get("parameters", {}))
    except ModelError as error:
        raise LogError(
            f"live_model: {error}; this ppinfer does not know it: choose one for all trials with --variant"
        ) from error
    except (ValueError, KeyError, TypeError, AttributeError) as error:
        raise LogError(f"live_model {text!r} describes no model of personality: {error}") from error
