"""The switching robot: it influences a human who looks unsure, and is courteous to one who looks resolute."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import ClassVar

from ppinfer.errors import ModelError
from ppinfer.goals.choice.chooser import GoalChooser, GoalDecision, GoalSituation
from ppinfer.goals.choice.courtesy import Courtesy
from ppinfer.goals.choice.influence import Influence
from ppinfer.goals.model import require_range


@dataclass(frozen=True)
class Switching(GoalChooser):
    """Influences while the human looks unsure of their goal, else is courteous.

    The human looks unsure while the greatest of the rationalities considered, under which they make straight for a
    goal, has a marginal probability below the threshold: at first, as long as it is too early to tell; and whenever
    their motion is explained better by a lower one, so that they dither, stand or wander. The situation must carry a
    belief over goal and rationality jointly (`BehaviourPredictor` with ``rationalities``).

    Parameters
    ----------
    threshold : float
        Probability, in [0, 1].
    unsure, resolute : GoalChooser
        Who chooses then.

    Raises
    ------
    ModelError
        Where the threshold is no probability, or a situation comes without a belief over rationality.

    Examples
    --------
    >>> from ppinfer.testing import example_goal_situation
    >>> situation = example_goal_situation()
    >>> situation.rationality_belief.marginal("rationality").values.round(2)
    array([0.2, 0.3, 0.5])
    >>> Switching(threshold=0.4).choose(situation).goal, Switching(threshold=0.6).choose(situation).goal
    (1, 0)
    """

    name: ClassVar[str] = "switching"
    needs_rationality: ClassVar[bool] = True

    threshold: float = 0.5
    unsure: GoalChooser = field(default_factory=Influence)
    resolute: GoalChooser = field(default_factory=Courtesy)

    def __post_init__(self) -> None:
        require_range("threshold", self.threshold, 0.0, 1.0)

    def looks_unsure(self, situation: GoalSituation) -> bool:
        """Return whether the greatest rationality has a probability below the threshold."""
        belief = situation.rationality_belief
        if belief is None or "rationality" not in belief.random:
            raise ModelError(
                "the switching robot needs a situation with a belief over goal and rationality: give the "
                "BehaviourPredictor rationalities, or use ppinfer.goals.GoalAndRationality"
            )
        axis = belief.axis("rationality")
        probability = belief.marginal("rationality").values
        greatest = max(range(len(axis)), key=axis.labels.__getitem__)
        return float(probability[greatest]) < self.threshold

    def choose(self, situation: GoalSituation) -> GoalDecision:
        """Return the choice of `unsure` or of `resolute`."""
        chooser = self.unsure if self.looks_unsure(situation) else self.resolute
        return chooser.choose(situation)
