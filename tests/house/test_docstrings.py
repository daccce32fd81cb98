"""Every example in a docstring is executed, and every public name has one."""

from __future__ import annotations

import dataclasses
import doctest
import importlib
import inspect
import pkgutil

import numpy as np
import pytest

import ppinfer
import ppsim

FLAGS = doctest.ELLIPSIS | doctest.NORMALIZE_WHITESPACE | doctest.IGNORE_EXCEPTION_DETAIL
MODULES = sorted(
    module.name
    for package in (ppinfer, ppsim)
    for module in pkgutil.walk_packages(package.__path__, f"{package.__name__}.")
    if not module.name.endswith("__main__")
)
PUBLIC = (
    "ppinfer",
    *(name for name in MODULES if name.count(".") == 1 and not name.startswith("ppinfer.cli")),
)


class Finder(doctest.DocTestFinder):
    """Finds examples behind decorators too: run-time shape checks and compiled kernels wrap what they decorate."""

    def _from_module(self, module, object):
        home = getattr(object, "__module__", None)
        if isinstance(object, property):
            home = object.fget.__module__
        return home == module.__name__ if home else super()._from_module(module, object)


@pytest.mark.parametrize("name", ["ppinfer", "ppsim", *MODULES])
def test_every_example_of_a_module_does_what_it_shows(name, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    module = importlib.import_module(name)
    names = vars(module) | {"np": np}
    for example in Finder(exclude_empty=True).find(module, globs=names):
        report: list[str] = []
        runner = doctest.DocTestRunner(optionflags=FLAGS)
        runner.run(example, out=report.append)
        assert not runner.failures, "".join(report)


def public_names():
    """Yield (module, name, object) of every class and function that a package offers."""
    for name in PUBLIC:
        module = importlib.import_module(name)
        for public in getattr(module, "__all__", ()):
            found = getattr(module, public)
            if inspect.isfunction(found) or (inspect.isclass(found) and not issubclass(found, Exception)):
                yield name, public, found


def test_every_public_function_has_an_example():
    bare = {
        f"{module}.{name}"
        for module, name, found in public_names()
        if ">>>" not in (inspect.getdoc(found) or "")
        and not dataclasses.is_dataclass(found)
        and not getattr(found, "_is_protocol", False)
    }
    assert not bare, f"give these an example in their docstring: {', '.join(sorted(bare))}"
