"""Orders of conditions: what they balance, against brute force, and where they are read from."""

from collections import Counter
from fractions import Fraction
from itertools import pairwise, permutations, product

import numpy as np
import pytest
import xarray as xr
from hypothesis import given
from hypothesis import strategies as st
from scipy import stats

from ppinfer.errors import LogError
from ppinfer.studies.faults import FaultyLogError
from ppinfer.studies.surveys import (
    Instrument,
    check_orders,
    orders_of_log,
    orders_of_survey,
    read_orders,
    read_survey,
)
from ppinfer.studies.surveys import random_orders as module
from ppinfer.studies.surveys.survey_orders import check_survey_orders

from .tables import HEADER, INSTRUMENT, table

READ = Instrument.parse(INSTRUMENT)
some_orders = st.sampled_from(["ab", "abc"]).flatmap(
    lambda names: st.tuples(
        st.just(names), st.lists(st.permutations(names), min_size=1, max_size=5 if len(names) == 2 else 4)
    )
)


def named(orders):
    return {f"p{i}": tuple(order) for i, order in enumerate(orders)}


def unevenness(orders, names):
    counts = Counter((name, at) for order in orders for at, name in enumerate(order))
    expected = Fraction(len(orders), len(names))
    return sum((counts[name, at] - expected) ** 2 for name in names for at in range(len(names)))


@given(some_orders)
def test_p_is_the_share_of_all_assignments_that_are_as_uneven(drawn):
    names, orders = drawn
    found = check_orders(named(orders), conditions=list(names))
    observed = unevenness(orders, names)
    every = list(product(permutations(names), repeat=len(orders)))
    wanted = Fraction(sum(unevenness(each, names) >= observed for each in every), len(every))
    assert found.method == "exact"
    assert found.p == pytest.approx(float(wanted), abs=1e-9)
    k, n = len(names), len(orders)
    assert found.statistic == pytest.approx(float(observed * (k - 1) / n), abs=1e-9)


@given(some_orders)
def test_tables_count_positions_and_who_follows_whom(drawn):
    names, orders = drawn
    found = check_orders(named(orders), conditions=list(names))
    for i, name in enumerate(names):
        assert found.positions[i].tolist() == [
            sum(order[at] == name for order in orders) for at in range(len(names))
        ]
        for j, other in enumerate(names):
            pairs = [pair for order in orders for pair in pairwise(order)]
            assert found.following[i, j] == pairs.count((name, other))
    assert sum(found.orders.values()) == len(orders)
    assert set(found.orders) | set(found.absent) == set(permutations(names))
    assert (found.cramers_v == 0) == found.equal_positions == (found.confounding == "none")


@given(some_orders, st.randoms(use_true_random=False))
def test_renaming_conditions_or_participants_changes_no_number(drawn, random):
    names, orders = drawn
    renamed = dict(zip(names, random.sample(names, len(names)), strict=True))
    one = check_orders(named(orders), conditions=list(names))
    other = check_orders(
        named([[renamed[name] for name in order] for order in orders[::-1]]), conditions=list(names)
    )
    assert (one.p, one.design, one.confounding) == (other.p, other.design, other.confounding)
    assert one.cramers_v == pytest.approx(other.cramers_v)


def test_random_assignments_agree_with_going_through_all(monkeypatch):
    orders = named(["abc", "abc", "bca", "cab", "abc", "acb"])
    exact = check_orders(orders)
    monkeypatch.setattr(module, "EXACT_ASSIGNMENTS", 0)
    drawn = check_orders(orders)
    assert drawn.method == "20000 random assignments"
    assert drawn.p == pytest.approx(exact.p, abs=0.01)
    assert check_orders(orders).p == drawn.p
    # a few at a time, as memory allows
    monkeypatch.setattr(module, "_MAX_CELLS", 9 * 700)
    assert check_orders(orders).p == pytest.approx(exact.p, abs=0.01)


def test_many_conditions_of_many_participants_take_fewer_random_assignments(monkeypatch):
    rng = np.random.default_rng(2)
    names = [f"c{at}" for at in range(30)]
    orders = named([rng.permutation(names).tolist() for _ in range(40)])
    monkeypatch.setattr(module, "_MAX_DRAWS", 30 * 40 * 200)
    found = check_orders(orders)
    assert found.method == "200 random assignments"
    assert 0.0 < found.p <= 1.0


def test_the_statistic_nears_the_chi_squared_distribution_in_a_large_study():
    rng = np.random.default_rng(1)
    orders = named([rng.permutation(list("abc")).tolist() for _ in range(80)])
    found = check_orders(orders)
    assert found.p == pytest.approx(stats.chi2.sf(found.statistic, 4), abs=0.03)


@pytest.mark.parametrize(
    ("orders", "design", "confounding"),
    [
        (["abc", "abc"], "one order", "perfect"),
        (list(permutations("abc")), "fully counterbalanced", "none"),
        (["abc", "bca", "cab"], "Latin square", "none"),
        (["abdc", "bcad", "cdba", "dacb"], "Williams design", "none"),
        (["abc", "acb", "abc"], "not counterbalanced", "partial"),
        (["ab", "ba"], "fully counterbalanced", "none"),
    ],
)
def test_designs_have_the_strictest_name_that_holds(orders, design, confounding):
    found = check_orders(named(orders))
    assert (found.design, found.confounding) == (design, confounding)
    assert found.cramers_v == pytest.approx({"perfect": 1.0, "none": 0.0}.get(confounding, found.cramers_v))


def test_participants_whose_order_lacks_conditions_are_counted_apart():
    found = check_orders({"a": "xy", "b": "x", "c": "", "d": "yx"})
    assert found.incomplete == ("b", "c")
    assert found.participants == 2
    nobody = check_orders({"b": "x"}, conditions=["x", "y"])
    assert nobody.lines() == ["no participant has an order with every condition"]
    assert np.isnan(nobody.p)


def test_what_a_number_of_participants_does_not_allow_is_said():
    found = check_orders(named(["abc", "bca", "cab", "abc"]))
    assert not found.equal_positions
    assert found.nearly_equal_positions
    assert "but as evenly as this number of participants allows" in " ".join(found.lines())


@pytest.mark.parametrize(
    ("orders", "options", "told"),
    [
        ({"a": "xx"}, {"conditions": ["x", "y"]}, "the order of participant 'a' comes to 'x' twice"),
        ({"a": "xz"}, {"conditions": ["x", "y"]}, "the order of participant 'a' has no condition 'z'"),
        ({"a": "x"}, {}, "two conditions or more"),
        ({}, {}, "got none"),
        ({"a": [f"c{at}" for at in range(101)]}, {}, "101 conditions, and orders of at most 100 are checked"),
    ],
)
def test_orders_that_are_none_are_refused(orders, options, told):
    with pytest.raises(LogError, match=told):
        check_orders(orders, **options)


def test_a_table_of_orders_is_read_and_each_fault_of_it_told(tmp_path):
    path = tmp_path / "orders.csv"
    path.write_text("user,name,first,second\nu,Ann,one,two\nv,Bob,two,\n")
    assert read_orders(path, READ, ["one", "two"]) == {"u": ("one", "two"), "v": ("two",)}
    path.write_text("user,first,second\nu,one,tow\nu,one,one\n,one,two\n")
    with pytest.raises(FaultyLogError) as caught:
        read_orders(path, READ, ["one", "two"])
    assert [line.partition(": ")[2] for line in caught.value.lines] == [
        "line 4: column 'user': no participant; fill it in",
        "line 2: column 'second': no condition 'tow'; did you mean 'two'? there are 'one', 'two'",
        "line 3: column 'second': condition 'one' twice in one order",
        "line 3: column 'user': this participant has an order in line 2 already; keep one",
    ]
    with pytest.raises(FaultyLogError, match="column 'third': there is no such column"):
        read_orders(path, READ, ["one", "two", "three"])
    own = Instrument.parse(INSTRUMENT + "\n[orders]\nsubject = 'who'\npositions = ['p1', 'p2']\n")
    path.write_text("who,p1,p2\nu,two,one\n")
    assert read_orders(path, own, ["one", "two"]) == {"u": ("two", "one")}
    with pytest.raises(LogError, match="name the columns of 12 positions"):
        read_orders(path, READ, [str(i) for i in range(12)])


def test_positions_of_a_survey_give_orders(tmp_path):
    instrument = Instrument.parse(
        INSTRUMENT.replace('condition = "robot"', 'condition = "robot"\nposition = "at"')
    )
    rows = [["u", "", "one", 1, 1, 1, 2], ["u", "", "two", 1, 2, 1, 1], ["v", "", "one", 2, 2, 1, ""]]
    path = tmp_path / "answers.csv"
    path.write_text(table(rows, [*HEADER, "at"]))
    survey = read_survey(path, instrument, keep_ids=True)
    assert orders_of_survey(survey) == {"u": ("two", "one"), "v": ()}
    checked = check_survey_orders(survey)
    assert len(checked.without_order) == 1
    assert checked.without_order[0].startswith("P")
    path.write_text(table([*rows[:2], ["u", "", "three", 1, 1, 1, 1]], [*HEADER, "at"]))
    with pytest.raises(FaultyLogError, match="several conditions at position 1: 'three', 'two'"):
        orders_of_survey(read_survey(path, instrument))
    path.write_text(table([row[:6] for row in rows]))
    with pytest.raises(LogError, match="no column of positions"):
        orders_of_survey(read_survey(path, READ))


def test_orders_are_told_without_names(tmp_path):
    (tmp_path / "answers.csv").write_text(
        table([[u, "", r, 1, 1, 1] for u in ("ann", "bob") for r in ("one", "two")])
    )
    (tmp_path / "orders.csv").write_text("user,first,second\nann,one,\ncyd,two,one\n")
    survey = read_survey(tmp_path / "answers.csv", READ, keep_ids=True)
    checked = check_survey_orders(survey, tmp_path / "orders.csv")
    told = str(checked.to_json())
    assert not any(name in told for name in ("ann", "bob", "cyd"))
    assert checked.not_in_survey == 1
    assert len(checked.without_order) == len(checked.found.incomplete) == 1
    assert checked.lines()[-2:] == [
        "1 participants of the survey have no order",
        "1 participants have an order and no response",
    ]


def test_the_order_of_a_log_is_that_of_its_trials_or_of_a_variable():
    log = xr.Dataset(
        {
            "participant": ("trial", ["p", "p", "p", "q"]),
            "condition": ("trial", ["a", "a", "b", ""]),
            "when": ("trial", [3, 2, 1, 1]),
        }
    )
    assert orders_of_log(log) == {"p": ("a", "b"), "q": ()}
    assert orders_of_log(log, order="when") == {"p": ("b", "a"), "q": ()}
    with pytest.raises(LogError, match="no variable 'wehn' of a trial; did you mean 'when'"):
        orders_of_log(log, order="wehn")


def test_names_are_those_that_one_gives(tmp_path):
    (tmp_path / "answers.csv").write_text(
        table([[u, "", r, 1, 1, 1] for u in ("ann", "bob") for r in ("one", "two")])
    )
    (tmp_path / "orders.csv").write_text("user,first,second\nann,one,\n")
    survey = read_survey(tmp_path / "answers.csv", READ, keep_ids=True)
    checked = check_survey_orders(survey, tmp_path / "orders.csv", names={"ann": "ann", "bob": "bob"})
    assert (checked.without_order, checked.found.incomplete) == (("bob",), ("ann",))
