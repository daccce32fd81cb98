"""docs/metrics.md defines what is registered, and nothing else."""

from pathlib import Path

from ppinfer.studies.metrics import metrics_table

PAGE = Path(__file__).parents[3] / "docs" / "metrics.md"


def test_the_table_of_the_page_is_that_of_the_registry():
    assert metrics_table() in PAGE.read_text(encoding="utf-8")
