"""Weights on disk: safetensors, with the configuration and a digest; nothing is ever unpickled."""

from __future__ import annotations

import hashlib
import json
import os
import secrets
from pathlib import Path
from typing import Any

import numpy as np

from ppinfer.errors import ModelError
from ppinfer.goals.configuration import check_target
from ppinfer.goals.learned.configuration import NetworkConfiguration
from ppinfer.goals.learned.extra import require_torch
from ppinfer.goals.learned.network import build_network, load_weights, weights_of
from ppinfer.goals.learned.predictor import GoalPredictor
from ppinfer.guarding import refuse_special

FORMAT, VERSION = "ppinfer goal predictor", 1
# one entry only: safetensors writes several in any order, and the same weights are to be the same file
_ENTRY = "ppinfer"
_LARGEST_HEADER = 1 << 20


def write_predictor(predictor: GoalPredictor, path: str | os.PathLike[str]) -> None:
    """Write weights and configuration as a safetensors file, whole or not at all.

    The same predictor gives the same bytes.

    Raises
    ------
    ModelError
        Where the name does not end in ``.safetensors``, or there is no such folder.
    """
    require_torch()
    from safetensors.numpy import save

    where = check_weights_target(path)
    weights = weights_of(predictor.network)
    told = {
        "format": FORMAT,
        "version": VERSION,
        "configuration": json.loads(predictor.configuration.to_json()),
        "sha256": _digest(weights, predictor.configuration),
    }
    draft = where.with_name(f".{where.name}.{secrets.token_hex(6)}.part")
    try:
        draft.write_bytes(save(weights, metadata={_ENTRY: json.dumps(told, sort_keys=True)}))
        draft.replace(where)
    finally:
        draft.unlink(missing_ok=True)


def check_weights_target(path: str | os.PathLike[str]) -> Path:
    """Return where weights are to be written, or refuse it before any work is done.

    Examples
    --------
    >>> check_weights_target("model.pickle")
    Traceback (most recent call last):
    ppinfer.errors.ModelError: model.pickle: weights are written as .safetensors; give it a name that ends so
    """
    where = Path(path)
    if where.suffix != ".safetensors":
        raise ModelError(f"{where}: weights are written as .safetensors; give it a name that ends so")
    return check_target(where)


def read_predictor(path: str | os.PathLike[str]) -> GoalPredictor:
    """Read a predictor, checked: the format, the configuration, every weight's shape and type, and the digest.

    Raises
    ------
    ModelError
        In one line, where the extra is missing, or the file is none of ours or was changed.
    """
    require_torch()
    from safetensors import SafetensorError, safe_open

    where = Path(path)
    refuse_special(where, ModelError)
    if not where.is_file():
        raise ModelError(f"{where}: there is no such file")
    _refuse_large_header(where)
    try:
        with safe_open(where, framework="np") as file:
            told = _told(where, file.metadata())
            configuration = NetworkConfiguration.from_json(json.dumps(told["configuration"]))
            if (least := 4 * configuration.hidden**2) > where.stat().st_size:
                # before the network is built: it would take as much memory as it claims
                raise ModelError(
                    f"describes a network of more than {least} bytes, but is smaller: it is damaged; write it anew"
                )
            network = build_network(configuration)
            wanted = weights_of(network)
            if set(file.keys()) != set(wanted):
                raise ModelError("its tensors are not those of the network that it describes")
            weights = {name: file.get_tensor(name) for name in wanted}
    except SafetensorError as error:
        raise ModelError(f"{where}: is no safetensors file, or a damaged one: {error}") from error
    except ModelError as error:
        raise ModelError(f"{where}: {error}") from error
    for name, array in weights.items():
        if array.shape != wanted[name].shape or array.dtype != wanted[name].dtype:
            raise ModelError(
                f"{where}: {name} is {array.dtype} of shape {array.shape}; expected {wanted[name].dtype} of shape "
                f"{wanted[name].shape}"
            )
        if not np.isfinite(array).all():
            raise ModelError(f"{where}: {name} holds values that are not finite")
    if told.get("sha256") != _digest(weights, configuration):
        raise ModelError(f"{where}: was changed since it was written (its digest differs); write it anew")
    load_weights(network, weights)
    return GoalPredictor(configuration, network)


def _refuse_large_header(where: Path) -> None:
    """Refuse a header that is larger than ours can be: what is read of it has no other limit."""
    with where.open("rb") as file:
        length = int.from_bytes(file.read(8), "little")
    if _LARGEST_HEADER < length <= where.stat().st_size:
        raise ModelError(f"{where}: has a header of {length} bytes; one that 'ppinfer learn' writes is small")


def _told(where: Path, metadata: dict[str, str] | None) -> dict[str, Any]:
    try:
        told: Any = json.loads((metadata or {}).get(_ENTRY, "null"))
    except (ValueError, RecursionError):
        told = None
    if not isinstance(told, dict) or told.get("format") != FORMAT:
        raise ModelError("is a safetensors file, but not one that 'ppinfer learn' wrote")
    if told.get("version") != VERSION:
        raise ModelError(f"has version {told.get('version')!r}; this ppinfer reads {VERSION}")
    if "configuration" not in told:
        raise ModelError("says nothing of its configuration")
    return told


def _digest(weights: dict[str, np.ndarray], configuration: NetworkConfiguration) -> str:
    digest = hashlib.sha256(configuration.to_json().encode())
    for name in sorted(weights):
        digest.update(name.encode())
        digest.update(np.ascontiguousarray(weights[name]).tobytes())
    return digest.hexdigest()
