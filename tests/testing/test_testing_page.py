"""What docs/testing.md lists is there."""

import re
from pathlib import Path

import ppinfer.testing

PAGE = Path(__file__).parents[2] / "docs" / "testing.md"


def test_every_function_and_strategy_that_the_page_lists_is_public_and_can_be_called():
    text = PAGE.read_text(encoding="utf-8")
    cells = re.findall(r"^\| (`[^|]*`) \|", text, flags=re.MULTILINE)
    names = {name for cell in cells for name in re.findall(r"`(\w+)`", cell)}
    assert {"check_normalisation", "logs", "transitions"} <= names
    assert names <= set(ppinfer.testing.__all__)
    for name in names:
        assert callable(getattr(ppinfer.testing, name)), name


def test_every_public_name_of_the_package_is_on_the_page():
    text = PAGE.read_text(encoding="utf-8")
    assert not [name for name in ppinfer.testing.__all__ if not re.search(rf"\b{name}\b", text)]
