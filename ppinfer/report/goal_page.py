"""The page about a posterior over goals."""

from __future__ import annotations

import numpy as np

from ppinfer.report.goal_parts import calibration_parts, headline_parts, posterior_parts, scored_posterior
from ppinfer.report.options import OF_LOGS_ONLY, ReportOptions
from ppinfer.report.parts import Contents, sentence
from ppinfer.report.score_metrics import score_metrics
from ppinfer.report.sections.condition_tests import compare_conditions, tests_parts
from ppinfer.report.sections.data_sheet import data_part, posterior_sheet
from ppinfer.report.sections.faults import faults_part
from ppinfer.report.sections.metrics import Measured, among, metrics_parts
from ppinfer.report.sections.provenance import infer_command, made_part, posterior_provenance
from ppinfer.report.source import Source
from ppinfer.report.written import PageWriter, WrittenReport
from ppinfer.studies.posterior import open_posterior


def write_goal_page(source: Source, options: ReportOptions, writer: PageWriter) -> WrittenReport:
    """Write the page about a posterior over goals; see `ppinfer.report.write_report`."""
    options.refuse(source.given, ("model", "parameters", "robot", "human"), OF_LOGS_ONLY)
    with open_posterior(source.path) as posterior:
        scored = scored_posterior(posterior, options)
        scores = score_metrics(scored)
        measured = (
            None if scores is None else Measured.of(among(scores, ~np.isnan(scores.values).all(axis=1)))
        )
        tested = None if measured is None else compare_conditions(measured)
        attrs = posterior.attrs
        span = "of the whole trial" if attrs.get("mode") == "smooth" else "so far"
        contents = Contents(
            title=f"Where is the {attrs.get('agent', 'agent')} going?",
            lead=(
                f"The posterior over goals in {source.given.name}, inferred by the model "
                f"“{attrs.get('model', 'unknown')}” from {attrs.get('input', 'a study log')}: at every instant, how "
                f"probable each goal is, given the motion {span}."
            ),
            headline=headline_parts(scored),
            warnings=scored.warnings,
            sections={
                "data": [data_part(posterior_sheet(posterior))],
                "faults": [faults_part(source.checked, what="the posterior")],
                "posteriors": posterior_parts(scored, options),
                "calibration": calibration_parts(scored),
                "metrics": metrics_parts(measured, drawn=measured.metrics.names)
                if measured
                else [sentence("Without true goals there is nothing to measure.")],
                "tests": tests_parts(tested)
                if tested
                else [sentence("Nothing is tested, since nothing is scored.")],
                "made": [
                    made_part(
                        source,
                        options,
                        posterior_provenance(posterior),
                        posterior_command=infer_command(posterior, source.given),
                    )
                ],
            },
        )
        return writer.write(
            contents,
            trials=scored.shown,
            scores=scored.scores,
            calibration=scored.calibration,
            metrics=measured,
            tests=tested,
        )
