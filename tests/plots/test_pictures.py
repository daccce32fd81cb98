import numpy as np
import pytest
from matplotlib.colors import to_hex

from ppinfer.errors import LogError
from ppinfer.plots import (
    plot_participants,
    plot_path,
    plot_posterior_over_time,
    plot_reliability,
    plot_score_over_share,
)
from ppinfer.plots.palette import goal_colour
from ppinfer.studies.calibration import calibrate_posterior
from ppinfer.studies.posterior import open_posterior, write_posterior
from ppinfer.studies.scores import score_posterior

from ..studies.posteriors import make_posterior


@pytest.fixture
def posterior():
    return make_posterior(outliers=True)


def test_every_picture_labels_its_axes_and_draws(posterior):
    scores = score_posterior(posterior, at=np.linspace(0.1, 1, 10).tolist())
    pictures = [
        plot_posterior_over_time(posterior, "t1"),
        plot_path(posterior, 1),
        plot_reliability(calibrate_posterior(posterior).top_label),
        plot_score_over_share(scores.overall, "accuracy", chance=1 / 3),
        plot_score_over_share(scores.overall, "mean_log_posterior"),
        plot_participants([each for each in scores.by_participant if each.at == 0.1]),
    ]
    for ax in pictures:
        ax.figure.canvas.draw()
        assert ax.get_xlabel()
        assert ax.get_ylabel()
        assert ax.figure.canvas.manager is None  # no global state holds on to it
    assert pictures[0].get_xlabel() == "time [s]"
    assert pictures[1].get_xlabel() == "x [m]"


def test_pictures_are_drawn_on_given_axes(posterior):
    ax = plot_path(posterior, "t0")
    assert plot_posterior_over_time(posterior, "t0", ax=ax) is ax


def test_the_lines_over_time_are_the_probabilities_of_the_trial(posterior):
    ax = plot_posterior_over_time(posterior, "t1")
    for goal in range(3):
        (line,) = [each for each in ax.lines if each.get_label() == f"goal {goal}"]
        np.testing.assert_array_equal(line.get_xdata(), posterior["time"].values[30:55])
        np.testing.assert_allclose(line.get_ydata(), np.exp(posterior["log_posterior"].values[30:55, goal]))
        assert line.get_color() == goal_colour(goal)


def test_the_strip_shows_segments_in_the_colour_of_their_true_goal(posterior):
    ax = plot_posterior_over_time(posterior, "t1")
    true = [int(goal) for goal in posterior["true_goal"].values[2:4]]
    assert [to_hex(patch.get_facecolor()).upper() for patch in ax.patches] == [
        goal_colour(goal) for goal in true
    ]


def test_the_path_is_drawn_at_the_seen_positions(posterior):
    ax = plot_path(posterior, "t2")
    position = posterior["position"].values[55:95]
    seen = position[~np.isnan(position).any(axis=1)]
    np.testing.assert_array_equal(ax.collections[0].get_offsets(), seen)


def test_a_picture_of_a_file_reads_one_trial(tmp_path, posterior):
    write_posterior(posterior, tmp_path / "p.nc")
    with open_posterior(tmp_path / "p.nc") as lazy:
        ax = plot_posterior_over_time(lazy, "t1")
    np.testing.assert_array_equal(ax.lines[0].get_xdata(), posterior["time"].values[30:55])


def test_absent_goals_have_no_line(posterior):
    posterior["goal_position"].values[:, 2] = np.nan
    posterior["goal_present"].values[:, 2] = 0
    posterior["log_posterior"].values[:] = [np.log(0.5), np.log(0.5), -np.inf]
    labels = [line.get_label() for line in plot_posterior_over_time(posterior, "t1").lines]
    assert "goal 1" in labels
    assert "goal 2" not in labels


@pytest.mark.filterwarnings("ignore:Glyph")
@pytest.mark.parametrize("name", ["$x^{$", "<script>", "a_b^c", "\\frac", "名前"])
def test_labels_from_a_log_are_text_and_never_mathematics(posterior, name):
    posterior["trial_id"].values[1] = name
    posterior["participant"].values[1] = name
    posterior = posterior.assign_coords(goal=np.array([name, "1", "2"], dtype=object))
    posterior["true_goal"].values[:] = name
    scores = score_posterior(posterior, at=[0.5])
    axes = [
        plot_posterior_over_time(posterior, name),
        plot_path(posterior, name),
        plot_participants(scores.by_participant),
    ]
    for ax in axes:
        ax.figure.canvas.draw()


def test_one_sample_and_a_trial_never_seen_are_drawn():
    posterior = make_posterior(row_sizes=(1, 5), participants=("p", "p"), segments_per_trial=0)
    posterior["observed"].values[:] = 0
    posterior["position"].values[:] = np.nan
    for trial in ("t0", "t1"):
        plot_posterior_over_time(posterior, trial).figure.canvas.draw()
        plot_path(posterior, trial).figure.canvas.draw()


def test_infinite_scores_are_said_not_drawn(posterior):
    posterior["true_goal"].values[:] = "1"
    posterior["log_posterior"].values[:] = [0, -np.inf, -np.inf]
    scores = score_posterior(posterior, at=[0.5, 1.0])
    ax = plot_score_over_share(scores.overall, "mean_log_posterior")
    assert "2 shares at -inf are not drawn" in [text.get_text() for text in ax.texts]
    ax = plot_participants(scores.by_participant[:3], "mean_log_posterior")
    assert [text.get_text() for text in ax.texts] == ["-inf"] * 3
    ax.figure.canvas.draw()


def test_many_participants_are_counted_instead_of_named():
    people = tuple(f"p{i}" for i in range(60))
    scores = score_posterior(make_posterior(row_sizes=(10,) * 60, participants=people), at=[0.5])
    assert plot_participants(scores.by_participant).get_ylabel() == "60 participants, sorted"


def test_unknown_trials_are_refused_by_name(posterior):
    with pytest.raises(LogError, match="unknown trial 't9'; the posterior has 4: 't0', 't1', 't2', 't3'"):
        plot_path(posterior, "t9")
    with pytest.raises(LogError, match="trial 4 of 4"):
        plot_path(posterior, 4)


def test_a_path_on_a_line_is_refused(posterior):
    with pytest.raises(LogError, match="two coordinates"):
        plot_path(posterior.isel(space=[0]), "t0")
