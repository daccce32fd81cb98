"""A trial as a moving picture, from its log."""

from __future__ import annotations

import sys

import numpy as np
import pytest
from PIL import Image

from ppinfer.errors import LogError
from ppinfer.studies import select_trials
from ppinfer.testing import example_log
from ppsim.arms.recorded import read_recorded
from ppsim.arms.study import ArmsStudy
from ppsim.arms.trial_picture import TrialPicture
from ppsim.arms.watching import draw_trial
from ppsim.errors import SimulationError
from ppsim.one_trial import one_trial
from ppsim.study import log_of_study
from ppsim.video import write_video


@pytest.fixture(scope="module")
def log():
    return log_of_study(ArmsStudy(scenes=1, robots=("bayes", "norm"), humans=("selfish",), seed=4), [0, 1])


@pytest.fixture(scope="module")
def trial(log):
    return read_recorded(one_trial(log))


@pytest.fixture
def stopped(log):
    """A trial in which a safety stop holds both arms at the third sample."""
    one = one_trial(log).copy(deep=True)
    one["held"].values[2] = 1
    return read_recorded(one)


def test_objects_lie_at_their_pick_are_carried_and_end_at_their_place(trial):
    last = len(trial.time) - 1
    for agent in range(2):
        picked = trial.picked[agent]
        assert 0 < picked < last
        assert np.array_equal(trial.object_at(agent, 0), trial.task[agent, 0])
        carried = trial.object_at(agent, picked + 2)
        assert np.allclose(carried, trial.arms[agent].end_effector(trial.joints[picked + 2, agent]))
        if np.isnan(trial.joints[last, agent]).any():
            assert np.array_equal(trial.object_at(agent, last), trial.task[agent, 1])


def test_paths_of_plans_begin_at_the_arm_and_end_at_the_place_but_for_the_one_that_stays(trial):
    first, sample = trial.paths[0], trial.replan_sample[0]
    for agent in range(2):
        tip = trial.arms[agent].end_effector(trial.joints[sample, agent])
        assert all(np.allclose(path[0], tip, atol=1e-6) for path in first[agent])
        assert all(np.allclose(path[-1], trial.task[agent, 1], atol=1e-6) for path in first[agent][:-1])
        assert len(first[agent][-1]) == 1


def test_the_replan_that_holds_is_the_last_one_by_then(trial):
    second = int(trial.replan_sample[1])
    assert [trial.replan_at(sample) for sample in (0, second - 1, second)] == [0, 0, 1]


def test_a_safety_stop_is_red_counted_and_fades(stopped):
    picture = TrialPicture(stopped)

    def red(sample):
        picture.show(sample)
        image = picture.pixels().astype(int)
        return int(((image[..., 0] > 150) & (image[..., 1] < 60) & (image[..., 2] < 60)).sum())

    at_all, then, later = red(1), red(2), red(10)
    assert then > at_all + 2000
    # the marks on the time line and the count stay
    assert at_all < later < then
    assert stopped.stops[[1, 2, 10]].tolist() == [0, 1, 1]


def test_a_picture_depends_on_the_sample_and_not_on_what_was_shown_before(trial):
    one, other = TrialPicture(trial), TrialPicture(trial)
    for sample in (40, 3, 12):
        one.show(sample)
        one.pixels()
    other.show(12)
    assert np.array_equal(one.pixels(), other.pixels())
    one.show(13)
    assert not np.array_equal(one.pixels(), other.pixels())


def test_a_robot_without_a_belief_is_drawn_too(log):
    picture = TrialPicture(read_recorded(one_trial(log, "scene-0/shared/norm/selfish")))
    picture.show(5)
    assert picture.pixels().shape == (720, 960, 3)


def test_a_gif_has_a_frame_a_sample_and_tells_how_far_it_is(log, tmp_path):
    short = one_trial(log).isel(sample=slice(0, 12))
    short = short.isel(replan=short.replan_sample.values < 12)
    plans = int(short.plan_row_size.values.sum())
    short = short.isel(plan=slice(0, plans))
    told = []
    draw_trial(short, tmp_path / "trial.gif", progress=lambda done, total: told.append((done, total)))
    with Image.open(tmp_path / "trial.gif") as image:
        assert (image.n_frames, image.size, image.info["duration"]) == (12, (960, 720), 100)
    assert told == [(number, 12) for number in range(1, 13)]


def test_a_stop_is_red_in_a_gif_though_nothing_red_is_in_its_first_frame(tmp_path):
    red = (213, 40, 20)
    frames = [np.full((48, 64, 3), 250, np.uint8) for _ in range(2)]
    frames[0][:24] = np.arange(64, dtype=np.uint8)[None, :, None] * 3
    frames[1][10:20] = red
    write_video(tmp_path / "trial.gif", frames, fps=10, colours=[red])
    with Image.open(tmp_path / "trial.gif") as image:
        image.seek(1)
        assert image.convert("RGB").getpixel((5, 15)) == red


def test_the_gif_of_a_trial_has_the_colour_of_its_stops(log, tmp_path):
    one = one_trial(log).copy(deep=True)
    one["held"].values[2] = 1
    short = one.isel(sample=slice(0, 6))
    short = short.isel(replan=short.replan_sample.values < 6)
    short = short.isel(plan=slice(0, int(short.plan_row_size.values.sum())))
    draw_trial(short, tmp_path / "trial.gif")
    with Image.open(tmp_path / "trial.gif") as image:
        image.seek(2)
        shown = np.asarray(image.convert("RGB")).astype(int)
    assert ((shown[..., 0] > 150) & (shown[..., 1] < 60) & (shown[..., 2] < 60)).sum() > 2000


def test_an_mp4_is_written_where_ffmpeg_is_there(tmp_path):
    pytest.importorskip("imageio_ffmpeg")
    frames = (np.full((48, 64, 3), shade, np.uint8) for shade in (0, 100, 200))
    write_video(tmp_path / "trial.mp4", frames, fps=10)
    assert (tmp_path / "trial.mp4").stat().st_size > 500


def test_an_mp4_without_ffmpeg_is_refused_in_one_line_before_anything_is_drawn(log, tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "imageio_ffmpeg", None)
    with pytest.raises(SimulationError, match=r"install ppinfer\[video\]") as refused:
        draw_trial(one_trial(log), tmp_path / "trial.mp4")
    assert "\n" not in str(refused.value)
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("name", ["trial.avi", "nowhere/trial.gif"])
def test_names_that_cannot_be_written_are_refused(log, tmp_path, name):
    with pytest.raises(SimulationError, match=r"ends? in \.gif or \.mp4|no folder"):
        draw_trial(one_trial(log), tmp_path / name)


def test_logs_of_something_else_and_unknown_trials_are_refused(log):
    with pytest.raises(LogError, match="no log of two arms"):
        read_recorded(example_log(participants=1, trials=1))
    with pytest.raises(LogError, match="holds 2"):
        read_recorded(select_trials(log, [0, 1]))
    with pytest.raises(LogError, match="has no trial 'x'; it holds 2: 'scene-0/shared/bayes/selfish'"):
        one_trial(log, "x")
