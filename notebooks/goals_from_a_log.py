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
# # From a log to goal posteriors
#
# Two agents move among four goals. Which goal is each of them heading for, how soon can one tell, and do
# the probabilities mean what they say? This notebook goes the whole way from a study log to a fitted model.
# The log is `data/reaching-small.nc`, recorded by a simulation (`ppsim record reaching`), so that the truth
# is known.

# %%
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
import pandas as pd

import ppinfer
from ppinfer.goals import GoalLQR, Heading, NearestGoal
from ppinfer.plots import plot_participants, plot_path, plot_posterior_over_time, plot_reliability
from ppinfer.plots.palette import goal_colour
from ppinfer.studies import calibrate_posterior, fit_study, infer_log, read_log, score_posterior

plt.rcParams["figure.dpi"] = 110
# the log that ships with ppinfer: beside the package, or above this notebook
folders = [*Path(ppinfer.__file__).parents[:2], Path.cwd(), *Path.cwd().parents]
LOG = next(log for folder in folders if (log := folder / "data" / "reaching-small.nc").exists())

# %% [markdown]
# ## The log
#
# A log is one `xarray.Dataset`. The samples of all trials lie end to end, and `row_size` says where trials
# end; segments say when an agent was on its way to which goal. Reading checks all of it.

# %%
log = read_log(LOG)
log[["time", "position", "observed", "goal_position", "row_size", "participant", "true_goal"]]

# %% [markdown]
# One trial: both agents start at the open circles; a ring in an agent's colour marks each goal that it went
# for.

# %%
TRIAL = "p4-3"
trial = log.trial_id.values.tolist().index(TRIAL)
row = slice(log.row_size.values[:trial].sum(), log.row_size.values[: trial + 1].sum())
goals = log.goal_position.values[row.start]

fig, ax = plt.subplots(figsize=(5.4, 4.4), layout="constrained")
for agent, colour, ring in (("human", "#222222", 17), ("robot", "#999999", 22)):
    path = log.position.sel(agent=agent).values[row]
    ax.plot(*path.T, color=colour, linewidth=1.3, label=agent)
    ax.plot(*path[0], "o", markerfacecolor="white", markeredgecolor=colour)
    pursued = log.true_goal.values[(log.segment_trial.values == trial) & (log.segment_agent.values == agent)]
    ax.plot(*goals[pursued.astype(int)].T, "o", ms=ring, mfc="none", mec=colour)
for goal, place in enumerate(goals):
    ax.plot(*place, "D", color=goal_colour(goal))
    ax.annotate(f"goal {log.goal.values[goal]}", place, xytext=(12, 8), textcoords="offset points")
ax.set(xlabel="x [m]", ylabel="y [m]", aspect="equal", title=f"trial {TRIAL}")
ax.margins(0.15)
_ = ax.legend(frameon=False)

# %% [markdown]
# The robot is at goal 1 first, leaves it to the human, and waits at goal 2. After 17 s the human changes
# its mind and comes there too, so that the robot has to leave again.
#
# ## The posterior over one trial
#
# The model is a *noisily rational* agent: it steers towards its goal as a linear-quadratic regulator would,
# and a control is exponentially less likely the more it costs. Each control is evidence about the goal, and
# a goal may be given up with probability 1 - `stay` per sample. Velocities were not logged, so they are
# derived from earlier positions only.

# %%
first_guess = GoalLQR(control_weight=10.0, rationality=0.002, stay=0.98)
posterior = infer_log(log, first_guess)


def path_and_posterior(posterior, trial):
    _, (left, right) = plt.subplots(1, 2, figsize=(11, 4.2), width_ratios=[1, 1.5], layout="constrained")
    plot_path(posterior, trial, ax=left)
    plot_posterior_over_time(posterior, trial, ax=right)


path_and_posterior(posterior, TRIAL)

# %% [markdown]
# The strip under the lines is the truth: the segments, in the colour of their goal. The first steps could
# lead anywhere; then the belief settles, and follows the human when it turns around.
#
# ## What the first seconds tell
#
# The same for all segments: how often is the most probable goal the true one, after a share of each
# segment?

# %%
shares = np.linspace(0.05, 1, 20)
models = {"goal-lqr, stay 0.98": first_guess, "nearest goal": NearestGoal(), "heading": Heading()}
posteriors = {name: infer_log(log, model) for name, model in models.items()}


def draw_curves(posteriors):
    _, axes = plt.subplots(1, 2, figsize=(10, 3.6), layout="constrained")
    fields = {
        "accuracy": "accuracy of the goal",
        "mean_log_posterior": "mean log posterior of the true goal [nat]",
    }
    for ax, (field, label) in zip(axes, fields.items(), strict=True):
        for (name, each), colour in zip(
            posteriors.items(), ("#0072B2", "#E69F00", "#009E73", "#CC79A7"), strict=False
        ):
            scores = score_posterior(each, at=shares).overall
            mean = np.array([getattr(score, field) for score in scores])
            error = np.array([getattr(score, f"{field}_se") for score in scores])
            ax.plot(100 * shares, mean, color=colour, label=name)
            ax.fill_between(100 * shares, mean - error, mean + error, color=colour, alpha=0.15, linewidth=0)
        guess = 0.25 if field == "accuracy" else np.log(0.25)
        ax.axhline(guess, color="#767676", linewidth=1, linestyle="--", label="guessing")
        ax.set(xlabel="share of the segment seen [%]", ylabel=label, xlim=(0, 100))
        ax.spines[["top", "right"]].set_visible(False)
    axes[0].set_ylim(0, 1.03)
    axes[1].set_ylim(top=0)
    axes[0].legend(frameon=False, loc="lower right")


draw_curves(posteriors)

# %% [markdown]
# Bands are one standard error over participants. The nearest goal is a poor guess until the end, since this
# human does not prefer near goals; the heading is a good one on the way and a poor one when little is left
# to go.


# %%
def score_table(posteriors):
    """Return accuracy / mean log posterior after 25, 50 and 75 % of each segment."""
    rows = {
        name: {
            f"{score.at:.0%}": f"{score.accuracy:.3f} / {score.mean_log_posterior:.2f}" for score in scores
        }
        for name, scores in ((name, score_posterior(each).overall) for name, each in posteriors.items())
    }
    return pd.DataFrame(rows).T


score_table(posteriors)

# %% [markdown]
# ## A mind that changes
#
# The plain product of likelihoods (`stay = 1`) cannot forget: before it believes in the new goal, all that
# it has seen for the old one must be outweighed. A belief that allows for changes follows within two
# seconds.

# %%
plain = infer_log(log, GoalLQR(control_weight=10.0, rationality=0.002))
fig, axes = plt.subplots(2, 1, figsize=(9, 6), layout="constrained")
for ax, (name, each) in zip(axes, {"stay = 1": plain, "stay = 0.98": posterior}.items(), strict=True):
    plot_posterior_over_time(each, TRIAL, ax=ax)
    ax.set_title(name, loc="left")

# %% [markdown]
# ## Do the probabilities mean what they say?
#
# Of all the times that the model said "80 %", it should have been right 80 % of the time. Neither guess is:
# above the diagonal they are right more often than they say, and where the plain product is surest, it
# overstates.

# %%
fig, axes = plt.subplots(1, 2, figsize=(9, 4.2), layout="constrained")
for ax, (name, each) in zip(axes, {"stay = 1": plain, "stay = 0.98": posterior}.items(), strict=True):
    plot_reliability(calibrate_posterior(each).top_label, ax=ax)
    ax.set_title(name, loc="left")

# %% [markdown]
# ## Fitting the model
#
# `fit_study` tunes the control weight, the rationality, how much each sample counts (`tempering`), `stay`
# and a floor under the evidence of any one sample, so that the true goals get as much probability as
# possible. Participants are left out in three groups and predicted by a fit to the others; these are the
# numbers to believe.

# %%
fitted = fit_study(log, GoalLQR(), folds=3)
pd.Series(
    {name: getattr(fitted.fit.model, name) for name in (*GoalLQR.fitted, "tempering")}, name="fitted"
).to_frame()

# %%
held_out = fitted.held_out_posterior
posteriors["goal-lqr, fitted, held out"] = held_out
draw_curves({name: posteriors[name] for name in ("goal-lqr, stay 0.98", "goal-lqr, fitted, held out")})

# %%
score_table({"goal-lqr, stay 1": plain, **posteriors})

# %%
fig, axes = plt.subplots(1, 2, figsize=(10, 4.2), layout="constrained")
plot_reliability(calibrate_posterior(held_out).top_label, ax=axes[0])
axes[0].set_title("fitted, participants left out", loc="left")
plot_participants(score_posterior(held_out, at=[0.25]).by_participant, ax=axes[1])
_ = axes[1].set_title("after 25 % of each segment", loc="left")
# %% [markdown]
# Probabilities now mean what they say, for participants that the model had not seen. Some are easier to
# read than others, since they differ in their rationality (and have few segments each: the bars are two
# standard errors).
#
# ## Looking back: smoothing
#
# A robot knows only what has happened so far (the filter). Afterwards one may use the whole row (the
# smoother): it wavers less, and places the change of mind where it began. This trial has three picks; the
# belief starts anew at each, since the goals are new.

# %%
fig, axes = plt.subplots(2, 1, figsize=(9, 6), layout="constrained")
for ax, mode in zip(axes, ("filter", "smooth"), strict=True):
    plot_posterior_over_time(infer_log(log, fitted.fit.model, mode=mode), "p4-0", ax=ax)
    ax.set_title({"filter": "filtered: so far", "smooth": "smoothed: looking back"}[mode], loc="left")

# %% [markdown]
# ## Where to go next
#
# - The same from the terminal: `ppinfer fit LOG.nc --model goal-lqr -o MODEL.toml`, then
#   `ppinfer infer LOG.nc -o POST.nc --model MODEL.toml` and `ppinfer report POST.nc -o DIR`.
# - Your own data: `ppinfer convert TABLE.csv -o LOG.nc --from tidy --mapping M.toml`.
# - The robot's goals: `infer_log(log, model, agent="robot")`, or `--agent robot`.
# - Harder worlds, whose truth is known: `ppsim record reaching --help`.
