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
# # What will the human do?
#
# A human and a robot among goals never take the same one. So what the robot is about to do changes what the
# human will do, and a robot that predicts the human as if it were not there itself is wrong in just those
# moments that matter. This notebook follows both predictions through one interaction, beside what a robot
# believed live, and then asks which of the robot's ways are safe.
#
# The log is the reaching study with people, where the environment variable `PPINFER_DATA` names the folder
# that holds it; else `data/reach-games-small.nc`, games with simulated humans recorded by `ppsim reach`.

# %%
import os
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
import pandas as pd

import ppinfer
from ppinfer.goals.choice.joint import point_agent
from ppinfer.goals.conditional import SoftmaxConditional
from ppinfer.plots import plot_candidates, plot_conditional_belief, plot_risk_map
from ppinfer.plots.risk_map import draw_mover
from ppinfer.plots.workspace import draw_goals, plane
from ppinfer.studies import (
    goal_evidence,
    infer_log_conditional,
    posterior_dataset,
    read_log,
    read_reaching_study,
    score_posterior,
)
from ppinfer.studies.interaction import live_names, live_probabilities, read_interaction, stretches
from ppinfer.studies.interaction_safety import candidate_paths, human_mover, risk_map, situation_at

plt.rcParams["figure.dpi"] = 110
# people where they are at hand; else the log that ships with ppinfer: beside the package, or above this notebook
people = Path(os.environ.get("PPINFER_DATA", "nowhere"), "reaching-study")
folders = [*Path(ppinfer.__file__).parents[:2], Path.cwd(), *Path.cwd().parents]
shipped = [path for folder in folders if (path := folder / "data" / "reach-games-small.nc").exists()]
log = read_reaching_study(people) if people.exists() else read_log(shipped[0])
pd.Series(
    {
        "who": "people" if people.exists() else "simulated humans",
        "trials": log.sizes["trial"],
        "minutes": round(sum(log.time.values[np.cumsum(log.row_size.values) - 1]) / 60, 1),
        "held live": ", ".join(live_names(log)),
    },
    name="the log",
).to_frame()

# %% [markdown]
# ## One interaction
#
# `infer_log_conditional` gives, at every sample of all trials at once, the beliefs of Algorithm 1:
#
# - where the human is heading, from its motion alone: b(θ);
# - what the human may take the robot's goal to be, from the robot's motion: the mental model;
# - where the human will go *given* the robot's goal: b_post(θ | θ_R), for each goal that the robot may have.
#
# An interaction is a stretch of a trial with the same goals throughout. Of those whose outcome is known, here
# is the one in which the robot makes the most of a difference. The strip under the lines is the goal that the
# human really went for, that above them the robot's; the last two rows are what was believed live.

# %%
beliefs = infer_log_conditional(log)
plain, given = (np.exp(beliefs[name].values) for name in ("log_belief", "log_given"))
difference = np.abs(plain - given).sum(axis=1) / 2
ranked = sorted(stretches(log, "human"), key=lambda one: -difference[one.start : one.stop].mean())
interaction = next(
    found
    for one in ranked
    if one.stop - one.start >= 10 and (found := read_interaction(log, beliefs, one)).headings
)
_ = plot_conditional_belief(interaction, figure=plt.figure(figsize=(11, 6), layout="constrained"))

# %% [markdown]
# ## What the robot's goal changes
#
# The prediction is not one distribution but one for each goal that the robot may choose. Here they are, a second
# into the interaction. Orange lines are where the human would go in the next two seconds, thicker where that is
# likelier; the square is the robot's goal.

# %%
EARLY = int(np.flatnonzero(np.isfinite(interaction.apart) & (interaction.time >= interaction.time[0] + 1))[0])
situation, places = situation_at(interaction, EARLY), interaction.places[EARLY]
there = np.flatnonzero(np.isfinite(places).all(axis=1))
# the workspace: goals, and where the agents went but for jumps of the tracker
went = np.nanpercentile(interaction.position.reshape(-1, 2), [1, 99], axis=0)
corners = np.concatenate([places[there], went])
middle = (corners.min(axis=0) + corners.max(axis=0)) / 2
half = np.abs(corners - middle).max() + 1.5
bounds = (middle[0] - half, middle[0] + half, middle[1] - half, middle[1] + half)

ways = [("without the robot", None, interaction.belief[EARLY])]
ways += [(f"the robot goes for {interaction.goals[r]}", r, interaction.post[EARLY, r]) for r in there]
fig, panels = plt.subplots(
    1, len(ways), figsize=(3.1 * len(ways), 3.5), layout="constrained", sharex=True, sharey=True
)
for ax, (title, goal, post) in zip(panels, ways, strict=True):
    draw_mover(ax, human_mover(situation, post), 20)
    draw_goals(ax, places, interaction.goals, among=interaction.position[EARLY])
    ax.plot(*situation.robot_position, "o", color="#0072B2", ms=9, mec="white", zorder=8)
    if goal is not None:
        ax.plot(*places[goal], "s", color="#0072B2", fillstyle="none", ms=17, mew=1.8)
    plane(ax, interaction.units)
    ax.set_aspect("equal", adjustable="box")
    ax.set(xlim=bounds[:2], ylim=bounds[2:])
    ax.label_outer()
    ax.set_title(title, loc="left", fontsize="medium")

# %% [markdown]
# That anybody gives way at all is a matter of weights: w₁ for what a metre from the human to a goal costs, w₂
# for what a metre from the robot's goal is worth, w₃ for what a metre from the prior goal costs. With w₂ ≤ w₃
# no human whose nearest goal is the prior one is ever predicted to leave it (the triangle inequality), and a
# robot that believes so gives way to everybody. `yielding_share` says which detour a human would accept:

# %%
weights = {
    "ppinfer's default": SoftmaxConditional(),
    "of the study, simulated": SoftmaxConditional.study_simulation(),
    "of the study, people": SoftmaxConditional.study_people(),
}
robots_goal = int(interaction.partner_goal[EARLY])
rows = {}
for name, conditional in weights.items():
    post = conditional.post(situation).values[robots_goal]
    rows[name] = {
        "w₁, w₂, w₃": f"{conditional.human_weight}, {conditional.robot_weight}, {conditional.stay_weight}",
        "yielding share": conditional.yielding_share,
        "p(human goes for the robot's goal)": post[robots_goal].round(3),
    }
pd.DataFrame(rows).T

# %% [markdown]
# ## How well, over all segments
#
# The mean logarithm of the probability of the goal that the human went for (0 is perfect), after a quarter,
# a half and three quarters of each way there. “Given” takes the robot's goal from the log; “overall” does not
# need to know it. None of these parameters were fitted. Of people, more goals are told right with the robot's goal
# than without it while little of the way is seen. The simulated humans' segments begin when they set out, straight for
# a goal that they have chosen by then: there motion alone says nearly all.

# %%
evidence = goal_evidence(log, "human")
held = {"without the robot": "log_belief", "given the robot's goal": "log_given", "overall": "log_overall"}
told = {name: beliefs[variable].values for name, variable in held.items()}
with np.errstate(divide="ignore"):
    told |= {f"live: {name}": np.log(live_probabilities(log, name)) for name in live_names(log)}
scores = {}
for name, values in told.items():
    posterior = posterior_dataset(log, evidence, values, "human")
    scores[name] = {
        f"{100 * score.at:.0f} %": f"{score.mean_log_posterior:.2f} ({100 * score.accuracy:.0f} % right)"
        for score in score_posterior(posterior, min_samples=8, min_distance=2.0).overall
    }
pd.DataFrame(scores).T

# %% [markdown]
# A product of small experts that is fitted to people does much better: `ppinfer fit LOG.nc -o MODEL.toml
# --model goal-coupled`, and `ppinfer infer`.
#
# ## Which ways are safe?
#
# Back to the interaction, a second before the two came near each other. Left, the candidate trajectories of
# Algorithm 3 to the robot's goal: each is pushed about by one of the grey synthetic obstacles and by where the
# human is likely to go. Those that keep out of the circles are blue; of these the one that makes most way is
# held against a thousand rollouts of the human, and taken if the Clopper-Pearson bound says that it is safe.
#
# Middle and right, the same question asked for every place: how likely is a robot that starts here, and goes
# for the same goal, to come nearer than 1 to the human in the next two seconds? All places are candidates of
# one array program. The middle map believes the human's motion alone, the right one what the robot's goal
# makes of it.

# %%
near = np.flatnonzero(interaction.apart <= np.nanmin(interaction.apart) + 0.5)[0]
before = np.flatnonzero(np.isfinite(interaction.apart) & (interaction.time <= interaction.time[near] - 1.0))
SAMPLE = int(before[-1]) if len(before) else 0
situation = situation_at(interaction, SAMPLE)
goal = int(interaction.partner_goal[SAMPLE])
paths = candidate_paths(situation, goal, interaction.post[SAMPLE, goal])

places = interaction.places[SAMPLE]
look = {"goals": places, "labels": interaction.goals, "units": interaction.units}
fig, panels = plt.subplots(1, 3, figsize=(14.5, 4.8), layout="constrained")
plot_candidates(paths, **look, ax=panels[0])
panels[0].set_aspect("equal", adjustable="box")
panels[0].set(xlim=bounds[:2], ylim=bounds[2:])
predictions = {
    "human's motion alone": interaction.belief[SAMPLE],
    "given the robot's goal": interaction.post[SAMPLE, goal],
}
for ax, (name, post) in zip(panels[1:], predictions.items(), strict=True):
    human, rng = human_mover(situation, post), np.random.default_rng(0)
    risk = risk_map(point_agent(), places[goal], (human,), bounds=bounds, rng=rng)
    plot_risk_map(risk, **look, robot=situation.robot_position, colour_bar=ax is panels[2], ax=ax)
    ax.set_title(f"risk, {name}", loc="left", fontsize="medium")
for ax in panels[1:]:
    ax.set_ylabel("")
handles, labels = panels[0].get_legend_handles_labels()
_ = fig.legend(handles, labels, loc="outside lower left", ncols=8, frameon=False, markerscale=0.6)

# %%
found = paths.choice.certificate
bound = 1 - found.lower()
verdict = f"at most {bound:.3f} with 99 % confidence: {'not ' * paths.choice.flagged}claimed to be below 0.05"
pd.Series(
    {"trajectory chosen": f"{1 - found.estimate:.3f}; {verdict}"}, name="probability of a violation"
).to_frame()

# %% [markdown]
# ## Where to go next
#
# - The whole log as a page: `ppinfer report LOG.nc -o DIR`.
# - A game as a moving picture, with candidate trajectories in every frame: `ppsim watch reaching --seed 4`.
# - Many games of all robots: `ppsim reach --games 20 --seed 1 -o LOG.nc`.
