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
# # Explore a posterior
#
# **Where is somebody heading, whom do they favour, and what does each parameter do to the answer?**
#
# Move a slider, and the posterior is inferred anew. The sliders need a running notebook; each picture shows
# where they stand when nobody has touched them.
#
# ## Where is this human heading?
#
# A human goes for one of four goals. Drag `seen` to replay the trial: at 17.4 s the human changes its mind.

# %%
from dataclasses import replace

import numpy as np
from ipywidgets import Dropdown, FloatLogSlider, FloatSlider, IntSlider

from ppinfer.coordination import BayesNash, GoalChoiceGame
from ppinfer.goals import GoalLQR
from ppinfer.goals.mental_model import paper_agent
from ppinfer.goals.yielding import Yielding
from ppinfer.plots import explore, explore_goals, plot_personality
from ppinfer.studies import (
    encounter_evidence,
    infer_log_personality,
    play_history,
    read_log,
    select_trials,
)
from ppsim.arms import ARMS

reaching = read_log("../data/reaching-small.nc")
explore_goals(reaching, "p4-3", GoalLQR(control_weight=10.0, rationality=0.002, stay=0.98), seen=18.5)

# %% [markdown]
# - `rationality` is β (1/cost): how closely the human is believed to do what is best for its goal. Too low,
#   and the motion tells nothing; too high, and every jerk tells everything.
# - `stay` is the probability, per sample, that the goal stays what it is: how fast the belief forgets. With
#   1, the paper's, it never does: what was seen for the old goal has to be outweighed before the new one is
#   believed.
#
# ## Whom does this human favour?
#
# Two arms reach across a table, and either may go first. Every 0.8 s the robot sees which of the ways to go
# on that are left, the *equilibria*, the human's motion resembles: those that favour the human itself, or
# those that favour the robot. On the left the human's plan in each equilibrium, orange where it favours the
# human itself, blue where it favours the robot, with a ring where its hand would be 0.8 s later; in black,
# what it did. On the right, what that made the robot believe.

# %%
arms = read_log("../data/arms-small.nc")
name = {human: f"scene-2/shared/bayes/{human}" for human in ("selfish", "defensive")}
trial = {human: select_trials(arms, np.flatnonzero(arms.trial_id == one)) for human, one in name.items()}
history = {human: play_history(one) for human, one in trial.items()}
FAVOURS = {"robot": "#0072B2", "human": "#E69F00"}


def whom(left, right, *, human, sharpness, contamination, seen):
    """Draw what is believed of a human after so many replans, and what the last of them showed."""
    model = replace(BayesNash().personality, rationality=sharpness, contamination=contamination)
    seen = min(seen, trial[human].replan_row_size.item() - 1)
    belief = infer_log_personality(trial[human], model)
    plot_personality(belief, 0, ax=right)
    right.axvspan(0.8 * (seen + 1), 20, color="white", alpha=0.85, linewidth=0, zorder=3)
    right.get_legend().remove()
    itself = np.exp(belief.log_posterior.sel(theta="human").values[seen])
    right.set_title(
        f"p(favours itself) = {itself:.2f} at {0.8 * seen:.1f} s", loc="left", pad=16, fontsize="medium"
    )
    right.set_ylabel("p(robot) above, p(itself) below")

    now, then = (history[human].situation(0, replan) for replan in (seen - 1, seen))
    state = model.observe(now, "robot", None)
    hand = ARMS["human"].end_effector
    for profile in np.argwhere(state.equilibria):
        colour = FAVOURS[np.array(state.theta.labels)[state.classes[:, *profile]][0]]
        plan = now.plans[1].positions(np.linspace(0, 6, 61))[profile[1]]
        left.plot(*hand(plan).T, color=colour, linewidth=1.5)
        left.plot(*hand(plan[8]), "o", color=colour, mfc="none", ms=11, mew=2)
    left.plot(*hand(then.motion.position[:, 1]).T, color="#222222", linewidth=4)
    left.set(xlabel="x [m]", ylabel="y [m]", xlim=(-0.55, 0.45), ylim=(-0.45, 0.45), aspect="equal")
    left.set_title(
        f"{human} human, {0.8 * (seen - 1):.1f} to {0.8 * seen:.1f} s", loc="left", fontsize="medium"
    )


explore(
    whom,
    figsize=(10.0, 3.8),
    widths=(1.0, 1.5),
    human=Dropdown(options=list(trial), description="human"),
    sharpness=FloatLogSlider(value=10.0, min=-1, max=3, step=0.1, description="λ, sharpness [1/rad]"),
    contamination=FloatSlider(value=0.04, min=0, max=1, step=0.02, description="contamination"),
    seen=IntSlider(value=3, min=1, max=12, description="replans seen"),
)

# %% [markdown]
# - `λ` says how much a radian between motion and plan counts. At 0.1 nothing is learned; at 1000 one replan
#   decides.
# - `contamination` is the probability that anybody, this once, moves like somebody else: nobody is written
#   off for ever.
#
# ## Both at once
#
# In the reaching game, a human whose goal the robot goes for too may yield, or not. So a change of goal tells
# of the personality, which tells what changes of goal to expect: one distribution, p(goal, θ), holds both. A
# robot that goes for its nearest goal meets the same scene twice: one human leaves a goal that the robot
# seems to want, one does not. One colour a goal, dark where the human favours itself, light where it favours
# the robot; titles tell the end.

# %%
games = read_log("../data/reach-games-small.nc")
names = [f"game-0/3-goals/naive/{human}" for human in ("moving", "stubborn")]
pair = select_trials(games, np.flatnonzero(np.isin(games.trial_id, names)))
evidence = encounter_evidence(pair)
SHADES = [f"{colour}{alpha}" for colour in ("#009E73", "#CC79A7", "#7A5195") for alpha in ("59", "ff")]


def both(*axes, reconsiders, beta):
    """Draw p(goal, theta) over time for a human who yields, and for one who does not."""
    model = Yielding(reaction=GoalChoiceGame(), motion=paper_agent(beta, stay=0.995), reconsiders=reconsiders)
    joint = np.split(model.infer(evidence).values, 2)
    for ax, belief, who in zip(axes, joint, ("yields", "does not yield"), strict=True):
        time = pair.time.values[: len(belief)]
        ax.stackplot(time, belief.reshape(len(belief), -1).T, colors=SHADES, linewidth=0)
        ax.set(xlim=time[[0, -1]], ylim=(0, 1), xlabel="time [s]", ylabel="p(goal, θ)")
        ax.set_title(
            f"one who {who}: p(favours itself) = {belief[-1, :, 1].sum():.2f}", loc="left", fontsize="medium"
        )


explore(
    both,
    figsize=(10.0, 3.4),
    widths=(1.0, 1.0),
    reconsiders=FloatLogSlider(
        value=0.05, min=-3, max=0, step=0.1, description="ρ, thinks again [per sample]"
    ),
    beta=FloatLogSlider(value=5e-3, min=-6, max=0, step=0.1, description="β, rationality [1/cost]"),
)

# %% [markdown]
# Goals are drawn anew when the team scores, and their belief begins again; θ is carried over. `ρ` is how
# often a human thinks again of the robot's goal: at 0.001 hardly ever, and nothing is learned of θ.
#
# ## Where to go next
#
# - Your own table: [Load your own log](load_your_own_log.py).
# - What equilibria, norms and personalities are: [Which equilibrium?](which_equilibrium.py).
