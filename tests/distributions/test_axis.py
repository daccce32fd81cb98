"""Axes: labels, equality, and what they refuse."""

import pickle

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ppinfer import Axis, AxisError, Factor
from ppinfer.distributions.axis import check_same
from ppinfer.testing import axes


@given(axes())
def test_every_label_is_found_at_its_position(axis):
    assert [axis.index(label) for label in axis.labels] == list(range(len(axis)))


@given(axes())
def test_an_axis_made_again_from_its_labels_is_equal_and_hashes_alike(axis):
    again = Axis(axis.name, list(axis.labels))
    assert again == axis
    assert hash(again) == hash(axis)
    assert pickle.loads(pickle.dumps(axis)) == axis


@given(axes())
def test_an_axis_made_from_an_array_of_its_labels_is_equal(axis):
    assert Axis(axis.name, axis.label_array()) == axis


@given(axes(), st.data())
def test_choosing_labels_gives_their_positions(axis, data):
    order = data.draw(st.permutations(list(axis.labels)))
    chosen = order[: data.draw(st.integers(1, len(order)))]
    shorter, positions = axis.restrict(chosen)
    assert list(shorter.labels) == chosen
    assert [axis.labels[i] for i in positions] == chosen


def test_a_length_is_a_range_axis():
    assert Axis("sample", 3).labels == range(3)
    assert Axis("sample", 3) == Axis("sample", [0, 1, 2])


def test_a_range_axis_of_any_length_is_made_compared_and_indexed_without_walking_it():
    huge = 10**15
    assert Axis("sample", huge) == Axis("sample", range(huge))
    assert Axis("sample", huge) != Axis("sample", huge + 1)
    assert Axis("sample", huge).index(huge - 1) == huge - 1


def test_ranges_of_equal_length_but_other_labels_differ():
    assert Axis("sample", range(5, 8)) != Axis("sample", 3)


def test_a_range_may_be_chosen_from_a_range():
    shorter, positions = Axis("sample", range(0, 100, 5)).restrict(range(10, 40, 10))
    assert shorter == Axis("sample", [10, 20, 30])
    assert positions.tolist() == [2, 4, 6]
    with pytest.raises(AxisError, match="no label 14"):
        Axis("sample", range(0, 100, 5)).restrict(range(10, 16, 2))


@pytest.mark.parametrize(
    ("one", "other"),
    [([True, False], [1, 0]), ([0.0, 1.0], [0, 1]), (["0", "1"], [0, 1]), ([1.0, 2.5], [1, 2])],
)
def test_labels_of_different_types_are_different_labels(one, other):
    assert Axis("goal", one) != Axis("goal", other)


def test_other_names_make_other_axes():
    assert Axis("goal", 3) != Axis("plan", 3)
    assert Axis("goal", 3).rename("plan") == Axis("plan", 3)
    assert Axis("goal", 3) != "goal"


def test_numpy_scalars_are_labels_of_their_python_type():
    axis = Axis("goal", [np.int64(4), np.int64(9)])
    assert axis == Axis("goal", [4, 9])
    assert axis.index(np.int32(9)) == 1


def test_an_int_finds_its_equal_on_an_axis_of_floats():
    axis = Axis("beta", [0.5, 1.0])
    assert axis.index(1) == 1
    assert axis.restrict([1])[0] == Axis("beta", [1.0])


@pytest.mark.parametrize(
    ("labels", "says"),
    [
        ([], "has no labels"),
        (0, "a length of 0"),
        (range(0), "is empty"),
        (["cup", "bowl", "cup"], "'cup' is repeated, at positions 0 and 2"),
        ([0.0, -0.0], "repeated"),
        (["cup", 1], "one type.*'cup' is a str.*1 at position 1 is a int"),
        ([1, True], "one type"),
        ([1.0, float("nan")], "position 1 is NaN"),
        ([None], "NoneType"),
        ([("a", "b")], "tuple"),
        ("cup", "sequence"),
        (True, "sequence"),
        (np.zeros((2, 2)), "one-dimensional"),
    ],
)
def test_labels_that_cannot_be_are_refused_by_axis_and_label(labels, says):
    with pytest.raises(AxisError, match=f"axis 'goal'.*{says}"):
        Axis("goal", labels)


@pytest.mark.parametrize("name", ["", "my goal", "1st", "a-b"])
def test_a_name_that_is_no_keyword_is_refused(name):
    with pytest.raises(AxisError, match="identifier"):
        Axis(name, 3)


@pytest.mark.parametrize("label", ["mug", 0, True, 1.5])
def test_an_unknown_label_is_refused_with_those_there_are(label):
    with pytest.raises(AxisError, match=r"axis 'goal' has no label .* \['cup', 'bowl'\]"):
        Axis("goal", ["cup", "bowl"]).index(label)
    with pytest.raises(AxisError, match="no label"):
        Axis("goal", [4, 9]).index(label)


def test_axes_cannot_be_changed():
    with pytest.raises(AttributeError):
        Axis("goal", 3).name = "plan"
    with pytest.raises(AttributeError):
        Axis("goal", 3).labels = range(4)


def test_a_mismatch_names_both_sides_and_the_labels_that_differ():
    left = Factor([Axis("goal", ["cup", "bowl", "mug"])], [0.0, 0.0, 0.0])
    right = Factor([Axis("goal", ["cup", "mug", "jar"])], [0.0, 0.0, 0.0])
    with pytest.raises(AxisError, match=r"'goal'.*left 'bowl', only on the right 'jar'.*restrict\(goal"):
        left * right


def test_the_same_labels_in_another_order_are_a_mismatch_that_says_so():
    left = Factor([Axis("goal", ["cup", "bowl"])], [0.0, 0.0])
    right = Factor([Axis("goal", ["bowl", "cup"])], [0.0, 0.0])
    with pytest.raises(AxisError, match=r"another order: at position 0 left has 'cup', right has 'bowl'"):
        left * right
    assert left * right.restrict(goal=["cup", "bowl"]) == left


def test_ranges_of_other_lengths_are_a_mismatch_that_says_the_lengths():
    with pytest.raises(AxisError, match=r"left has 10 labels.*right has 12"):
        check_same(Axis("sample", 10), Axis("sample", 12))


def test_labels_of_another_type_are_a_mismatch_that_says_the_types():
    with pytest.raises(AxisError, match="left are int, on the right str"):
        check_same(Axis("goal", [7, 3, 5]), Axis("goal", ["7", "3", "5"]))


def test_a_mismatch_of_long_axes_is_a_short_message():
    left = Axis("goal", [f"goal {i}" for i in range(1000)])
    right = Axis("goal", [f"post {i}" for i in range(1000)])
    with pytest.raises(AxisError) as error:
        check_same(left, right)
    assert len(str(error.value)) < 700


def test_reprs_are_short_and_say_the_labels():
    assert repr(Axis("sample", 10**6)) == "Axis('sample', 1000000)"
    assert repr(Axis("goal", ["cup", "bowl"])) == "Axis('goal', ['cup', 'bowl'])"
    assert len(repr(Axis("goal", [f"g{i}" for i in range(100)]))) < 80
