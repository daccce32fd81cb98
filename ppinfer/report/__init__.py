"""A posterior as one self-contained page to read."""

from ppinfer.report.page import WrittenReport, write_report

__all__ = ["WrittenReport", "write_report"]
