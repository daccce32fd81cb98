"""The laws that every chooser of goals, and every prediction of a reaction, obeys; to be run on one's own."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from ppinfer.distributions import Distribution
from ppinfer.errors import PPInferError
from ppinfer.goals.choice import GoalChooser, GoalDecision, GoalSituation
from ppinfer.goals.conditional import GoalConditional, goal_axes
from ppinfer.testing.goal_scenes import moved_scene, rearranged
from ppinfer.testing.laws import check_normalisation

if TYPE_CHECKING:
    Law = Callable[[GoalSituation], None]

_TOLERANCE = 1e-9


def check_goal_chooser(chooser: GoalChooser, *, examples: int = 60, symmetric: bool = True) -> None:
    """Hold a chooser of goals to the laws; a broken one fails with a situation that shows it.

    The laws: the decision is one of the goals that are there, the first with the least score, or to wait, and then
    every score is inf; the score is a number or inf, and inf where a goal is absent; `post` is a distribution over
    ``post_goal`` given ``robot_goal`` that gives absent goals nothing; the same situation has the same decision, and is
    left as it was; a single goal will do. With `symmetric`, listing the goals in another order permutes the decision
    (the situations have no ties); an absent goal might as well not be listed; moving the whole scene changes nothing.

    Parameters
    ----------
    chooser : GoalChooser
        The chooser. Situations carry a belief over rationality too, and short histories of the states
        [px, vx, py, vy] of both agents.
    examples : int
        How many situations to try on each law.
    symmetric : bool
        Whether those three are asked for; a chooser that draws at random for one goal after another need not obey them.

    Raises
    ------
    AssertionError
        Naming the law; the note that Hypothesis adds shows the situation.
    PPInferError
        Where Hypothesis is not installed (``pip install 'ppinfer[test]'``).

    Examples
    --------
    >>> from ppinfer.goals.choice import Influence
    >>> check_goal_chooser(Influence(), examples=5)
    """
    symmetries = (_check_choice_order, _check_absent_goals, _check_choice_in_another_place)
    for law in (_check_decision, _check_repetition, *(symmetries if symmetric else ())):

        def holds(situation: GoalSituation) -> None:
            law(chooser, situation)  # noqa: B023 - called within this turn of the loop

        _for_situations(holds, examples)


def check_goal_conditional(
    conditional: GoalConditional, *, examples: int = 60, symmetric: bool = True
) -> None:
    """Hold a prediction of the human's reaction to the laws; a broken one fails with a situation that shows it.

    The laws: the answer is a distribution over ``post_goal``, given a subset of ``goal`` and ``robot_goal``, with the
    labels of the situation; given goals that exist, absent ones have probability zero; the same situation has the same
    answer. With `symmetric`, listing the goals in another order permutes it, and moving the whole scene changes
    nothing.

    Parameters
    ----------
    conditional : GoalConditional
        The prediction.
    examples : int
        How many situations to try.
    symmetric : bool
        Whether the last two laws are asked for; a learned prediction need not obey them.

    Raises
    ------
    AssertionError
        Naming the law; the note that Hypothesis adds shows the situation.
    PPInferError
        Where Hypothesis is not installed.

    Examples
    --------
    >>> from ppinfer.goals import SoftmaxConditional
    >>> check_goal_conditional(SoftmaxConditional(), examples=5)
    """

    def holds(situation: GoalSituation) -> None:
        answer = conditional.conditional(situation)
        _check_answer(situation, answer)
        again = conditional.conditional(situation)
        assert np.array_equal(again.log_values, answer.log_values), (
            "the same situation has another prediction"
        )
        if symmetric:
            order = np.arange(len(situation.goals))[::-1]
            turned = conditional.conditional(rearranged(situation, order)).log_values
            back = turned[np.ix_(*[order] * turned.ndim)]
            _assert_same(
                back, answer.log_values, "the prediction depends on the order in which goals are listed"
            )
            moved = conditional.conditional(moved_scene(situation)).log_values
            _assert_same(moved, answer.log_values, "the prediction depends on where the whole scene is")

    _for_situations(holds, examples)


def _for_situations(law: Law, examples: int) -> None:
    try:
        from hypothesis import HealthCheck, Phase, given, settings
    except ImportError as error:
        raise PPInferError("this check needs Hypothesis: pip install 'ppinfer[test]'") from error
    from ppinfer.testing.situation_strategies import goal_situations

    quiet = settings(
        derandomize=True,
        deadline=None,
        database=None,
        max_examples=examples,
        report_multiple_bugs=False,
        phases=[Phase.explicit, Phase.generate, Phase.shrink],
        suppress_health_check=list(HealthCheck),
    )
    quiet(given(situation=goal_situations())(law))()


def _check_decision(chooser: GoalChooser, situation: GoalSituation) -> None:
    decision = chooser.choose(situation)
    assert isinstance(decision, GoalDecision), f"choose returned {type(decision).__name__}, no GoalDecision"
    goals, score = len(situation.goals), decision.score
    assert np.shape(score) == (goals,), f"score has shape {np.shape(score)}; expected ({goals},)"
    assert not np.isnan(score).any(), f"a score is NaN: {score}"
    assert (score > -np.inf).all(), f"a score is -inf: {score}"
    present = _present(situation)
    assert (score[~present] == np.inf).all(), "an absent goal must have the score inf"
    if decision.goal is None:
        assert (score == np.inf).all(), (
            f"waiting means that every goal is ruled out, but the scores are {score}"
        )
    else:
        valid = type(decision.goal) is int and 0 <= decision.goal < goals
        assert valid, f"the decision must be None or an int from 0 to {goals - 1}; got {decision.goal!r}"
        assert present[decision.goal], f"goal {decision.goal} is absent"
        assert np.isfinite(score[decision.goal]), f"goal {decision.goal} was chosen at a score of inf"
        least = int(np.argmin(score))
        assert decision.goal == least, (
            f"goal {decision.goal} was chosen, but goal {least} is the first with the least score: {score}"
        )
    _check_post(situation, decision.post)


def _check_post(situation: GoalSituation, post: Distribution) -> None:
    _, robot_goal, post_goal = goal_axes(situation.belief.axes[0])
    assert isinstance(post, Distribution), f"post is a {type(post).__name__}, no Distribution"
    conditional = post.random == ("post_goal",) and post.conditions == ("robot_goal",)
    assert conditional and post.axes == (robot_goal, post_goal), (  # noqa: PT018
        f"post must be over post_goal given robot_goal, in the order (robot_goal, post_goal), with the situation's "
        f"labels; got {post!r}"
    )
    check_normalisation(post)
    assert (post.log_values[:, ~_present(situation)] == -np.inf).all(), (
        "an absent goal is a post goal with probability > 0"
    )


def _check_answer(situation: GoalSituation, answer: Distribution) -> None:
    axes = dict(zip(("goal", "robot_goal", "post_goal"), goal_axes(situation.belief.axes[0]), strict=True))
    assert isinstance(answer, Distribution), f"conditional returned {type(answer).__name__}, no Distribution"
    conditional = answer.random == ("post_goal",) and set(answer.conditions) <= {"goal", "robot_goal"}
    assert conditional and not answer.batch, (  # noqa: PT018
        f"a conditional is random in post_goal and given goal, robot_goal, both or neither; got {answer!r}"
    )
    for axis in answer.axes:
        assert axis == axes[axis.name], f"the labels of {axis.name} are not those of the situation: {axis!r}"
    check_normalisation(answer)
    present = _present(situation)
    # given a goal that is not there, of which nobody's belief makes anything, the answer is as good as any
    asked = [~present if name == "post_goal" else present for name in answer.names]
    taken = answer.log_values[np.ix_(*asked)]
    assert (taken == -np.inf).all(), "an absent goal is a post goal with probability > 0"


def _check_repetition(chooser: GoalChooser, situation: GoalSituation) -> None:
    before = rearranged(situation, np.arange(len(situation.goals)))
    first, second = chooser.choose(situation), chooser.choose(situation)
    same = first.goal == second.goal and np.array_equal(first.score, second.score)
    assert same, f"the same situation was decided twice differently: {first.goal} and {second.goal}"
    for name in ("goals", "human", "robot", "human_position", "robot_position"):
        assert np.array_equal(getattr(situation, name), getattr(before, name), equal_nan=True), (
            f"choose changed situation.{name}"
        )


def _check_choice_order(chooser: GoalChooser, situation: GoalSituation) -> None:
    order = np.arange(len(situation.goals))[::-1]
    decision, turned = chooser.choose(situation), chooser.choose(rearranged(situation, order))
    message = "the decision depends on the order in which goals are listed"
    _assert_same(turned.score[order], decision.score, message)
    assert _mapped(turned.goal, order) == decision.goal, (
        f"{message}: {_mapped(turned.goal, order)}, {decision.goal}"
    )
    _assert_same(turned.post.log_values[np.ix_(order, order)], decision.post.log_values, message)


def _check_absent_goals(chooser: GoalChooser, situation: GoalSituation) -> None:
    there = np.flatnonzero(_present(situation))
    decision = chooser.choose(situation)
    alone = chooser.choose(replace(rearranged(situation, there), present=None))
    message = "a goal that is absent changes the decision"
    _assert_same(decision.score[there], alone.score, message)
    assert decision.goal == _mapped(alone.goal, there), f"{message}: {decision.goal}, {alone.goal}"


def _check_choice_in_another_place(chooser: GoalChooser, situation: GoalSituation) -> None:
    decision, moved = chooser.choose(situation), chooser.choose(moved_scene(situation))
    message = "the decision depends on where the whole scene is"
    _assert_same(moved.score, decision.score, message)
    assert moved.goal == decision.goal, f"{message}: {moved.goal}, {decision.goal}"


def _present(situation: GoalSituation) -> np.ndarray:
    return np.ones(len(situation.goals), dtype=bool) if situation.present is None else situation.present


def _mapped(goal: int | None, order: np.ndarray) -> int | None:
    return None if goal is None else int(order[goal])


def _assert_same(ours: np.ndarray, theirs: np.ndarray, message: str) -> None:
    finite = np.isfinite(theirs)
    assert (np.isfinite(ours) == finite).all(), f"{message}: {ours} against {theirs}"
    scale = 1.0 + np.abs(theirs[finite]).max(initial=0.0)
    gap = np.abs(ours[finite] - theirs[finite]).max(initial=0.0)
    assert gap <= _TOLERANCE * scale, f"{message}: {ours} against {theirs}"
