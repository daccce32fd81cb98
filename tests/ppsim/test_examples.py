"""The examples of the simulation's page and docstrings run."""

import doctest
import importlib
import pkgutil
import re
from pathlib import Path

import numpy as np
import pytest

import ppsim

PAGE = Path(__file__).parents[2] / "docs" / "simulation.md"
MODULES = [module.name for module in pkgutil.walk_packages(ppsim.__path__, "ppsim.")]


def test_the_page_about_the_simulation_runs(capsys):
    (example,) = re.findall(r"```python\n(.*?)```", PAGE.read_text(encoding="utf-8"), re.DOTALL)
    exec(compile(example, str(PAGE), "exec"), {})
    assert int(capsys.readouterr().out) > 0


@pytest.mark.parametrize("name", MODULES)
def test_the_examples_of_a_module_run(name):
    module = importlib.import_module(name)
    result = doctest.testmod(module, extraglobs={"np": np, "Path": Path})
    assert result.failed == 0
