"""PyTorch, where it is installed."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

from ppinfer.errors import ModelError

MISSING = "learned prediction needs PyTorch and safetensors: pip install 'ppinfer[learned]'"


def require_torch() -> Any:
    """Return the package ``torch``.

    Raises
    ------
    ModelError
        In one line, where the extra is not installed.
    """
    try:
        import safetensors.numpy  # noqa: F401
        import torch
    except ImportError as error:
        raise ModelError(MISSING) from error
    return torch


@contextmanager
def threads(count: int) -> Iterator[None]:
    """Let PyTorch use so many threads for a while: sums depend on it in their last digits."""
    torch = require_torch()
    before = torch.get_num_threads()
    if count == before:
        yield
        return
    torch.set_num_threads(count)
    try:
        yield
    finally:
        torch.set_num_threads(before)
