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
# # Where is the human heading, and does it yield?
#
# The first paper infers whom a human favours (θ), the second where it is heading (its goal). In the
# reaching game both are in play: a human and a robot among goals, and both may want the same one. Who
# yields then turns to another goal. So a change of goal tells of θ, θ tells which changes of goal to
# expect, and one distribution, p(goal, θ), holds both.
#
# Below, a robot goes for its nearest goal whatever happens, and meets two simulated humans: a *moving*
# one, who leaves a goal that the robot seems to want, and a *stubborn* one, who does not.

# %%
import matplotlib.pyplot as plt
import numpy as np
import pandas as pd

from ppinfer import Axis, Distribution, Factor
from ppinfer.coordination import GoalChoiceGame
from ppinfer.goals import infer_goals
from ppinfer.goals.yielding import Yielding
from ppinfer.studies import encounter_evidence, log_of_trials
from ppsim.reaching.game_study import GameStudy

plt.rcParams["figure.dpi"] = 110
COLOUR = {"robot": "#0072B2", "human": "#E69F00"}
GOALS = ["#009E73", "#CC79A7", "#7F6BB3"]
INK = "#222222"

study = GameStudy(games=40, robots=("naive",), humans=("moving", "stubborn"), seed=4)
told = study.header()
log = log_of_trials(
    [study.trial(index) for index in range(study.trials)],
    agents=told.agents,
    goals=told.goals,
    has_velocity=told.has_velocity,
)
kind = log.controller.sel(agent="human").values.astype(str)
start = np.cumsum(log.row_size.values) - log.row_size.values

evidence = encounter_evidence(log)
# what a human does about the robot's goal: the equilibria of the game in which both choose goals
model = Yielding(reaction=GoalChoiceGame())
posterior = model.infer(evidence)
posterior

# %% [markdown]
# ## One game, two humans
#
# The first seconds of the scene in which the two humans part earliest. Above, where both agents went
# (from the ring on; the robot is blue, the human orange); below, the whole posterior at each instant: one
# colour a goal, dark where the human favours itself, light where it favours the robot.

# %%
human, robot = (list(log.agent.values.astype(str)).index(agent) for agent in ("human", "robot"))
SECONDS = 3.0
steps = round(SECONDS / 0.1)
theta = posterior.marginal("theta").values
apart = [
    theta[start[2 * game + 1] + steps, 1] - theta[start[2 * game] + steps, 1] for game in range(study.games)
]
# a scene whose goals stay for so long with both humans
steady = [
    all(
        (log.scored.values[start[trial] : start[trial] + steps] == 0).all()
        for trial in (2 * game, 2 * game + 1)
    )
    for game in range(study.games)
]
GAME = int(np.argmax(np.where(steady, apart, -1.0)))

fig, panels = plt.subplots(
    2, 2, figsize=(9.6, 7.2), layout="constrained", height_ratios=[1.5, 1], sharex="row"
)
for (above, below), trial in zip(panels.T, (2 * GAME, 2 * GAME + 1), strict=True):
    here = slice(start[trial], start[trial] + steps + 1)
    goals = log.goal_position.values[here][0]
    for number, (place, colour) in enumerate(zip(goals, GOALS, strict=True)):
        above.plot(*place, "s", color=colour, ms=15)
        above.text(*place, str(number), color="white", ha="center", va="center", fontweight="bold")
    for agent, who in ((robot, "robot"), (human, "human")):
        colour = COLOUR[who]
        path = log.position.values[here, agent]
        above.plot(*path.T, ".-", color=colour, linewidth=1.5, ms=3, label=who)
        above.plot(*path[0], "o", mfc="white", mec=colour, mew=2, ms=9)
    above.set(xlim=(-11, 11), ylim=(-11, 11), aspect="equal", xlabel="x [m]", ylabel="y [m]")
    above.legend(loc="best", frameon=False, fontsize="small")
    above.set_title(f"the {kind[trial]} human", loc="left")
    joint = posterior.values[here].reshape(steps + 1, -1)
    shades = [(colour, alpha) for colour in GOALS for alpha in (0.35, 1.0)]
    time = log.time.values[here]
    areas = below.stackplot(time, joint.T, colors=[colour for colour, _ in shades], linewidth=0)
    for area, (_, alpha) in zip(areas, shades, strict=True):
        area.set_alpha(alpha)
    below.set(xlim=(0, SECONDS), ylim=(0, 1), xlabel="time [s]", ylabel="p(goal, θ)")
handles = [plt.Rectangle((0, 0), 1, 1, color=colour, alpha=alpha) for colour, alpha in shades]
names = [f"goal {goal}, favours {whom}" for goal in range(3) for whom in ("the robot", "itself")]
_ = fig.legend(handles, names, loc="outside lower center", ncols=3, frameon=False)

# %% [markdown]
# ## What is known of θ stays when goals are new
#
# Each time the team scores, goals are drawn anew and their belief begins again; θ is carried over. Each
# thin line is a game of 30 s, thick ones are means. On the left the human is taken to react as the second
# paper's conditional has it, on the right to play an equilibrium of the game whose plans are goals, which
# is the first paper's hypothesis.

# %%
models = {
    "softmax conditional": Yielding(),
    "equilibria of goal choice": model,
}
found = {name: each.infer(evidence) for name, each in models.items()}
KINDS = {"stubborn": "#D55E00", "moving": "#56B4E9"}
fig, panels = plt.subplots(1, 2, figsize=(9.6, 3.4), layout="constrained", sharey=True)
for ax, (name, belief) in zip(panels, found.items(), strict=True):
    itself = belief.marginal("theta").values[:, 1].reshape(len(kind), -1)
    for who, colour in KINDS.items():
        ax.plot(
            log.time.values[: itself.shape[1]], itself[kind == who].T, color=colour, linewidth=0.5, alpha=0.3
        )
        ax.plot(
            log.time.values[: itself.shape[1]],
            itself[kind == who].mean(axis=0),
            color=colour,
            linewidth=3,
            label=who,
        )
    ax.set_title(name, loc="left", fontsize="medium")
    ax.set(xlabel="time [s]", xlim=(0, 30), ylim=(-0.02, 1.02))
    ax.spines[["top", "right"]].set_visible(False)
panels[0].set_ylabel("p(the human favours itself)")
_ = panels[1].legend(frameon=False, loc="upper left", bbox_to_anchor=(1.01, 1), title="human")

# %% [markdown]
# How well the two kinds are told apart at the end of a game, and where the human is heading at every
# instant, with θ and without:

# %%
pursued = log.pursued.values[:, human]
going = np.flatnonzero(pursued >= 0)
last = start + log.row_size.values - 1
stubborn = kind == "stubborn"


def row(belief, log_goal):
    """Return the scores of a belief."""
    scores = {"goal: mean log posterior": log_goal[going, pursued[going]].mean()}
    if belief is not None:
        log_theta = belief.marginal("theta").log_values[last]
        scores["θ: area under the curve"] = (log_theta[stubborn, 1][:, None] > log_theta[~stubborn, 1]).mean()
        scores["θ: mean log posterior"] = log_theta[np.arange(len(kind)), stubborn.astype(int)].mean()
    return scores


table = {name: row(belief, belief.marginal("goal").log_values) for name, belief in found.items()}
table["goal alone"] = row(None, infer_goals(model.motion, evidence.human).log_posterior)
pd.DataFrame(table).T.iloc[:, [1, 2, 0]].round(3)

# %% [markdown]
# ## The same algebra
#
# Nothing above is special to this pair of hypotheses. In the scene drawn above, the first paper's
# machinery on a game whose plans are goals gives p(goals | θ), a conditional distribution:

# %%
first = start[2 * GAME]
where = log.position.values[first]
choice = GoalChoiceGame().goals_given_theta(log.goal_position.values[first], where[human], where[robot])
choice

# %% [markdown]
# Times a belief over θ (from wherever: here even) it is the joint of θ and both goals; its marginal is
# the first paper's p_α, and conditioned on a choice that was seen it tells of θ:

# %%
even = Distribution.uniform(Axis("theta", ["robot", "human"]))
joint = even * choice
pd.DataFrame(
    {
        f"human goes for {goal}": joint.given(human_goal=goal).marginal("theta").values
        if joint.prob(human_goal=goal) > 0
        else [np.nan, np.nan]
        for goal in range(3)
    },
    index=["p(favours the robot)", "p(favours itself)"],
).round(3)

# %% [markdown]
# And what is known of a person from another task, say from parallel play with the arms, is one more
# factor over θ: it may come before the motion or after it, with the same result.

# %%
elsewhere = Factor.from_values([even.axes[0]], [0.9, 0.1])
before = model.infer(evidence, prior=elsewhere.normalize("theta"))
after = posterior.update(elsewhere)
print(f"largest difference: {np.abs(before.values - after.values).max():.1e}")

# %% [markdown]
# ## Where to go next
#
# - What the model assumes, and when it fails: [Goal and personality](../docs/goal-and-personality.md).
# - The first paper's θ by itself: [Whom does the human favour?](whom_does_the_human_favour.py).
