"""Surveys: instruments, answers without their authors' names, scales, and the orders of conditions."""

from ppinfer.studies.surveys.analysis import SurveyAnalysis, analyse_survey
from ppinfer.studies.surveys.counterbalancing import Counterbalancing, check_orders
from ppinfer.studies.surveys.instrument import Instrument
from ppinfer.studies.surveys.orders import orders_of_log, orders_of_survey, read_orders
from ppinfer.studies.surveys.reading import read_survey
from ppinfer.studies.surveys.reliability import Alpha, cronbach_alpha, feldt_interval
from ppinfer.studies.surveys.score_table import score_table, write_scores
from ppinfer.studies.surveys.survey import Survey

__all__ = [
    "Alpha",
    "Counterbalancing",
    "Instrument",
    "Survey",
    "SurveyAnalysis",
    "analyse_survey",
    "check_orders",
    "cronbach_alpha",
    "feldt_interval",
    "orders_of_log",
    "orders_of_survey",
    "read_orders",
    "read_survey",
    "score_table",
    "write_scores",
]
