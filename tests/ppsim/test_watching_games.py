"""A reaching game as a moving picture, from its log."""

import numpy as np
import pytest
from PIL import Image

from ppinfer.errors import LogError
from ppinfer.studies import infer_log_conditional, select_trials, write_log
from ppinfer.testing import example_interaction_log, example_log
from ppsim.cli import main
from ppsim.errors import SimulationError
from ppsim.one_trial import one_trial
from ppsim.reaching import GameStudy
from ppsim.reaching.game_picture import GamePicture
from ppsim.reaching.watching import draw_game, held_live, paths_at, read_game, scores_of
from ppsim.study import log_of_study

ROBOTS = ("naive", "expected-cost")


@pytest.fixture(scope="module")
def log():
    study = GameStudy(robots=ROBOTS, humans=("stubborn",), seed=3, duration=5.0, goals=(4,))
    return log_of_study(study, range(study.trials))


@pytest.fixture(scope="module")
def game(log):
    return one_trial(log, "game-0/4-goals/expected-cost/stubborn")


def dots_in(picture, colour):
    """Return how many dots of a picture have about this colour."""
    rgb = np.array([int(colour[at : at + 2], 16) for at in (1, 3, 5)])
    return int((np.abs(picture.pixels().astype(int) - rgb).max(axis=-1) <= 8).sum())


def test_beliefs_inferred_from_the_log_are_those_that_the_robot_held(game):
    beliefs = infer_log_conditional(game)
    for inferred, live in (
        ("log_belief", "live_log_belief"),
        ("log_mental_model", "live_log_mental_model"),
        ("log_given", "live_log_post"),
    ):
        np.testing.assert_allclose(
            np.exp(beliefs[inferred].values), np.exp(game[live].values), atol=1e-10, err_msg=live
        )


def test_a_naive_robots_picture_shows_what_it_held_and_not_what_it_might_have(log):
    naive = one_trial(log, "game-0/4-goals/naive/stubborn")
    shown = held_live(naive, read_game(naive))
    np.testing.assert_array_equal(shown["given"], np.exp(naive["live_log_post"].values))
    np.testing.assert_allclose(shown["given"], shown["belief"], atol=1e-12)


def test_the_score_ends_at_the_teams(log):
    for trial in range(log.sizes["trial"]):
        one = select_trials(log, [trial])
        assert scores_of(one)[-1] == one["team_score"].values[0]


def test_trajectories_begin_at_the_robot_and_are_the_same_whenever_they_are_made(game):
    read = read_game(game)
    first, again = paths_at(read, 7), paths_at(read, 7)
    assert first.goal == read.partner_goal[7]
    np.testing.assert_array_equal(first.candidates.states, again.candidates.states)
    np.testing.assert_array_equal(
        first.candidates.positions[:, 0], np.tile(read.position[7, 1], (len(first.candidates), 1))
    )
    assert first.choice.plan == again.choice.plan


def test_a_robot_that_waits_has_no_trajectories():
    log = example_interaction_log(trials=1)
    log["pursued"].values[:5, 1] = -1
    assert paths_at(read_game(log), 4) is None
    picture = GamePicture(log)
    picture.show(4)
    assert picture.pixels().shape == (720, 960, 3)


def test_a_picture_depends_on_the_sample_and_not_on_what_was_shown_before(game):
    one, other = GamePicture(game), GamePicture(game)
    for sample in (40, 3, 12):
        one.show(sample)
    other.show(12)
    assert np.array_equal(one.pixels(), other.pixels())
    one.show(13)
    assert not np.array_equal(one.pixels(), other.pixels())


def test_bars_are_as_high_as_the_beliefs(game):
    picture = GamePicture(game)
    picture.show(20)
    for bars, name in ((picture._belief, "belief"), (picture._mind, "mental_model")):
        heights = [bar.get_height() / 0.88 for bar in bars]
        np.testing.assert_allclose(heights, picture.beliefs[name][20], atol=1e-12)
    rows = [[bar.get_height() / 0.88 for bar in bars] for bars in picture._post]
    np.testing.assert_allclose(rows, picture.game.post[20], atol=1e-12)
    framed = [row for row, frame in enumerate(picture._rows) if frame.get_visible()]
    assert framed == [picture.game.partner_goal[20]]


def test_goals_that_a_game_does_not_have_get_no_bars():
    log = log_of_study(GameStudy(robots=("influence",), humans=("moving",), goals=(3, 5), duration=1.0), [0])
    picture = GamePicture(log)
    assert (len(picture.game.goals), len(picture._belief), len(picture._mind)) == (5, 3, 3)
    assert [len(bars) for bars in picture._post] == [3, 3, 3]
    picture.show(4)
    heights = [bar.get_height() / 0.88 for bar in picture._belief]
    assert sum(heights) == pytest.approx(1.0)
    assert [tick.get_text() for tick in picture.figure.axes[1].get_xticklabels()] == ["0", "1", "2"]


def test_of_a_robot_of_ones_own_the_picture_has_what_it_held_and_nothing_else(game):
    own = game.copy(deep=True)
    names = own["controller"].values.astype(object)
    names[names == "expected-cost"] = "mine:Robot"
    own["controller"] = (own["controller"].dims, names)
    own["live_log_post"].values[:] = np.log(0.25)
    read = read_game(own)
    goal = int(read.partner_goal[7])
    np.testing.assert_allclose(read.post[7, goal], 0.25)
    assert np.isnan(np.delete(read.post[7], goal, axis=0)).all()
    assert paths_at(read, 7).goal == goal
    picture = GamePicture(own)
    picture.show(7)
    rows = [[bar.get_height() / 0.88 for bar in bars] for bars in picture._post]
    np.testing.assert_allclose(rows, np.where(np.eye(4)[goal], 0.25, 0.0)[:, None].repeat(4, axis=1))


def test_a_collision_is_counted_and_red_for_a_while():
    log = example_interaction_log(trials=1)
    log["collision"] = ("sample", (np.arange(30) == 10).astype(np.int8))
    picture = GamePicture(log)
    reds = []
    for sample in (9, 10, 20):
        picture.show(sample)
        reds.append(dots_in(picture, "#B22222"))
    assert reds[1] > reds[0] + 5000
    assert abs(reds[2] - reds[0]) < 3000
    assert picture._count.get_text() == "0 points, 1 collision"


def test_a_gif_has_a_frame_a_sample_and_tells_how_far_it_is(game, tmp_path):
    short = game.isel(sample=slice(0, 6))
    short["row_size"] = short["row_size"] * 0 + 6
    short = short.isel(segment=slice(0, 0))
    told = []
    draw_game(short, tmp_path / "game.gif", progress=lambda done, total: told.append((done, total)))
    with Image.open(tmp_path / "game.gif") as image:
        assert (image.n_frames, image.size, image.info["duration"]) == (6, (960, 720), 100)
    assert told == [(number, 6) for number in range(1, 7)]


def test_a_game_is_drawn_from_a_log_or_played(game, tmp_path, capsys, monkeypatch):
    monkeypatch.setattr("ppsim.reaching.game_picture.GamePicture.show", lambda self, sample: None)
    write_log(game, tmp_path / "log.nc")
    assert main(["watch", "reaching", "--log", str(tmp_path / "log.nc")]) == 0
    assert (tmp_path / "log.gif").stat().st_size > 1000
    assert "log.gif: game-0/4-goals/expected-cost/stubborn, 4.9 s, " in capsys.readouterr().out
    out = tmp_path / "played.gif"
    argv = ["--seed", "3", "--robot", "naive", "--human", "waiting", "--duration", "0.5", "-o", str(out)]
    assert main(["watch", "reaching", *argv]) == 0
    assert "game-0/3-goals/naive/waiting, 0.4 s, 0 points, 0 collisions" in capsys.readouterr().out


def test_what_cannot_be_drawn_is_one_clear_error(log, game, tmp_path):
    with pytest.raises(LogError, match="expected the log of one game; this one holds 2 trials"):
        read_game(log)
    with pytest.raises(LogError, match="no log of a game among goals"):
        read_game(one_trial(log).drop_vars("goal_position"))
    with pytest.raises(LogError, match="need one beside 'human'"):
        read_game(example_log(participants=1, trials=1))
    with pytest.raises(SimulationError, match=r"must end in .gif or .mp4"):
        draw_game(game, tmp_path / "game.avi")
