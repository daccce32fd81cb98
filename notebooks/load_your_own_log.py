# ---
# jupyter:
#   jupytext:
#     text_representation:
#       extension: .py
#       format_name: percent
#   kernelspec:
#     display_name: Python 3
#     language: python
#     name: python3
# ---

# %% [markdown]
# # Load your own log
#
# **Your table has columns of your own. What does it take to get from it to posteriors that you can trust?**
#
# A few lines that say which column is what. The table below stands in for yours: six people go for goals in a
# room, in centimetres and milliseconds, and a position is left empty where the tracker lost somebody.

# %%
from pathlib import Path
from tempfile import mkdtemp

import matplotlib.pyplot as plt
import numpy as np
import pandas as pd

from ppinfer.goals import GoalLQR, NearestGoal
from ppinfer.plots import explore_goals, plot_participants, plot_reliability, plot_score_over_share
from ppinfer.studies import (
    FaultyLogError,
    calibrate_posterior,
    fit_study,
    infer_log,
    read_log,
    read_tidy,
    score_posterior,
)

plt.rcParams["figure.dpi"] = 100
FOLDER = Path(mkdtemp())


def somebodys_table():
    """Return a table as another laboratory might keep it, made of the log that ships with ppinfer."""
    log = read_log("../data/reaching-small.nc")
    trial = np.repeat(np.arange(log.sizes["trial"]), log.row_size)
    place = 100 * log.position.sel(agent="human").values
    table = {"session": log.trial_id.values[trial], "subj": log.participant.values[trial]}
    table |= {"t_ms": (1000 * log.time.values).round(1), "pos_x": place[:, 0], "pos_y": place[:, 1]}
    for goal, name in enumerate(("cup", "pan", "jar", "lid")):
        table |= {f"{name}_{axis}": 100 * log.goal_position.values[:, goal, k] for k, axis in enumerate("xy")}
    table["goes_for"] = np.full(len(trial), "", dtype=object)
    mine = log.segment_agent.values == "human"
    first = (np.cumsum(log.row_size.values) - log.row_size.values)[log.segment_trial.values]
    for begin, end, goal in zip(
        (first + log.segment_start.values)[mine],
        (first + log.segment_stop.values)[mine],
        log.true_goal.values[mine].astype(int),
        strict=True,
    ):
        table["goes_for"][begin:end] = ("cup", "pan", "jar", "lid")[goal]
    return pd.DataFrame(table).round(2)


table = somebodys_table()
table.to_csv(FOLDER / "study.csv", index=False)
table.head(3)

# %% [markdown]
# ## The mapping
#
# Nothing about your columns is guessed. On the left is what ppinfer calls it, on the right your column.

# %%
MAPPING = """
missing = "dropout"          # an empty position: the tracker lost them
constants = {agent = "human"}
units = {time = "ms", position = "cm"}

[columns]
trial = "session"
participant = "subj"
time = "t_ms"
x = "pos_x"
y = "pos_y"
true_goal = "goes_for"       # for scores: runs of one label are segments

[goal_columns]               # goals that move; those that stand still are [goals], with numbers
cup = {x = "cup_x", y = "cup_y"}
pan = {x = "pan_x", y = "pan_y"}
jar = {x = "jar_x", y = "jar_y"}
lid = {x = "lid_x", y = "lid_y"}
"""
(FOLDER / "mapping.toml").write_text(MAPPING)
log = read_tidy(FOLDER / "study.csv", FOLDER / "mapping.toml")
log[["time", "position", "observed", "goal_position", "row_size", "participant", "true_goal"]].drop_attrs()

# %% [markdown]
# A log is one `xarray.Dataset`, in metres and seconds. And this is the answer for one of its trials: drag
# `seen` to replay it, and the parameters to see what they do.

# %%
first_guess = GoalLQR(control_weight=10.0, rationality=0.002, stay=0.98)
explore_goals(log, "p4-3", first_guess, seen=19.0)

# %% [markdown]
# ## What is wrong with it?
#
# A table with faults is refused, with all faults at once, each with its line and column.

# %%
broken = table.astype({"pos_x": object})
broken.loc[7, "pos_x"], broken.loc[30, "t_ms"] = "12,5", 0.0
broken.to_csv(FOLDER / "broken.csv", index=False)
try:
    read_tidy(FOLDER / "broken.csv", FOLDER / "mapping.toml")
except FaultyLogError as error:
    print("\n".join(error.lines))

# %% [markdown]
# ## Do the probabilities mean what they say?
#
# `fit_study` tunes the model so that the true goals get as much probability as possible. With `folds`, each
# third of the participants is predicted by a fit to the others: these are the numbers to believe.

# %%
fitted = fit_study(log, GoalLQR(), folds=3)
posteriors = {
    "nearest goal": infer_log(log, NearestGoal()),
    "first guess": infer_log(log, first_guess),
    "fitted, people left out": fitted.held_out_posterior,
}
fig, axes = plt.subplots(1, 3, figsize=(12, 3.6), layout="constrained")
for (name, posterior), colour in zip(posteriors.items(), ("#999999", "#E69F00", "#0072B2"), strict=True):
    scores = score_posterior(posterior, at=np.linspace(0.05, 1, 20)).overall
    plot_score_over_share(scores, label=name, colour=colour, ax=axes[0])
axes[0].legend(frameon=False, loc="lower right", fontsize="small")
plot_reliability(calibrate_posterior(fitted.held_out_posterior).top_label, ax=axes[1])
_ = plot_participants(score_posterior(fitted.held_out_posterior, at=[0.25]).by_participant, ax=axes[2])

# %%
rows = {
    name: {
        f"{score.at:.0%} of the way": f"{score.accuracy:.3f} / {score.mean_log_posterior:.2f}"
        for score in score_posterior(each).overall
    }
    for name, each in posteriors.items()
}
pd.DataFrame(rows).T.rename_axis("accuracy / mean log posterior of the true goal [nat]")

# %% [markdown]
# Left: how often the most probable goal is the true one, over the share of each way there that was seen
# (bands: one standard error over participants). Middle: of all the times that the fitted model said "80 %",
# was it right 80 % of the time? Right: whom it reads well after a quarter of the way.
#
# ## Where to go next
#
# - The same from the terminal: `ppinfer convert study.csv -o LOG.nc --from tidy --mapping mapping.toml`, then
#   `ppinfer validate`, `fit`, `infer`, `score` and `report`; each has `--help`.
# - What can be moved, and what it means: [Explore a posterior](explore_a_posterior.py).
