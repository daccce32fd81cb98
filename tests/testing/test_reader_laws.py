"""A reader that breaks the law is told how, with the input that shows it; one that keeps it is counted."""

import os

import numpy as np
import pytest

from ppinfer.errors import LogError
from ppinfer.testing import check_reader, mutate

VALID = {"walk.txt": b"0 1 2\n1 1 3\n2 1 4\n"}


def strict(path):
    """Read nothing but the original."""
    if path.read_bytes() != VALID["walk.txt"]:
        raise LogError(f"{path}: is another walk")
    return "walk"


def broken_by(act):
    """Return a reader that does something else where the file is not the original."""

    def read(path):
        if path.read_bytes() != VALID["walk.txt"]:
            return act(path)
        return "walk"

    return read


def test_a_reader_that_refuses_whatever_is_damaged_keeps_the_law():
    tally = check_reader(strict, VALID, inputs=20, signed=True)
    assert tally.inputs == 20
    assert tally.refused + tally.faithful == 20


@pytest.mark.parametrize(
    ("act", "told"),
    [
        (lambda path: {}["x"], "KeyError instead of a PPInferError"),
        (lambda path: print("hm") or strict(path), "it printed: hm"),
        (
            lambda path: path.with_suffix(".cache").write_text("x") and strict(path),
            "reading wrote walk.cache",
        ),
        (lambda path: "another walk", "read as something else, without a word"),
        (lambda path: os.abort(), "the process ended: SIGABRT"),
    ],
    ids=["raises", "prints", "writes", "believes", "crashes"],
)
def test_a_reader_that_breaks_the_law_is_told_how_and_on_which_input(act, told):
    with pytest.raises(AssertionError, match="of seed 3") as caught:
        check_reader(broken_by(act), VALID, inputs=6, seed=3, signed=True, seconds=5)
    assert told in str(caught.value)


def refuse(text):
    raise LogError(text)


@pytest.mark.parametrize("text", ["is damaged", "walk.txt: is\ndamaged" * 2000])
def test_a_refusal_names_the_file_in_a_line_of_bounded_length(text):
    # errors of ppinfer are one line of bounded length by themselves
    with_name = "walk" in text
    read = broken_by(lambda path: refuse(text))
    if with_name:
        assert check_reader(read, VALID, inputs=2).inputs == 2
        return
    with pytest.raises(AssertionError, match="without naming a file"):
        check_reader(read, VALID, inputs=2)


def test_the_same_seed_makes_the_same_mutation():
    one, other = (mutate(VALID, np.random.default_rng([3, 7])) for _ in range(2))
    assert one == other
    assert len({mutate(VALID, np.random.default_rng([3, index])).name for index in range(50)}) > 30
