"""The page about a log that can be read and is not sound: its data sheet and its faults, and no conclusions."""

from __future__ import annotations

from ppinfer.report.facts import Facts
from ppinfer.report.options import ReportOptions
from ppinfer.report.parts import SECTIONS, Contents, sentence
from ppinfer.report.sections.data_sheet import data_part, log_sheet
from ppinfer.report.sections.faults import faults_part, unsound_warning
from ppinfer.report.sections.provenance import log_provenance, made_part
from ppinfer.report.source import Source
from ppinfer.report.written import PageWriter, WrittenReport
from ppinfer.studies.storage import open_log


def write_unsound_page(source: Source, options: ReportOptions, writer: PageWriter) -> WrittenReport:
    """Write the page about an unsound log; see `ppinfer.report.write_report`."""
    with open_log(source.path) as log:
        facts: Facts = [(name, f"{size:,}") for name, size in source.checked.sizes.items()]
        if source.is_whole:
            facts = log_sheet(log)
        nothing = [sentence("Nothing is concluded from an unsound log.")]
        contents = Contents(
            title=str(log.attrs.get("title") or "A study log that is not sound"),
            lead=f"The log {source.given.name} has faults: they are listed here, and nothing is concluded from it.",
            warnings=[unsound_warning(source.checked)],
            sections={
                **dict.fromkeys(SECTIONS, nothing),
                "data": [data_part(facts)],
                "faults": [
                    faults_part(source.checked, what="the log", notes=str(log.attrs.get("notes", "")))
                ],
                "made": [made_part(source, options, log_provenance(log) if source.is_whole else [])],
            },
        )
    return writer.write(contents)
