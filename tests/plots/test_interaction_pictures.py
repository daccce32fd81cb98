from dataclasses import replace

import numpy as np
import pytest
from matplotlib.colors import to_hex
from matplotlib.figure import Figure

from ppinfer.errors import LogError
from ppinfer.goals.choice.joint import point_agent
from ppinfer.plots import plot_candidates, plot_conditional_belief, plot_game_performance, plot_risk_map
from ppinfer.plots.game_performance import GAME_LABELS
from ppinfer.plots.learning_curve import plot_learning_curve
from ppinfer.plots.palette import (
    AGENT_COLOURS,
    HUMAN_COLOUR,
    ROBOT_COLOUR,
    goal_colour_among_agents,
    new_axes,
)
from ppinfer.plots.workspace import draw_goals
from ppinfer.safety import Mover
from ppinfer.studies import infer_log_conditional
from ppinfer.studies.interaction import read_interaction, stretches
from ppinfer.studies.interaction_safety import candidate_paths, risk_map
from ppinfer.testing import example_goal_situation, example_interaction_log
from ppinfer.testing.prediction_examples import example_learning_rows


@pytest.fixture(scope="module")
def interaction():
    log = example_interaction_log()
    uneven = np.log(np.array([0.2, 0.3, 0.5]))
    for name, values in (("live_log_belief", uneven), ("live_log_post", uneven[::-1])):
        log[name] = (("sample", "goal"), np.tile(values, (log.sizes["sample"], 1)))
    log["collision"] = ("sample", np.arange(log.sizes["sample"]) % 30 == 7)
    return read_interaction(log, infer_log_conditional(log), stretches(log, "human")[1])


@pytest.fixture(scope="module")
def paths():
    return candidate_paths(example_goal_situation(), 0, np.array([0.1, 0.8, 0.1]), rollouts=400)


def lines_of(ax):
    return {line.get_label(): line for line in ax.lines if not line.get_label().startswith("_")}


def test_goals_are_drawn_in_colours_that_no_agent_has():
    assert not {goal_colour_among_agents(goal) for goal in range(9)} & set(AGENT_COLOURS)


def test_each_panel_draws_one_belief_in_the_order_that_is_said(interaction):
    *panels, paths = plot_conditional_belief(interaction)
    assert [ax.get_title(loc="left") for ax in panels] == [
        "without the robot",
        "given the robot's goal",
        "overall: averaged over what the human may take that goal to be",
        "live, without the robot (live_log_belief)",
        "live, given the robot (live_log_post)",
    ]
    drawn = (interaction.belief, interaction.given, interaction.overall, *interaction.live.values())
    for ax, values in zip(panels, drawn, strict=True):
        lines = lines_of(ax)
        assert list(lines) == ["0", "1", "2"]
        for goal, line in enumerate(lines.values()):
            np.testing.assert_array_equal(line.get_xdata(), interaction.time)
            np.testing.assert_array_equal(line.get_ydata(), values[:, goal])
            assert to_hex(line.get_color()).upper() == goal_colour_among_agents(goal)
    assert panels[-1].get_xlabel() == "time [s]"
    assert paths.get_title(loc="left") == "trial scene-1"
    panels[0].figure.canvas.draw()


def test_the_panel_of_paths_is_a_square_that_they_fill(interaction):
    ax = plot_conditional_belief(interaction)[-1]
    points = np.concatenate([interaction.position.reshape(-1, 2), interaction.places.reshape(-1, 2)])
    span = np.ptp(points, axis=0).max()
    ax.figure.canvas.draw()
    for low, high in (ax.get_xlim(), ax.get_ylim()):
        assert span < high - low < 1.3 * span


def test_a_goals_label_stands_clear_of_who_is_at_the_goal():
    ax = new_axes()
    at_goal = np.array([[0.15, 0.2], [8.0, 8.0]])
    draw_goals(ax, np.array([[0.0, 0.0], [5.0, 0.0]]), ("cup", "pan"), among=at_goal)
    first, second = ax.texts
    assert first.get_position() == (-9, -9)
    assert second.get_position() == (9, 9)


def test_the_sizes_of_a_learning_curve_are_labelled_where_there_is_room():
    rows = example_learning_rows()
    ax = plot_learning_curve(rows)
    ax.figure.canvas.draw()
    learned = {row.examples for row in rows if row.prediction == "learned"}
    shown = [label.get_text() for label in ax.get_xticklabels()]
    assert 1 <= len(shown) <= 5
    assert {int(text.replace(",", "")) for text in shown} <= learned
    assert f"{max(learned):,}" in shown
    assert all(label.get_text() == "" for label in ax.get_xticklabels(minor=True))


def test_strips_have_the_colours_of_the_humans_and_the_robots_goals(interaction):
    panel = plot_conditional_belief(interaction)[1]
    below, above = (
        [
            (patch.get_x(), patch.get_width(), to_hex(patch.get_facecolor()).upper())
            for patch in panel.patches
            if (patch.get_y() > 0.5) == up
        ]
        for up in (False, True)
    )
    turn, end = interaction.time[9], interaction.time[-1]
    assert below == [
        (0.0, pytest.approx(turn), goal_colour_among_agents(1)),
        (pytest.approx(turn), pytest.approx(end - turn), goal_colour_among_agents(0)),
    ]
    assert above == [(0.0, pytest.approx(end), goal_colour_among_agents(1))]


def test_paths_are_those_of_both_agents_and_collisions_lie_between_them(interaction):
    lines = lines_of(plot_conditional_belief(interaction)[-1])
    for agent, (name, colour) in enumerate((("human", HUMAN_COLOUR), ("robot", ROBOT_COLOUR))):
        np.testing.assert_array_equal(lines[name].get_xydata(), interaction.position[:, agent])
        assert lines[name].get_color() == colour
    np.testing.assert_allclose(lines["collision"].get_xydata(), interaction.position[[7]].mean(axis=1))


def test_goals_that_are_absent_and_agents_out_of_sight_leave_gaps(interaction):
    places, position = interaction.places.copy(), interaction.position.copy()
    places[10:, 2], position[:5, 0] = np.nan, np.nan
    gap = replace(interaction, places=places, position=position, headings=(), live={})
    *panels, paths = plot_conditional_belief(gap)
    assert len(panels) == 3
    assert np.isnan(lines_of(panels[0])["2"].get_ydata()[10:]).all()
    np.testing.assert_array_equal(lines_of(paths)["human"].get_xydata(), position[5:, 0])


def test_names_from_a_log_are_text_and_not_mathematics(interaction):
    names = {"goals": ("$x", "a_$b$", "^"), "trial_id": "$t$", "agent": "$a", "partner": "_r$"}
    axes = plot_conditional_belief(replace(interaction, **names))
    axes[0].figure.canvas.draw()
    assert axes[-1].get_title(loc="left") == "trial $t$"


def test_it_is_drawn_on_the_figure_that_is_given(interaction):
    figure = Figure(layout="constrained")
    assert {ax.figure for ax in plot_conditional_belief(interaction, figure=figure)} == {figure}


def test_positions_on_a_line_have_no_paths(interaction):
    with pytest.raises(LogError, match="two coordinates"):
        plot_conditional_belief(
            replace(
                interaction,
                **{name: getattr(interaction, name)[..., :1] for name in ("position", "velocity", "places")},
            )
        )


def test_a_risk_map_shows_its_numbers_where_they_belong():
    human = Mover(point_agent(), np.zeros(4), np.array([[4.0, 0.0, 0.0, 0.0]]), np.array([1.0]))
    risk = risk_map(
        point_agent(),
        np.array([0.0, 4.0]),
        (human,),
        bounds=(-2.0, 6.0, -4.0, 4.0),
        cells=17,
        rollouts=20,
        rng=np.random.default_rng(0),
    )
    ax = plot_risk_map(risk, goals=np.array([[0.0, 4.0], [4.0, 0.0]]), labels=("cup", "pan"))
    (image,) = ax.images
    np.testing.assert_array_equal(image.get_array(), risk.probability)
    assert image.get_extent() == [-2.25, 6.25, -4.25, 4.25]
    assert image.origin == "lower"
    lines = lines_of(ax)
    assert lines["human"].get_xydata().tolist() == [[0.0, 0.0]]
    assert lines["target"].get_xydata().tolist() == [[0.0, 4.0]]
    # on the human's way it is sure to happen, behind it never
    assert risk.probability[8, 4] == 1.0
    assert risk.probability[0, 0] == 0.0
    ax.figure.canvas.draw()


def test_candidates_are_drawn_as_safe_or_unsafe_and_the_chosen_one_on_top(paths):
    safe = paths.candidates.safe
    assert 0 < safe.sum() < len(safe)
    ax = plot_candidates(paths)
    drawn = {
        name: [line for line in ax.lines if line.get_label().lstrip("_") == name]
        for name in ("safe", "unsafe", "chosen")
    }
    assert {name: len(lines) for name, lines in drawn.items()} == {
        "safe": safe.sum(),
        "unsafe": (~safe).sum(),
        "chosen": 1,
    }
    for line, candidate in zip(drawn["unsafe"], np.flatnonzero(~safe), strict=True):
        np.testing.assert_array_equal(line.get_xydata(), paths.candidates.positions[candidate])
    (chosen,) = drawn["chosen"]
    np.testing.assert_array_equal(chosen.get_xydata(), paths.candidates.positions[paths.choice.plan])
    np.testing.assert_array_equal(lines_of(ax)["synthetic obstacles"].get_xydata(), paths.obstacles)
    assert ax.get_title(loc="left").startswith(f"{safe.sum()} of 65 candidates safe; ")
    # one set of circles for each mode: 10 % is a mode, too
    assert len(ax.patches) == 3 * 5


def test_the_obstacles_are_those_that_spread_the_candidates_out(paths):
    # an obstacle right beside the robot pushes its candidate away from itself
    start = paths.candidates.positions[0, 0]
    away = paths.obstacles - start
    nearest = int(np.linalg.norm(away, axis=1).argmin())
    moved = paths.candidates.positions[1 + nearest, 2] - paths.candidates.positions[0, 2]
    assert moved @ away[nearest] < 0


def test_a_choice_that_is_not_certified_is_red(paths):
    flagged = replace(paths, choice=replace(paths.choice, flagged=True))
    assert lines_of(plot_candidates(flagged))["chosen, not certified"].get_color() == "#B22222"


def test_the_dots_of_games_are_the_numbers_of_their_table():
    cells = [
        {
            "robot": robot,
            "human": human,
            **{name: base + 0.1 * at for at, name in enumerate(GAME_LABELS)},
            **{f"{name}_sem": 0.5 for name in GAME_LABELS},
        }
        for base, (robot, human) in enumerate(
            [("naive", "moving"), ("naive", "stubborn"), ("$own", "moving"), ("$own", "stubborn")]
        )
    ]
    axes = plot_game_performance(cells)
    axes[0].figure.canvas.draw()
    assert [label.get_text() for label in axes[0].get_yticklabels()] == ["naive", "$own"]
    for ax, at in zip(axes, (0, 1, 2), strict=True):
        lines = lines_of(ax)
        np.testing.assert_allclose(lines["moving human"].get_xdata(), [0.1 * at, 2 + 0.1 * at])
        np.testing.assert_allclose(lines["stubborn human"].get_xdata(), [1 + 0.1 * at, 3 + 0.1 * at])
    with pytest.raises(LogError, match="unknown metric 'stops'"):
        plot_game_performance(cells, metrics=["stops"])
    with pytest.raises(LogError, match="no game to draw"):
        plot_game_performance([])
    several = plot_game_performance([{**cell, "goals": goals} for cell in cells[:1] for goals in (3, 5)])
    assert [label.get_text() for label in several[0].get_yticklabels()] == [
        "naive, 3 goals",
        "naive, 5 goals",
    ]
