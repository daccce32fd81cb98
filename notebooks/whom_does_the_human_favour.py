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
# # Whom does the human favour?
#
# Two arms pick and place side by side, and every 0.8 s both choose an equilibrium of the game that their
# plans make. From how the human moves, the robot infers θ: does the human play the equilibria that favour
# itself, or those that favour the robot? This notebook follows that belief through one trial, asks where
# it comes from, and compares the paper's posterior with the repaired one, live and afterwards.
#
# The log is `data/arms-small.nc`, a small study recorded by `ppsim study`: three scenes, four robots,
# three simulated humans.

# %%
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
import pandas as pd

import ppinfer
from ppinfer.coordination import BayesNash, LiteralPersonality
from ppinfer.plots import (
    mean_beliefs,
    plot_belief_by_human,
    plot_hand_distance,
    plot_personality,
    read_beliefs,
)
from ppinfer.studies import infer_log_personality, play_history, read_log, select_trials
from ppsim.arms import ARMS
from ppsim.arms.drawing import Capsules

plt.rcParams["figure.dpi"] = 110
COLOUR = {"robot": "#0072B2", "human": "#E69F00"}
STOP, INK = "#B22222", "#222222"
# the log that ships with ppinfer: beside the package, or above this notebook
folders = [*Path(ppinfer.__file__).parents[:2], Path.cwd(), *Path.cwd().parents]
LOG = next(log for folder in folders if (log := folder / "data" / "arms-small.nc").exists())
log = read_log(LOG)
trials = pd.DataFrame(
    {
        "trial": log.trial_id.values,
        "scene": log.scene.values,
        "robot": log.controller.sel(agent="robot").values,
        "human": log.controller.sel(agent="human").values,
        "stops": log.stops.values,
        "total_s": log.finish_time.max("agent").values,
    }
)
trials.pivot_table(index="robot", columns="human", values=["stops", "total_s"]).round(2)

# %% [markdown]
# ## Two robots, the same scene, the same human
#
# Of the scenes with a selfish human, take the one in which the literal and the repaired Bayesian robot
# differ most in safety stops. Both have the same tasks and the same candidate plans. Discs are what has
# to be picked, squares where it goes; a red frame is a safety stop. The robot is blue, the human orange,
# as is each one's share of the belief.

# %%
selfish = trials[trials.human == "selfish"].pivot_table(index="scene", columns="robot", values="stops")
SCENE = (selfish["bayes-literal"] - selfish["bayes"]).idxmax()
PAIR = {
    "literal": f"scene-{SCENE}/shared/bayes-literal/selfish",
    "repaired": f"scene-{SCENE}/shared/bayes/selfish",
}
starts = np.cumsum(log.row_size.values) - log.row_size.values
replan_starts = np.cumsum(log.replan_row_size.values) - log.replan_row_size.values


def of_trial(name):
    """Return the samples of a trial, and its replans, as slices; and its place among the trials."""
    place = trials.trial.tolist().index(name)
    return (
        slice(starts[place], starts[place] + log.row_size.values[place]),
        slice(replan_starts[place], replan_starts[place] + log.replan_row_size.values[place]),
        place,
    )


def draw_instant(ax, name, time):
    """Draw the table at a time of a trial: arms, tasks, and where the hands have been."""
    samples, replans, place = of_trial(name)
    sample = min(round(time / 0.1), samples.stop - samples.start - 1)
    for number, (agent, arm) in enumerate(ARMS.items()):
        colour = COLOUR[agent]
        pick, goal = log.task_position.values[place, number]
        ax.plot(*pick, "o", color=colour, alpha=0.5, ms=6, mew=0)
        ax.plot(*goal, "s", color=colour, mfc="none", ms=9, mew=1.5)
        ax.plot(
            *log.end_effector.values[samples][: sample + 1, number].T, color=colour, linewidth=1, alpha=0.7
        )
        Capsules(ax, arm, colour).show(log.position.values[samples][sample, number])
    held = log.held.values[samples][sample] != 0
    last = np.searchsorted(log.replan_sample.values[replans], sample, side="right") - 1
    belief = np.exp(log.live_log_posterior.sel(theta="human").values[replans][last])
    ax.set_title(
        f"{time:.1f} s · p = {belief:.2f}", fontsize="medium", loc="left", color=STOP if held else INK
    )
    ax.set(xlim=(-0.75, 0.75), ylim=(-0.6, 0.6), aspect="equal", xticks=[], yticks=[])
    for spine in ax.spines.values():
        spine.set(color=STOP if held else "#D9D9D9", linewidth=3 if held else 1)


samples, _, _ = of_trial(PAIR["literal"])
first_stop = log.time.values[samples][np.flatnonzero(log.held.values[samples])[0]]
moments = np.round(first_stop * np.array([0.0, 0.35, 0.7, 1.0, 1.5, 2.0]), 1)
fig, panels = plt.subplots(2, len(moments), figsize=(13, 4.6), layout="constrained")
for row, (name, trial) in zip(panels, PAIR.items(), strict=True):
    for ax, time in zip(row, moments, strict=True):
        draw_instant(ax, trial, time)
    row[0].set_ylabel(f"{name} posterior", fontsize="large")
_ = fig.supxlabel("above each: time, and the robot's p(human favours itself)", fontsize="medium")

# %% [markdown]
# The same, over the whole trial: what the robot believed at each replan, and how near the hands came.

# %%
fig, panels = plt.subplots(
    2, 2, figsize=(13, 5.2), layout="constrained", sharex=True, sharey="row", height_ratios=[1.3, 1]
)
for (name, trial), (above, below) in zip(PAIR.items(), panels.T, strict=True):
    plot_personality(log, trial, ax=above)
    above.set_title(f"{name} posterior", loc="left", fontsize="medium", pad=16)
    plot_hand_distance(log, trial, ax=below)
    for ax in (above, below):
        if ax.get_legend():
            ax.get_legend().remove()
handles, labels = panels[0, 0].get_legend_handles_labels()
panels[0, 1].legend(handles, labels, loc="upper left", bbox_to_anchor=(1.01, 1), frameon=False)
for ax in panels.flat:
    ax.set_xlim(0, max(trials.total_s[trials.trial.isin(PAIR.values())]))
    ax.label_outer()

# %% [markdown]
# The literal posterior does not move. These are the equilibria of that trial's *first* game, counted by
# whom they favour:

# %%
history = play_history(log)
_, _, place = of_trial(PAIR["literal"])
first = LiteralPersonality().observe(history.situation(place, 0), "robot", None)
pd.Series(first.classes.sum(axis=(1, 2)), first.theta.labels, name="equilibria that favour").to_frame().T

# %% [markdown]
# If there are none of one kind, (9) and (10) leave nothing to be inferred, whatever the human does. The
# repaired belief starts undecided, learns nothing from such a game, meets a human who comes its way, and
# makes room.
#
# ## Where the belief comes from
#
# Here is the replan of that trial after which the belief changed most. On the left the human's plans in
# the equilibria of that moment's game, in the colour of whom they favour, with a ring where the human
# would be at the next replan. In black, what it did. On the right, what each loses by these equilibria:
# an equilibrium favours whom it costs least more than the one that would be best for it.

# %%
_, replans, place = of_trial(PAIR["repaired"])
model, states, situations = BayesNash().personality, [None], []
for number in range(replans.stop - replans.start):
    situations.append(history.situation(place, number))
    states.append(model.observe(situations[-1], "robot", states[-1]))
belief = np.array([state.belief.prob(theta="human") for state in states[1:]])
WHEN = int(np.abs(np.diff(belief)).argmax())
situation, state, after = situations[WHEN], states[WHEN + 1], situations[WHEN + 1]
arm = ARMS["human"]
cells = np.argwhere(state.equilibria)

costs = np.where(state.equilibria, situation.game.costs, np.inf)
loss = costs - costs.min(axis=(1, 2), keepdims=True)

fig, (left, right) = plt.subplots(1, 2, figsize=(10.5, 4.2), layout="constrained", width_ratios=[1.2, 1])
where = situation.plans[1]
for mine, yours in cells:
    favoured = state.classes[:, mine, yours]
    colour = COLOUR[np.array(state.theta.labels)[favoured][0]]
    path = arm.end_effector(where.positions(np.linspace(0, max(where.duration[yours], 0.1), 80))[yours])
    left.plot(*path.T, color=colour, linewidth=1.8, zorder=6)
    ring = arm.end_effector(where.positions(0.8)[yours, 0])
    left.plot(*ring, "o", color=colour, mfc="none", ms=13, mew=2, zorder=9)
    right.plot(*loss[:, mine, yours], "o", color=colour, ms=9, clip_on=False)
pose = Capsules(left, arm, "#BBBBBB")
pose.show(after.motion.position[0, 1])
moved = arm.end_effector(after.motion.position[:, 1])
left.plot(*moved.T, color=INK, linewidth=3, label="what the human did", zorder=8)
left.plot(*moved[-1], "o", color=INK, ms=6, zorder=8)
for agent, colour in COLOUR.items():
    left.plot([], [], color=colour, label=f"its plan in equilibria that favour the {agent}")
left.legend(frameon=False, loc="upper left", bbox_to_anchor=(0, -0.02), fontsize="small")
left.set(aspect="equal", xticks=[], yticks=[])
left.update_datalim(arm.points(after.motion.position[0, 1]))
left.margins(0.1)
left.axis("off")
left.set_title(f"p(human favours itself): {belief[WHEN]:.2f} → {belief[WHEN + 1]:.2f}", loc="left")
high = 1.1 * loss[:, *cells.T].max()
right.plot([0, high], [0, high], "--", color="#767676", linewidth=1)
right.text(0.97 * high, high, "as much for both ", ha="right", va="top", color="#767676", fontsize="small")
right.set(
    xlabel="the robot loses [s]", ylabel="the human loses [s]", aspect="equal", xlim=(0, high), ylim=(0, high)
)
right.set_title(f"equilibria at {situation.time:.1f} s", loc="left")
_ = right.spines[["top", "right"]].set_visible(False)

# %% [markdown]
# ## Afterwards equals live
#
# All that a robot saw is in the log, so its beliefs can be inferred again: each trial with the model that
# was used in it, or all of them with another. The first reproduces what was held live:

# %%
again = infer_log_personality(log)
apart = np.abs(np.exp(again.log_posterior) - np.exp(again.live_log_posterior)).max("theta")
robot_of_replan = np.repeat(trials.robot.to_numpy(), again.replan_row_size.values)
pd.DataFrame({"robot": robot_of_replan, "largest difference of p(θ)": apart.values}).groupby(
    "robot"
).max().dropna()

# %% [markdown]
# And the second asks what *would* have been believed of the same motion. For the trials of the repaired
# robot:

# %%
mine = select_trials(log, np.flatnonzero(trials.robot == "bayes"))
models = {"literal, (5)-(10)": LiteralPersonality(), "repaired": BayesNash().personality}
fig, panels = plt.subplots(1, 2, figsize=(9.4, 3.6), layout="constrained")
for ax, (name, model) in zip(panels, models.items(), strict=True):
    plot_belief_by_human(mean_beliefs(read_beliefs(infer_log_personality(mine, model))), axes=[ax])
    ax.set_title(name, loc="left", fontsize="medium")
_ = panels[1].set_ylabel("")

# %% [markdown]
# Three scenes are three trials a line: enough to see what the posteriors do, not to say how well. The
# literal lines coincide wherever the first game decides; the repaired ones part.
#
# ## Where to go next
#
# - What the repairs do one by one, and what they are worth: [What the repairs
#   change](what_the_repairs_change.py).
# - A trial as a moving picture: `ppsim watch arms --log LOG.nc --trial ID -o TRIAL.gif`.
# - The same from the terminal: `ppinfer infer LOG.nc -o POST.nc --model personality --variant literal`,
#   and `ppinfer report POST.nc -o DIR`.
