import sys
from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from ppinfer.errors import LogError, ModelError, PPInferError
from ppinfer.goals import GoalLQR, Heading, infer_goals
from ppinfer.plots import explore, explore_goals
from ppinfer.studies import goal_evidence, select_trials
from ppinfer.testing import example_log

widgets = pytest.importorskip("ipywidgets", reason="sliders need the extra 'notebooks'")

LOG = example_log()
MODEL = GoalLQR(rationality=0.01, stay=0.98)


def slope(ax, *, gain, name):
    """Draw a line of this slope."""
    if gain > 9:
        raise ModelError("gain must be at most 9; got more")
    ax.plot([0, 1], [0, gain], label=name)


@pytest.fixture
def line():
    return explore(
        slope,
        gain=widgets.FloatSlider(value=2.0, max=10.0),
        name=widgets.Dropdown(options=["a", "b"]),
    )


def drawn(explorer):
    """Return the slope and the name of what is drawn, which is one line."""
    (only,) = explorer.axes[0].lines
    return only.get_ydata()[1], only.get_label()


def test_a_picture_is_drawn_at_once_and_anew_with_each_move(line):
    assert drawn(line) == (2.0, "a")
    line.controls["gain"].value = 5.0
    assert drawn(line) == (5.0, "a")
    line.controls["name"].value = "b"
    assert drawn(line) == (5.0, "b")
    assert line.values == {"gain": 5.0, "name": "b"}


def test_what_a_move_breaks_is_said_in_a_line_and_the_picture_stays(line):
    line.controls["gain"].value = 9.5
    assert line.complaint == "gain must be at most 9; got more"
    line.controls["gain"].value = 3.0
    assert line.complaint == ""
    assert drawn(line) == (3.0, "a")


def test_what_cannot_be_drawn_at_first_is_an_error():
    with pytest.raises(ModelError, match="at most 9"):
        explore(slope, gain=widgets.FloatSlider(value=10.0, max=10.0), name=widgets.Text("a"))


def test_moving_a_control_leaves_axes_where_they_were(line):
    before = line.axes[0].get_position().bounds
    assert line.png().startswith(b"\x89PNG")
    line.controls["gain"].value = 7.0
    line.png()
    assert line.axes[0].get_position().bounds == before
    assert line.figure.canvas.manager is None  # no global state holds on to it


def test_the_picture_on_show_is_replaced_in_place(line, monkeypatch):
    shown, updates = [], []

    class Handle:
        def update(self, image):
            updates.append(image.data)

    def display(what, *, display_id=None):
        shown.append(what)
        return Handle() if display_id else None

    monkeypatch.setattr("IPython.display.display", display)
    line._ipython_display_()
    box, image = shown
    assert set(line.controls.values()) <= set(box.children)
    assert image.data == line.png()
    line.controls["gain"].value = 4.0
    assert updates == [line.png()]
    assert updates[0] != image.data
    line.controls["gain"].value = 9.5
    assert len(updates) == 1


def test_a_control_is_a_widget():
    with pytest.raises(PPInferError, match="gain is to be a widget that holds a value"):
        explore(slope, gain=3.0, name=widgets.Text("a"))


def test_without_ipywidgets_one_line_says_how_to_get_it(monkeypatch):
    monkeypatch.setitem(sys.modules, "ipywidgets", None)
    with pytest.raises(PPInferError, match=r"^sliders need ipywidgets: pip install 'ppinfer\[notebooks\]'$"):
        explore(slope, gain=1.0)


@cache
def on_show(trial):
    """Return the picture of a trial: one for all examples, since what its sliders did before must not matter."""
    return explore_goals(LOG, trial, MODEL)


@settings(max_examples=10, deadline=None)
@given(
    rationality=st.floats(1e-4, 1.0),
    stay=st.sampled_from((0.5, 0.9, 0.98, 1.0)),
    share=st.floats(0.0, 1.0),
    trial=st.integers(0, LOG.sizes["trial"] - 1),
)
def test_the_posterior_that_is_drawn_is_that_of_the_model(rationality, stay, share, trial):
    shown = on_show(trial)
    shown.controls["rationality"].value = rationality
    shown.controls["stay"].value = stay
    seen = shown.controls["seen"]
    seen.value = seen.min + share * (seen.max - seen.min)
    # the slider of a rationality moves in steps, and within bounds
    values = shown.values
    evidence = goal_evidence(select_trials(LOG, np.array([trial])), "human")
    model = replace(MODEL, rationality=values["rationality"], stay=values["stay"])
    belief = np.exp(infer_goals(model, evidence).log_posterior)
    time = evidence.time[evidence.time <= values["seen"]]
    lines = [each for each in shown.axes[1].lines if str(each.get_label()).startswith("goal ")]
    assert [each.get_label() for each in lines] == [f"goal {goal}" for goal in evidence.goal_labels]
    for goal, each in enumerate(lines):
        np.testing.assert_array_equal(each.get_xdata(), time)
        np.testing.assert_allclose(each.get_ydata(), belief[: len(time), goal], atol=1e-12)
    told = [text.get_text() for text in shown.axes[0].texts]
    assert told == [
        f"{goal}: {p:.2f}" for goal, p in zip(evidence.goal_labels, belief[len(time) - 1], strict=True)
    ]


def test_the_picture_says_where_the_sliders_stand():
    shown = explore_goals(LOG, 0, MODEL, parameters=["rationality"])
    assert sorted(shown.controls) == ["rationality", "seen"]
    assert shown.axes[0].get_title(loc="left").endswith("s\nrationality 0.01")
    assert shown.axes[0].get_xlabel() == "x [m]"
    assert shown.axes[1].get_xlabel().startswith("time [s]")


def test_only_what_a_model_is_fitted_by_has_a_slider():
    with pytest.raises(
        PPInferError, match="goal-lqr has no parameter 'dynamics' to move; it has control_weight"
    ):
        explore_goals(LOG, 0, MODEL, parameters=["dynamics"])
    assert "seen" in explore_goals(LOG, 0, Heading(), parameters=tuple(Heading.fitted)).controls


def test_an_agent_of_ones_own_has_no_parameters_to_move():
    own = replace(MODEL, agent=MODEL.agent_at(0.1))
    with pytest.raises(PPInferError, match="has an agent of its own"):
        explore_goals(LOG, 0, own)
    assert sorted(explore_goals(LOG, 0, own, parameters=["stay"]).controls) == ["seen", "stay"]


def test_a_trial_that_is_not_there_is_named():
    with pytest.raises(LogError, match="unknown trial 'nobody'"):
        explore_goals(LOG, "nobody", MODEL)
