"""Study logs: reading, checking, writing, recording; and what is computed offline over whole studies."""

from ppinfer.studies.assembling import build_log
from ppinfer.studies.blocks import iter_blocks
from ppinfer.studies.calibration import Calibration, calibrate_posterior
from ppinfer.studies.checksums import content_digest, file_sha256
from ppinfer.studies.comparison import compare_posteriors
from ppinfer.studies.conditional_beliefs import infer_log_conditional
from ppinfer.studies.encounters import encounter_evidence
from ppinfer.studies.faults import Fault, Faults, FaultyLogError, Report
from ppinfer.studies.file_checks import validate_file
from ppinfer.studies.fit import StudyFit, fit_study
from ppinfer.studies.goal_evidence import goal_evidence
from ppinfer.studies.infer import infer_posterior
from ppinfer.studies.log_inference import infer_log, posterior_dataset
from ppinfer.studies.personality_inference import (
    infer_log_personality,
    infer_personalities,
    live_difference,
)
from ppinfer.studies.personality_models import personality_text
from ppinfer.studies.play_history import play_history
from ppinfer.studies.posterior import open_posterior, write_posterior
from ppinfer.studies.readers import READERS, read_study
from ppinfer.studies.readers.eth import read_eth
from ppinfer.studies.readers.reaching_study import read_reaching_study
from ppinfer.studies.readers.tidy import read_tidy
from ppinfer.studies.recording import Recording, RecordingWriter, load_recording, read_recording
from ppinfer.studies.recording_lines import RecordingHeader
from ppinfer.studies.replans import Replan, ReplanTable
from ppinfer.studies.scores import Scores, score_posterior
from ppinfer.studies.statistics import Analysis, RepeatedMeasures, analyse, read_measures
from ppinfer.studies.storage import open_log, read_log, write_log
from ppinfer.studies.task_performance import TaskPerformance, task_performance
from ppinfer.studies.theta_posterior import read_theta_posterior, write_theta_posterior
from ppinfer.studies.trial_selection import select_trials
from ppinfer.studies.trials import Segment, Trial, log_of_trials
from ppinfer.studies.validation import validate_log

__all__ = [
    "READERS",
    "Analysis",
    "Calibration",
    "Fault",
    "Faults",
    "FaultyLogError",
    "Recording",
    "RecordingHeader",
    "RecordingWriter",
    "RepeatedMeasures",
    "Replan",
    "ReplanTable",
    "Report",
    "Scores",
    "Segment",
    "StudyFit",
    "TaskPerformance",
    "Trial",
    "analyse",
    "build_log",
    "calibrate_posterior",
    "compare_posteriors",
    "content_digest",
    "encounter_evidence",
    "file_sha256",
    "fit_study",
    "goal_evidence",
    "infer_log",
    "infer_log_conditional",
    "infer_log_personality",
    "infer_personalities",
    "infer_posterior",
    "iter_blocks",
    "live_difference",
    "load_recording",
    "log_of_trials",
    "open_log",
    "open_posterior",
    "personality_text",
    "play_history",
    "posterior_dataset",
    "read_eth",
    "read_log",
    "read_measures",
    "read_reaching_study",
    "read_recording",
    "read_study",
    "read_theta_posterior",
    "read_tidy",
    "score_posterior",
    "select_trials",
    "task_performance",
    "validate_file",
    "validate_log",
    "write_log",
    "write_posterior",
    "write_theta_posterior",
]
