import numpy as np

from ppinfer.studies import Segment
from ppsim.reaching import Played, segments_of

GOALS = np.array([[10.0, 0.0], [0.0, 10.0]])


def played(x, pursued, drawn):
    """Return a trial of one agent that moves along the x axis."""
    samples = len(x)
    position = np.zeros((samples, 1, 2))
    position[:, 0, 0] = x
    flags = np.zeros(samples, dtype=bool)
    goals = np.where(np.array(drawn)[:, None, None] == 0, GOALS, GOALS + 50.0)
    return Played(
        time=np.arange(samples) * 0.1,
        position=position,
        velocity=np.zeros_like(position),
        control=np.zeros_like(position),
        goals=goals,
        drawn=np.array(drawn),
        pursued=np.array(pursued)[:, None],
        scored=flags,
        collided=flags,
        score=0,
    )


def test_a_segment_ends_where_the_agent_arrives_and_not_where_it_stops_waiting():
    trial = played([0, 5, 9.6, 9.9, 10.1, 10.0], [0] * 6, [0] * 6)
    assert segments_of(trial, 0, "human", 0.5) == [Segment("human", 0, 2, "0")]


def test_the_pick_is_seen_at_the_first_sample_of_the_new_goals():
    trial = played([0, 5, 9.8, 10], [0, 0, 1, 1], [0, 0, 1, 1])
    assert segments_of(trial, 0, "human", 0.5) == [Segment("human", 0, 2, "0")]


def test_a_goal_given_up_ends_a_segment_and_what_the_trial_cuts_off_is_none():
    trial = played([0, 1, 2, 3, 2], [0, 0, 0, 1, 1], [0] * 5)
    assert segments_of(trial, 0, "human", 0.5) == [Segment("human", 0, 3, "0")]


def test_turning_to_a_goal_that_one_is_at_is_no_segment():
    trial = played([10, 10, 10], [1, 0, 0], [0] * 3)
    assert segments_of(trial, 0, "human", 0.5) == [Segment("human", 0, 1, "1")]


def test_a_wait_is_no_segment_and_ends_one():
    trial = played([0, 2, 4, 4, 4, 7, 9.8, 10], [0, 0, -1, -1, 0, 0, 0, 0], [0] * 8)
    assert segments_of(trial, 0, "human", 0.5) == [Segment("human", 0, 2, "0"), Segment("human", 4, 6, "0")]
