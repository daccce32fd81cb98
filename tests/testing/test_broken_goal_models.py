"""Goal models broken on purpose, one for each law, are caught with a counter-example."""

from dataclasses import dataclass

import numpy as np
import pytest

from ppinfer.distributions import Axis, Factor
from ppinfer.goals import Heading, NearestGoal
from ppinfer.testing import check_likelihood


@dataclass(frozen=True)
class Broken(NearestGoal):
    """The nearest goal, to be broken."""

    def distances(self, evidence):
        goals = evidence.goals[evidence.row_of_sample]
        return np.linalg.norm(goals - np.nan_to_num(evidence.position)[:, None], axis=2)


class Foresighted(Broken):
    """Looks one sample ahead."""

    def log_likelihood(self, evidence):
        ahead = np.minimum(
            np.arange(evidence.samples) + 1, evidence.row_start[-1] + evidence.row_size[-1] - 1
        )
        return evidence.likelihood_factor(-self.distances(evidence)[ahead])


class FondOfTheFirst(Broken):
    """Prefers whichever goal is listed first."""

    def log_likelihood(self, evidence):
        bias = np.zeros(len(evidence.goal_labels))
        bias[0] = 1.0
        return evidence.likelihood_factor(bias - self.distances(evidence))


class Leaky(Broken):
    """Lets the mean of all rows into each."""

    def log_likelihood(self, evidence):
        return evidence.likelihood_factor(-self.distances(evidence) * (1 + evidence.rows))


class Superstitious(Broken):
    """Takes a dropout as a sign."""

    def log_likelihood(self, evidence):
        likelihood = evidence.likelihood_factor(-self.distances(evidence)).log_values.copy()
        likelihood[~evidence.seen, 0] += 1.0
        return Factor((evidence.sample_axis, evidence.goal_axis), likelihood)


class Haunted(Broken):
    """Believes in goals that are not there."""

    def log_likelihood(self, evidence):
        distances = np.where(np.isfinite(self.distances(evidence)), self.distances(evidence), 1.0)
        values = np.where(evidence.seen[:, None], -distances, 0.0)
        return Factor((evidence.sample_axis, evidence.goal_axis), values)


class Dogmatic(Broken):
    """Rules out every goal but the nearest."""

    def log_likelihood(self, evidence):
        distances = self.distances(evidence)
        nearest = distances == distances.min(axis=1, keepdims=True)
        return evidence.likelihood_factor(np.where(nearest, 0.0, -np.inf))


class Sideways(Broken):
    """Answers over axes of its own."""

    def log_likelihood(self, evidence):
        return Factor(
            (evidence.sample_axis, Axis("place", len(evidence.goal_labels))), -self.distances(evidence)
        )


class AnotherOnline(Broken):
    """Says something else at control rate."""

    def online(self, dt):
        return NearestGoal(scale=3 * self.scale).online(dt)


class OversureOfItself(Heading):
    """Weighs its evidence four times: every law of form holds, and the probabilities are wrong."""

    def log_likelihood(self, evidence):
        return super().log_likelihood(evidence) ** 4.0


@pytest.mark.parametrize(
    ("model", "complaint"),
    [
        (Foresighted(), "depends on (later samples|the rows beside)"),
        (FondOfTheFirst(), "order in which goals are listed"),
        (Leaky(), "depends on the rows beside it"),
        (Superstitious(), "a dropout must tell nothing"),
        (Haunted(), "an absent goal must be impossible"),
        (Dogmatic(), "must not be impossible"),
        (Sideways(), "expected \\(sample, goal\\)"),
        (AnotherOnline(), "the online belief differs"),
    ],
    ids=lambda value: type(value).__name__,
)
def test_a_broken_model_is_caught(model, complaint):
    with pytest.raises(AssertionError, match=complaint):
        check_likelihood(model, twin=False)


def test_the_counter_example_is_small_and_shown():
    with pytest.raises(AssertionError) as caught:
        check_likelihood(Superstitious(), twin=False)
    shown = "\n".join(caught.value.__notes__)
    assert "GoalEvidence" in shown
    # shrunk to one row of one sample, which is a dropout
    assert "row_size=array([1])" in shown
    assert "observed=array([False])" in shown


class Childless(Broken):
    """Has no generative twin."""

    def simulate(self, design, rng):
        raise NotImplementedError


def test_a_missing_twin_is_told_how_to_be_left_out():
    with pytest.raises(AssertionError, match="twin=False"):
        check_likelihood(Childless(), examples=1)


def test_evidence_that_is_weighed_twice_is_caught_by_the_generative_twin():
    check_likelihood(OversureOfItself(), twin=False, examples=10)
    with pytest.raises(AssertionError, match="do not describe the same agent"):
        check_likelihood(OversureOfItself(), examples=1)
