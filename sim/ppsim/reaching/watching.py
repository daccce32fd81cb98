"""A game of the reaching world as a moving picture, from its log alone."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np
import xarray as xr
from jaxtyping import Float, Int

from ppinfer.errors import LogError
from ppinfer.studies import infer_log_conditional
from ppinfer.studies.assumed_reactions import robots_of_ones_own
from ppinfer.studies.conditional_beliefs import other_agent
from ppinfer.studies.interaction import Interaction, Stretch, read_interaction
from ppinfer.studies.interaction_safety import CandidatePaths, candidate_paths, situation_at
from ppinfer.studies.log_inference import default_agent
from ppinfer.studies.progress import ProgressCallback, silent

# rollouts that the trajectory of a frame is chosen by; a frame claims nothing
_ROLLOUTS = 200


def read_game(log: xr.Dataset) -> Interaction:
    """Read a log of one game: who was where, and the beliefs at every sample.

    Of a robot of one's own the log holds no conditional, but what it held live given its goal: of ``post`` only that
    row is there then, and NaN elsewhere.

    Parameters
    ----------
    log : xarray.Dataset
        Of one trial of two agents among goals in the plane; see `ppsim.one_trial.one_trial`.

    Raises
    ------
    LogError
        If the log holds another number of trials, has no goals or not two agents in the plane.

    Examples
    --------
    >>> from ppinfer.testing import example_interaction_log
    >>> read_game(example_interaction_log(trials=1)).trial_id
    'scene-0'
    """
    if log.sizes.get("trial", 0) != 1:
        raise LogError(f"expected the log of one game; this one holds {log.sizes.get('trial', 0)} trials")
    if "goal_position" not in log or log.sizes["space"] != 2:
        raise LogError(
            "this is no log of a game among goals in the plane: ppsim reach and ppsim record do them"
        )
    agent = default_agent(log)
    other_agent(log, agent)
    here = log.load()
    game = read_interaction(
        here, infer_log_conditional(here, agent=agent), Stretch(0, 0, here.sizes["sample"])
    )
    if "live_log_post" in here and robots_of_ones_own(here, game.partner):
        game = _as_held(game, np.exp(here["live_log_post"].values))
    return game


def _as_held(game: Interaction, given: Float[np.ndarray, "sample goal"]) -> Interaction:
    """Return the game with the b_post that the robot held: one row at each sample; NaN where it is not known."""
    post = np.full_like(game.post, np.nan)
    going = np.flatnonzero(game.partner_goal >= 0)
    post[going, game.partner_goal[going]] = given[going]
    return replace(game, post=post, given=given)


def scores_of(log: xr.Dataset, points: int = 2) -> Int[np.ndarray, " sample"]:
    """Return the team's score at every sample of the log of one game; zeros where it has none.

    Parameters
    ----------
    log : xarray.Dataset
        Of one game.
    points : int
        What a score counts where the log does not tell its total.

    Examples
    --------
    >>> from ppinfer.testing import example_interaction_log
    >>> int(scores_of(example_interaction_log(trials=1)).max())
    0
    """
    if "scored" not in log:
        return np.zeros(log.sizes["sample"], np.int64)
    times: Int[np.ndarray, " sample"] = np.cumsum(log["scored"].values != 0)
    if "team_score" in log and times[-1]:
        points = int(log["team_score"].values[0]) // int(times[-1])
    return points * times


def held_live(log: xr.Dataset, game: Interaction) -> dict[str, Float[np.ndarray, "sample goal"]]:
    """Return the beliefs that a picture shows: those that the robot held where the log has them, or inferred ones.

    Examples
    --------
    >>> from ppinfer.testing import example_interaction_log
    >>> log = example_interaction_log(trials=1)
    >>> sorted(held_live(log, read_game(log)))
    ['belief', 'given', 'mental_model']
    """
    told = {"belief": game.belief, "mental_model": game.mental_model, "given": game.given}
    for name, variable in (
        ("belief", "live_log_belief"),
        ("mental_model", "live_log_mental_model"),
        ("given", "live_log_post"),
    ):
        if variable in log:
            told[name] = np.exp(log[variable].values)
    return told


def paths_at(game: Interaction, sample: int, *, rollouts: int = _ROLLOUTS) -> CandidatePaths | None:
    """Return the candidate trajectories to the robot's goal at a sample; None where it waits or somebody is unseen.

    The log does not hold them: they are made anew, seeded by the sample.

    Examples
    --------
    >>> from ppinfer.testing import example_interaction_log
    >>> found = paths_at(read_game(example_interaction_log(trials=1)), 4)
    >>> found.goal, len(found.candidates)
    (1, 65)
    """
    goal = int(game.partner_goal[sample])
    if goal < 0 or np.isnan(game.position[sample]).any() or np.isnan(game.places[sample, goal]).any():
        return None
    return candidate_paths(
        situation_at(game, sample), goal, game.post[sample, goal], rollouts=rollouts, seed=sample
    )


def draw_game(
    log: xr.Dataset, path: Path | str, *, fps: int = 10, progress: ProgressCallback = silent
) -> None:
    """Draw the log of one game as a GIF or an MP4, a frame a sample.

    Parameters
    ----------
    log : xarray.Dataset
        Of one game; see `ppsim.one_trial.one_trial`.
    path : path
        Ends in ``.gif``, or in ``.mp4`` (extra ``video``).
    fps : int
        Frames a second; 10 is as fast as it happened.
    progress : callable
        Is told how many frames are drawn.

    Raises
    ------
    LogError
        If the log is not of one game of two agents among goals.
    SimulationError
        If the name ends otherwise, or MP4 cannot be written.
    """
    from ppsim.reaching.game_picture import SHADES, GamePicture
    from ppsim.video import Frame, check_video_path, write_video

    target = Path(path)
    check_video_path(target)
    picture = GamePicture(log)
    samples = len(picture.game.time)

    def frames() -> Iterator[Frame]:
        for sample in range(samples):
            picture.show(sample)
            yield picture.pixels()
            progress(sample + 1, samples)

    write_video(target, frames(), fps=fps, colours=SHADES)
