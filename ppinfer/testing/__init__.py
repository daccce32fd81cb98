"""Laws and strategies: what the project's own tests use, for the tests of others.

The laws are plain functions that raise `AssertionError`; `check_likelihood` holds a goal model to all of its own. The
strategies need Hypothesis (the extra ``ppinfer[test]``) and are imported when they are first asked for.

Examples
--------
>>> from ppinfer import Axis, Distribution
>>> from ppinfer.testing import check_normalisation
>>> check_normalisation(Distribution.uniform(Axis("goal", ["cup", "bowl"])))
"""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

from ppinfer.testing.coordination import (
    check_norm,
    check_personality,
    check_personality_twin,
    check_policy,
)
from ppinfer.testing.example_logs import example_log
from ppinfer.testing.example_play import example_plans, example_situation, example_trial
from ppinfer.testing.game_laws import (
    check_game_batch_equals_loop,
    check_game_relabelling,
    check_player_order,
    check_pure_equilibria,
)
from ppinfer.testing.goals import check_likelihood
from ppinfer.testing.laws import (
    check_batch_equals_loop,
    check_chain_rule,
    check_ignorance,
    check_normalisation,
    check_order_of_evidence,
    check_relabelling,
    check_scale,
)
from ppinfer.testing.laws_over_time import check_online_equals_offline, check_smoother

if TYPE_CHECKING:
    from ppinfer.testing.choice import check_goal_chooser, check_goal_conditional
    from ppinfer.testing.evidence_strategies import goal_evidences
    from ppinfer.testing.example_interactions import example_interaction_log
    from ppinfer.testing.example_plays import example_planned_log
    from ppinfer.testing.example_teams import example_team_log
    from ppinfer.testing.experts import check_expert
    from ppinfer.testing.game_strategies import costs, games
    from ppinfer.testing.goal_scenes import example_goal_situation
    from ppinfer.testing.log_strategies import logs
    from ppinfer.testing.metrics import check_metric
    from ppinfer.testing.mutations import Mutation, mutate
    from ppinfer.testing.play_strategies import histories, play_trials, situations
    from ppinfer.testing.reader_laws import ReaderTally, check_reader
    from ppinfer.testing.situation_strategies import goal_situations
    from ppinfer.testing.strategies import (
        axes,
        axis_sets,
        distributions,
        factors,
        log_weights,
        relabellings,
        transitions,
    )

# what needs Hypothesis, whole study logs, files or choosers of goals, and the module that it is in
_LATER = dict.fromkeys(
    ("axes", "axis_sets", "distributions", "factors", "log_weights", "relabellings", "transitions"),
    "ppinfer.testing.strategies",
) | {
    "goal_evidences": "ppinfer.testing.evidence_strategies",
    "costs": "ppinfer.testing.game_strategies",
    "example_interaction_log": "ppinfer.testing.example_interactions",
    "example_planned_log": "ppinfer.testing.example_plays",
    "example_team_log": "ppinfer.testing.example_teams",
    "check_metric": "ppinfer.testing.metrics",
    "check_expert": "ppinfer.testing.experts",
    "check_goal_chooser": "ppinfer.testing.choice",
    "check_goal_conditional": "ppinfer.testing.choice",
    "example_goal_situation": "ppinfer.testing.goal_scenes",
    "games": "ppinfer.testing.game_strategies",
    "goal_situations": "ppinfer.testing.situation_strategies",
    "histories": "ppinfer.testing.play_strategies",
    "logs": "ppinfer.testing.log_strategies",
    "Mutation": "ppinfer.testing.mutations",
    "ReaderTally": "ppinfer.testing.reader_laws",
    "check_reader": "ppinfer.testing.reader_laws",
    "mutate": "ppinfer.testing.mutations",
    "play_trials": "ppinfer.testing.play_strategies",
    "situations": "ppinfer.testing.play_strategies",
}


def __getattr__(name: str) -> Any:
    if name in _LATER:
        return getattr(importlib.import_module(_LATER[name]), name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")


__all__ = [
    "Mutation",
    "ReaderTally",
    "axes",
    "axis_sets",
    "check_batch_equals_loop",
    "check_chain_rule",
    "check_expert",
    "check_game_batch_equals_loop",
    "check_game_relabelling",
    "check_goal_chooser",
    "check_goal_conditional",
    "check_ignorance",
    "check_likelihood",
    "check_metric",
    "check_norm",
    "check_normalisation",
    "check_online_equals_offline",
    "check_order_of_evidence",
    "check_personality",
    "check_personality_twin",
    "check_player_order",
    "check_policy",
    "check_pure_equilibria",
    "check_reader",
    "check_relabelling",
    "check_scale",
    "check_smoother",
    "costs",
    "distributions",
    "example_goal_situation",
    "example_interaction_log",
    "example_log",
    "example_planned_log",
    "example_plans",
    "example_situation",
    "example_team_log",
    "example_trial",
    "factors",
    "games",
    "goal_evidences",
    "goal_situations",
    "histories",
    "log_weights",
    "logs",
    "mutate",
    "play_trials",
    "relabellings",
    "situations",
    "transitions",
]
