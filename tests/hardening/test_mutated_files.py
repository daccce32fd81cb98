"""Whatever is done to a file, it is read faithfully or refused clearly.

``PPINFER_FUZZ=10000`` in the environment tries so many inputs in all, ``PPINFER_FUZZ_SEED`` others.
"""

import os

import pytest

from ppinfer.testing import check_reader

from .valid_files import GROUPS, case

WANTED = int(os.environ.get("PPINFER_FUZZ", "0"))
SEED = int(os.environ.get("PPINFER_FUZZ_SEED", "0"))
NAMES = [name for group, (_, names) in GROUPS.items() for name in names if WANTED or group != "shipped"]
INPUTS = -(-WANTED // len(NAMES)) if WANTED else 14


@pytest.mark.parametrize("name", NAMES)
def test_a_mutated_file_is_read_faithfully_or_refused(name):
    given = case(name)
    if given is None:
        pytest.skip("needs PPINFER_DATA, or the extra 'learned'")
    tally = check_reader(
        given.read, given.files, target=given.target, inputs=INPUTS, seed=SEED, **given.options
    )
    assert tally.inputs == INPUTS
    # some are, or the mutations are not what they should be
    assert tally.refused
    print(f"{name}: {tally}")  # shown by pytest -rP
