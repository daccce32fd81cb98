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
# **What does the robot's goal change in what the human will do, and which way is safe?**
#
# A human and a robot among goals never take the same one. So what the robot is about to do changes what the
# human will do, and a robot that predicts the human as if it were not there itself is wrong in just those
# moments that matter.
#
# Below is one interaction. Choose the robot's goal: on the left, where the human would then go (orange,
# thicker where that is likelier), and how likely a robot that starts at a place and goes for that goal is to
# come nearer than 1 m to the human within 2 s (shades; the line is at 5 %). On the right the same prediction
# as numbers, and the one without the robot.

# %%
import os
from dataclasses import replace
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
import pandas as pd
from ipywidgets import Dropdown, FloatLogSlider, FloatSlider, ToggleButtons

from ppinfer.goals.choice.joint import point_agent
from ppinfer.goals.conditional import SoftmaxConditional
from ppinfer.plots import explore, plot_candidates, plot_conditional_belief, plot_risk_map
from ppinfer.studies import (
    goal_evidence,
    infer_log_conditional,
    posterior_dataset,
    read_log,
    read_reaching_study,
    score_posterior,
    select_trials,
)
from ppinfer.studies.assumed_reactions import assumed_agent
from ppinfer.studies.interaction import live_names, live_probabilities, read_interaction, stretches
from ppinfer.studies.interaction_safety import candidate_paths, human_mover, risk_map, situation_at

# the reaching study with people, where PPINFER_DATA names its folder; else simulated games
people = Path(os.environ.get("PPINFER_DATA", "nowhere"), "reaching-study")
log = read_reaching_study(people) if people.exists() else read_log("../data/reach-games-small.nc")
beliefs = infer_log_conditional(log)

# the stretch of a trial, with the same goals throughout, in which the robot matters most
apart = np.abs(np.exp(beliefs.log_belief) - np.exp(beliefs.log_given)).sum("goal").values
known = [one for one in stretches(log, "human") if read_interaction(log, beliefs, one).headings]
chosen = max(known, key=lambda one: (one.stop - one.start >= 30, apart[one.start : one.stop].mean()))
trial = select_trials(log, [chosen.trial])
place = [one for one in stretches(log, "human") if one.trial == chosen.trial].index(chosen)
WEIGHTS = {"w = 2, 3, 1": SoftmaxConditional(), "the study's": SoftmaxConditional.study_people()}
BOUNDS = (-10.5, 10.5, -10.5, 10.5)  # m


def infer(beta, weights):
    """Return the interaction with the beliefs of a robot that assumes these of the human."""
    model = replace(assumed_agent(log), rationality=beta)
    told = infer_log_conditional(trial, model, conditional=WEIGHTS[weights])
    return read_interaction(trial, told, stretches(trial, "human")[place])


def predict(left, right, *, robots_goal, beta, weights, seen):
    """Draw what the human will do if the robot goes for a goal, and where the robot would be safe."""
    one = infer(beta, weights)
    sample = np.flatnonzero(np.isfinite(one.apart) & (one.time <= max(seen, one.time[0] + 0.2)))[-1]
    now, goal = situation_at(one, sample), one.goals.index(robots_goal)
    human, rng = human_mover(now, one.post[sample, goal]), np.random.default_rng(0)
    risk = risk_map(
        point_agent(), one.places[sample, goal], (human,), bounds=BOUNDS, cells=40, rollouts=500, rng=rng
    )
    shown = {
        "goals": one.places[sample],
        "labels": one.goals,
        "units": one.units,
        "robot": now.robot_position,
    }
    plot_risk_map(risk, **shown, colour_bar=False, ax=left)
    bars = {"without the robot": one.belief[sample], f"robot goes for {robots_goal}": one.post[sample, goal]}
    for shift, (name, values) in enumerate(bars.items()):
        where = np.arange(len(values)) + 0.4 * (shift - 0.5)
        right.bar(where, values, width=0.38, color=("#BBBBBB", "#E69F00")[shift], label=name)
    right.set_xticks(range(len(one.goals)), one.goals)
    right.set(ylim=(0, 1.2), yticks=[0, 0.5, 1], xlabel="goal", ylabel="p(the human goes there)")
    right.set_title(
        f"at {one.time[sample]:.1f} s, β = {beta:.2g} /cost, weights {weights}", fontsize="medium", loc="left"
    )
    right.legend(frameon=False, loc="upper right")


first = infer(3e-4, "w = 2, 3, 1")
ours = first.goals[first.partner_goal[first.time >= first.time[0] + 1][0]]
begin, end = first.time[[0, -1]]
explore(
    predict,
    figsize=(10.0, 4.4),
    widths=(1.0, 1.0),
    robots_goal=ToggleButtons(options=first.goals, value=ours, description="the robot's goal"),
    beta=FloatLogSlider(value=3e-4, min=-6, max=-1, step=0.1, description="β, rationality [1/cost]"),
    weights=Dropdown(options=list(WEIGHTS), description="weights of the reaction"),
    seen=FloatSlider(value=begin + 1.5, min=begin, max=end, description="seen until [s]"),
)

# %% [markdown]
# The weights w₁, w₂, w₃ say what a metre from the human to a goal costs, what a metre from the robot's goal
# is worth, and what a metre from the goal that it had costs. With w₂ ≤ w₃, as in the study, no human whose
# nearest goal is the one it had is ever predicted to leave it (the triangle inequality): a robot that
# believes so gives way to everybody.
#
# ## The whole interaction
#
# What was inferred at every sample, beside what a robot believed live. The strip under the lines is the goal
# that the human really went for, that above them the robot's.

# %%
interaction = read_interaction(log, beliefs, chosen)
_ = plot_conditional_belief(interaction, figure=plt.figure(figsize=(10, 5.5), layout="constrained"))

# %% [markdown]
# ## How well, over all segments
#
# Mean log posterior of the goal that the human went for (0 is perfect), after a quarter, a half and three
# quarters of each way there. Nothing was fitted. "Overall" does not need to know the robot's goal.

# %%
evidence = goal_evidence(log, "human")
told = {"without the robot": "log_belief", "given the robot's goal": "log_given", "overall": "log_overall"}
told = {name: beliefs[variable].values for name, variable in told.items()}
with np.errstate(divide="ignore"):
    told |= {f"live: {name}": np.log(live_probabilities(log, name)) for name in live_names(log)}
scores = {
    name: score_posterior(
        posterior_dataset(log, evidence, values, "human"), min_samples=8, min_distance=2.0
    ).overall
    for name, values in told.items()
}
pd.DataFrame(
    {
        name: {
            f"{score.at:.0%}": f"{score.mean_log_posterior:.2f} ({score.accuracy:.0%} right)"
            for score in each
        }
        for name, each in scores.items()
    }
).T

# %% [markdown]
# ## Which way is safe?
#
# A second before the two came near each other: candidate trajectories of Algorithm 3 to the robot's goal,
# pushed about by synthetic obstacles (grey) and by where the human is likely to go. Of the safe ones (blue)
# that which makes most way is held against a thousand rollouts of the human, and taken if the Clopper-Pearson
# bound says that it is safe.

# %%
near = np.flatnonzero(interaction.apart <= np.nanmin(interaction.apart) + 0.5)[0]
before = np.flatnonzero(np.isfinite(interaction.apart) & (interaction.time <= interaction.time[near] - 1.0))
sample = before[-1] if len(before) else 0
goal = interaction.partner_goal[sample]
paths = candidate_paths(situation_at(interaction, sample), goal, interaction.post[sample, goal])
ax = plot_candidates(
    paths, goals=interaction.places[sample], labels=interaction.goals, units=interaction.units
)
ax.set_aspect("equal", adjustable="box")
ax.set(xlim=BOUNDS[:2], ylim=BOUNDS[2:])
found = paths.choice.certificate
ax.set_title(
    f"p(violation) = {1 - found.estimate:.3f}, at most {1 - found.lower():.3f} with 99 % confidence"
    f": {'not ' * paths.choice.flagged}claimed to be below 0.05",
    loc="left",
    fontsize="medium",
)
ax.figure

# %% [markdown]
# ## Where to go next
#
# - A product of small experts that is fitted to people does much better: `ppinfer fit LOG.nc --model
#   goal-coupled`.
# - The whole log as a page: `ppinfer report LOG.nc -o DIR`. Many games: `ppsim reach --games 20 -o LOG.nc`.
