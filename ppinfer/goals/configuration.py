"""Models by name and parameters: from the command line, and from and to MODEL.toml."""

from __future__ import annotations

import dataclasses
import os
import secrets
import tomllib
from collections.abc import Mapping
from pathlib import Path
from typing import Any, cast

from ppinfer.errors import ModelError
from ppinfer.goals.model import GoalModel
from ppinfer.goals.naming import choices
from ppinfer.guarding import read_toml

MODEL_FORMAT_VERSION = 1
_KINDS = {"str": "text", "int": "a whole number", "float": "a number"}


def named_models() -> dict[str, type[GoalModel]]:
    """Return the models that commands know, by name."""
    from ppinfer.goals import MODELS

    return MODELS


def parameter_names(kind: type[GoalModel]) -> list[str]:
    """Return the parameters of a model that can be written down: numbers and names.

    Examples
    --------
    >>> from ppinfer.goals import NearestGoal
    >>> parameter_names(NearestGoal)
    ['scale']
    """
    return list(kind.parameter_types({}))


def parameters_of(model: GoalModel) -> dict[str, str | int | float]:
    """Return a model's parameters as plain values.

    Examples
    --------
    >>> from ppinfer.goals import NearestGoal
    >>> parameters_of(NearestGoal(scale=2.0))
    {'scale': 2.0}
    """
    return model.parameters


def other_parameters_of(model: GoalModel) -> dict[str, str]:
    """Return, as text, the parameters that cannot be written down as numbers or names: matrices of one's own.

    Examples
    --------
    >>> from ppinfer.goals import NearestGoal
    >>> other_parameters_of(NearestGoal())
    {}
    """
    plain = model.parameters
    # a model of one's own need not be a dataclass
    fields = dataclasses.fields(cast(Any, model)) if hasattr(model, "__dataclass_fields__") else ()
    values = {field.name: getattr(model, field.name) for field in fields if field.name not in plain}
    return {name: repr(value) for name, value in values.items() if value is not None}


def make_model(name: str, parameters: Mapping[str, Any]) -> GoalModel:
    """Return the model called `name` with these parameters, given as numbers or as text.

    Raises
    ------
    ModelError
        Where the model or a parameter is unknown (the nearest name is suggested), or a value has the wrong type or
        is out of range.

    Examples
    --------
    >>> make_model("nearest", {"scale": "2.5"})
    NearestGoal(scale=2.5)
    """
    models = named_models()
    if name not in models:
        raise ModelError(f"unknown model {name!r}: expected {choices(name, list(models))}, or a MODEL.toml")
    kind = models[name]
    known = kind.parameter_types(parameters)
    values: dict[str, Any] = {}
    for key, value in parameters.items():
        if key not in known:
            raise ModelError(f"model {name!r} has no parameter {key!r}: expected {choices(key, list(known))}")
        values[key] = _converted(name, key, value, known[key])
    return kind.from_parameters(values)


def read_model(path: str | os.PathLike[str]) -> GoalModel:
    """Read a model from the MODEL.toml that ``ppinfer fit`` writes.

    Raises
    ------
    ModelError
        Where the file is not TOML, holds no model, or its parameters do not fit; the message names the file.
    """
    where = Path(path)
    try:
        document = read_toml(where, ModelError)
    except UnicodeDecodeError as error:
        raise ModelError(f"{where}: not a text file: {error.reason} at byte {error.start}") from error
    except tomllib.TOMLDecodeError as error:
        raise ModelError(f"{where}: not valid TOML: {error}") from error
    name, parameters = document.get("model"), document.get("parameters", {})
    if not isinstance(name, str) or not isinstance(parameters, dict):
        raise ModelError(
            f"{where}: expected model = \"NAME\" and a table [parameters], as 'ppinfer fit' writes them"
        )
    if document.get("format_version", MODEL_FORMAT_VERSION) != MODEL_FORMAT_VERSION:
        raise ModelError(
            f"{where}: format_version {document['format_version']!r}; this ppinfer reads {MODEL_FORMAT_VERSION}"
        )
    try:
        return make_model(name, parameters)
    except ModelError as error:
        raise ModelError(f"{where}: {error}") from error


def write_model(model: GoalModel, path: str | os.PathLike[str], notes: Mapping[str, Any]) -> None:
    """Write a model and the tables of `notes` (how it was fitted) as TOML, whole or not at all."""
    import tomli_w

    document = {
        "model": model.name,
        "format_version": MODEL_FORMAT_VERSION,
        "parameters": parameters_of(model),
        **notes,
    }
    where = check_target(path)
    draft = where.with_name(f".{where.name}.{secrets.token_hex(6)}.part")
    try:
        draft.write_text(tomli_w.dumps(document), encoding="utf-8")
        draft.replace(where)
    finally:
        draft.unlink(missing_ok=True)


def check_target(path: str | os.PathLike[str]) -> Path:
    """Return where a model is to be written, or refuse it before any work is done.

    Raises
    ------
    ModelError
        Where the folder is missing, or the name is that of a folder.
    """
    where = Path(path)
    if not where.parent.is_dir():
        raise ModelError(f"{where}: there is no folder {str(where.parent)!r}")
    if where.is_dir():
        raise ModelError(f"{where}: is a folder; a model is one file")
    return where


def _converted(model: str, key: str, value: Any, wanted: type) -> str | int | float:
    from pydantic import TypeAdapter, ValidationError

    try:
        converted: str | int | float = TypeAdapter(wanted).validate_python(value)
    except ValidationError as error:
        raise ModelError(
            f"model {model!r}: {key} must be {_KINDS[wanted.__name__]}; got {value!r}"
        ) from error
    return converted
