import pytest
from hypothesis import given
from hypothesis import strategies as st

from ppinfer.errors import LogError
from ppinfer.studies.statistics import as_printed


@pytest.mark.parametrize(
    ("value", "text", "told"),
    [
        (4.0952381, "4.0", "truncated"),
        (2.1904762, "2.2", "rounded"),
        (3.6190476, "3.6", "both"),
        (0.0257, ".02", "truncated"),
        (0.0257, "0.03", "rounded"),
        (0.0257, "0.04", "neither"),
        (-1.27, "-1.2", "truncated"),
        (2.9999999999999996, "3.0", "both"),
        (0.25, "0.2", "both"),
        (0.25, "0.3", "rounded"),
        (12.0, "12", "both"),
        (0.0079, "< 0.01", "both"),
        (0.0236, "<.01", "neither"),
    ],
)
def test_a_printed_number_is_rounded_or_cut_off(value, text, told):
    assert as_printed(value, text) == told


@given(st.floats(-1e6, 1e6), st.integers(0, 6))
def test_what_python_rounds_is_rounded(value, digits):
    assert as_printed(value, f"{value:.{digits}f}") in ("both", "rounded")


@pytest.mark.parametrize(("value", "text"), [(1.0, "one"), (1.0, ""), (1.0, "nan"), (float("nan"), "1")])
def test_what_is_no_number_is_refused(value, text):
    with pytest.raises(LogError, match="expected finite decimal numbers"):
        as_printed(value, text)
