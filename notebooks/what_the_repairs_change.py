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
# # What the repairs change
#
# **Is a robot that infers whom the human favours safer, or faster, and which repairs of the paper's posterior
# does that take?** Here is Figure 4 of Bansal et al., played anew at a small size.
#
# Two arms pick and place side by side. Every robot meets a defensive, a selfish and a norm-following human in
# every scene. `bayes-literal` is the paper's posterior as printed, `bayes` the repaired one.

# %%
# the size of all that follows, and too small: 200 scenes make intervals four times as narrow
SCENES, SEED = 12, 0
PLAN_SETS = "shared"  # "independent": human and robot do not imagine the same plans, which is harder

from dataclasses import replace

import matplotlib.pyplot as plt
import numpy as np
import pandas as pd
from ipywidgets import Checkbox, FloatLogSlider

from ppinfer.coordination import BayesNash, LiteralPersonality
from ppinfer.plots import (
    explore,
    mean_beliefs,
    plot_paired_differences,
    plot_personality,
    plot_task_performance,
    read_beliefs,
)
from ppinfer.studies import infer_log_personality, play_history, select_trials
from ppinfer.studies.task_performance import task_performance
from ppsim.arms import ARMS
from ppsim.arms.drawing import Capsules
from ppsim.arms.study import ArmsStudy
from ppsim.study import log_of_study

# %matplotlib inline
ROBOTS = ("defensive", "selfish", "norm", "bayes-literal", "bayes")
study = ArmsStudy(scenes=SCENES, robots=ROBOTS, plan_sets=(PLAN_SETS,), seed=SEED)
log = log_of_study(study, range(study.trials))
performance = task_performance(log)
axes = plot_task_performance(performance, whiskers="95%")
axes[0].figure

# %% [markdown]
# Whiskers are 95 % intervals of each mean, over scenes. But scenes differ more than robots do, and all robots
# met the same scenes, humans and plans. So it is *paired* differences that tell robots apart: an interval
# clear of 0 is a difference.

# %%
differences = performance.differences(against=["norm"])
axes = plot_paired_differences(differences, "norm", metrics=("total_s", "robot_s", "stops"))
axes[0].figure

# %% [markdown]
# ## One scene, two posteriors
#
# The scene with a selfish human in which the two Bayesian robots differ most in safety stops (red frames):
# what happened, and what each believed. Discs are what has to be picked, squares where it goes; the robot is
# blue, the human orange.

# %%
trials = pd.DataFrame(
    {
        "scene": log.scene,
        "stops": log.stops,
        **log.controller.to_series().unstack("agent").reset_index(drop=True),
    }
)
stops = trials[trials.human == "selfish"].pivot(index="scene", columns="robot", values="stops")
scene = (stops["bayes-literal"] - stops["bayes"]).idxmax()
here = trials[(trials.human == "selfish") & (trials.scene == scene)].reset_index().set_index("robot")["index"]
pair = {robot: select_trials(log, [here[robot]]) for robot in ("bayes-literal", "bayes")}


def draw_instant(ax, trial, sample):
    """Draw the table at a sample of a trial."""
    for number, (arm, colour) in enumerate(zip(ARMS.values(), ("#0072B2", "#E69F00"), strict=True)):
        (pick, goal), hand = (
            trial.task_position.values[0, number],
            trial.end_effector.values[: sample + 1, number],
        )
        ax.plot(*pick, "o", color=colour, alpha=0.5)
        ax.plot(*goal, "s", color=colour, mfc="none", ms=9)
        ax.plot(*hand.T, color=colour, linewidth=1)
        Capsules(ax, arm, colour).show(trial.position.values[sample, number])
    held = trial.held.values[sample] != 0
    ax.set(xlim=(-0.75, 0.75), ylim=(-0.6, 0.6), aspect="equal", xticks=[], yticks=[])
    ax.set_title(f"{trial.time.values[sample]:.1f} s", fontsize="medium", loc="left")
    ax.spines[:].set(color="#B22222" if held else "#D9D9D9", linewidth=3 if held else 1)


held = pair["bayes-literal"].held.values
first_stop = held.argmax() if held.any() else len(held) // 2
fig, panels = plt.subplots(2, 5, figsize=(12, 4.2), layout="constrained", width_ratios=[1, 1, 1, 1, 1.6])
for row, (robot, trial) in zip(panels, pair.items(), strict=True):
    for ax, share in zip(row, (0.3, 0.7, 1.0, 1.6), strict=False):
        draw_instant(ax, trial, min(round(share * first_stop), trial.sizes["sample"] - 1))
    row[0].set_ylabel(robot, fontsize="large")
    plot_personality(trial, 0, ax=row[-1]).set_title("", loc="left")
    row[-1].set_ylabel("p(favours itself)")
    row[-1].get_legend().remove()

# %%
first_game = play_history(pair["bayes-literal"]).situation(0, 0)
printed = LiteralPersonality().observe(first_game, "robot", None)
pd.Series(printed.classes.sum(axis=(1, 2)), printed.theta.labels, name="equilibria that favour").to_frame().T

# %% [markdown]
# Those were the equilibria of that scene's *first* game, with whose plans the printed posterior compares all
# motion. Where one class is empty there is nothing to infer, whatever the human does. The repaired one looks
# at each game anew.
#
# ## The posterior, repair by repair
#
# A posterior that is worth anything tells the humans apart: a high p(human favours itself) for the selfish
# one, a low one for the defensive. Untick a repair, and see what becomes of that, all inferred again from the
# same motion.

# %%
of_bayes = select_trials(log, np.flatnonzero(log.controller.sel(agent="robot") == "bayes"))
PRINTED = {
    "by_loss": {"favour_by": "cost"},
    "empty_classes_are_silent": {"skip_empty": False},
    "mean_over_a_class": {"average": False},
    "ties_belong_to_both": {"ties": False},
    "plans_of_each_replan": {"reanchor": False},
    "only_the_others_motion": {"observed": "all"},
    "contamination": {"contamination": 0.0},
    "theta_may_change": {"stay": 1.0},
}
HUMANS = {"defensive": "#009E73", "norm": "#767676", "selfish": "#D55E00"}


def tell_apart(curves, means, *, sharpness, **repairs):
    """Draw the mean belief about each human, over replans and altogether."""
    model = replace(BayesNash().personality, rationality=sharpness)
    for repair, kept in repairs.items():
        model = model if kept else replace(model, **PRINTED[repair])
    found = {one.human: one for one in mean_beliefs(read_beliefs(infer_log_personality(of_bayes, model)))}
    for place, (human, colour) in enumerate(HUMANS.items()):
        one = found[human]
        curves.plot(one.curve, color=colour, linewidth=2, label=f"{human} human")
        band = one.curve - one.curve_sem, one.curve + one.curve_sem
        curves.fill_between(range(len(one.curve)), *band, color=colour, alpha=0.15, linewidth=0)
        means.errorbar(one.mean, place, xerr=one.sem, fmt="o", color=colour, markersize=8)
    curves.set(
        xlabel="replans seen (0.8 s each)", ylabel="mean p(human favours itself)", ylim=(0, 1), xlim=(0, 16)
    )
    curves.legend(frameon=False, loc="upper left", ncols=3, fontsize="small", bbox_to_anchor=(0, 1.12))
    means.set(xlim=(0, 1), ylim=(-0.6, 2.6), xlabel="mean over a trial ± standard error")
    means.set_yticks(range(3), HUMANS)
    gap = found["selfish"].mean - found["defensive"].mean
    means.set_title(
        f"selfish − defensive: {gap:+.2f}  (λ = {sharpness:.3g} /rad)", fontsize="medium", loc="left"
    )


explore(
    tell_apart,
    figsize=(10.0, 3.6),
    widths=(1.6, 1.0),
    **{name: Checkbox(value=True, description=name.replace("_", " ")) for name in PRINTED},
    sharpness=FloatLogSlider(value=10.0, min=-1, max=3, step=0.1, description="λ, sharpness [1/rad]"),
)

# %% [markdown]
# Contamination and a θ that may change are not there for this number, and may even cost some of it: they see
# to it that nobody is written off for ever, and that a belief gone wrong can come back. One more repair makes
# a belief count at all: what a second is worth in the norm, the λ of [Which
# equilibrium?](which_equilibrium.py).
#
# ## Where to go next
#
# - At full size: `ppsim study --scenes 200 --seed 1000 --workers 2 -o LOG.nc`, also with `--plan-sets
#   independent`; then `ppinfer report LOG.nc -o DIR` draws these figures.
# - A trial as a moving picture: `ppsim watch arms --log LOG.nc --trial ID -o TRIAL.gif`.
