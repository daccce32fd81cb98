"""What every test runs under: checked shapes, repeatable examples, no windows."""

import os
from pathlib import Path

os.environ.setdefault("MPLBACKEND", "Agg")
# workers of a parallel run share the cores; threads within the linear algebra would only wait for each other
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import pytest
from hypothesis import HealthCheck, settings
from jaxtyping import install_import_hook

ROOT = Path(__file__).parents[1]

# compiled kernels must not be wrapped; Hypothesis hands its strategies a `draw` that cannot be checked
UNCHECKED = (
    "__init__",
    "scans",
    "strategies",
    "evidence_strategies",
    "game_strategies",
    "log_strategies",
    "play_strategies",
    "situation_strategies",
)


def checked_modules() -> list[str]:
    """Name every module of the library whose annotations are checked, at run time, while tests run.

    Packages are left out because naming one includes all below it.
    """
    files = sorted((ROOT / "ppinfer").rglob("*.py"))
    modules = [file.relative_to(ROOT).with_suffix("") for file in files if file.stem not in UNCHECKED]
    return [".".join(module.parts) for module in modules]


install_import_hook(checked_modules(), "beartype.beartype(conf=beartype.BeartypeConf(is_pep484_tower=True))")

settings.register_profile(
    "ppinfer",
    derandomize=True,
    deadline=None,
    print_blob=False,
    max_examples=60,
    suppress_health_check=[HealthCheck.too_slow, HealthCheck.data_too_large],
)
settings.load_profile("ppinfer")


def pytest_configure(config: pytest.Config) -> None:
    """Allow the run-time checks to pick which item of a list they look at, even inside a strategy."""
    config.addinivalue_line(
        "filterwarnings",
        "ignore:Do not use the `random` module:hypothesis.errors.HypothesisDeprecationWarning",
    )
