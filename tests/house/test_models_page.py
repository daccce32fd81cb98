"""The page on goal models lists every model that commands know, with its parameters and their defaults."""

from __future__ import annotations

import pytest

from ppinfer.goals import MODELS
from ppinfer.goals.configuration import parameters_of

from .pages import ROOT

PAGE = (ROOT / "docs" / "models.md").read_text(encoding="utf-8")


def sections():
    """Return the text under each heading, by the words of the heading."""
    return {part.partition("\n")[0]: part for part in PAGE.split("\n## ")[1:]}


@pytest.mark.parametrize("name", MODELS)
def test_every_parameter_of_a_model_is_on_the_page_with_its_default(name):
    (section,) = (text for heading, text in sections().items() if name in heading.split())
    for parameter, default in parameters_of(MODELS[name]()).items():
        assert f"| `{parameter}` | {default} |" in section, f"docs/models.md: {name} {parameter} = {default}"


@pytest.mark.parametrize("name", MODELS)
def test_every_model_is_in_the_overview(name):
    assert f"| `{name}` |" in PAGE.partition("\n## ")[0]
