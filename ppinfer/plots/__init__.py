"""One function a picture, each returning Matplotlib axes; no picture is kept in any global state."""

from ppinfer.plots.belief_by_human import plot_belief_by_human
from ppinfer.plots.candidate_paths import plot_candidates
from ppinfer.plots.conditional_belief import plot_conditional_belief
from ppinfer.plots.explore import Explorer, explore
from ppinfer.plots.explore_goals import explore_goals
from ppinfer.plots.game_performance import plot_game_performance
from ppinfer.plots.hand_distance import plot_hand_distance
from ppinfer.plots.learning_curve import plot_learning_curve
from ppinfer.plots.learning_effects import plot_learning_effects
from ppinfer.plots.likert import plot_likert
from ppinfer.plots.log_paths import plot_log_paths
from ppinfer.plots.metric_by_condition import plot_metric_by_condition
from ppinfer.plots.over_time import plot_posterior_over_time
from ppinfer.plots.paired_differences import plot_paired_differences
from ppinfer.plots.participants import plot_participants
from ppinfer.plots.path import plot_path
from ppinfer.plots.personality import plot_personality
from ppinfer.plots.reliability import plot_reliability
from ppinfer.plots.replan_beliefs import mean_beliefs, read_beliefs
from ppinfer.plots.risk_map import plot_risk_map
from ppinfer.plots.score_curves import plot_score_over_share
from ppinfer.plots.task_performance import plot_against_personalities, plot_task_performance
from ppinfer.plots.trial_paths import plot_trial_paths

__all__ = [
    "Explorer",
    "explore",
    "explore_goals",
    "mean_beliefs",
    "plot_against_personalities",
    "plot_belief_by_human",
    "plot_candidates",
    "plot_conditional_belief",
    "plot_game_performance",
    "plot_hand_distance",
    "plot_learning_curve",
    "plot_learning_effects",
    "plot_likert",
    "plot_log_paths",
    "plot_metric_by_condition",
    "plot_paired_differences",
    "plot_participants",
    "plot_path",
    "plot_personality",
    "plot_posterior_over_time",
    "plot_reliability",
    "plot_risk_map",
    "plot_score_over_share",
    "plot_task_performance",
    "plot_trial_paths",
    "read_beliefs",
]
