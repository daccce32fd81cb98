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
# # Which equilibrium?
#
# A robot and a human reach across the same corner of a table. Either may go first, and both ways are
# *equilibria*: given what the other does, nobody would rather do something else. But if each picks the
# equilibrium that favours itself, they collide. So what should a robot expect, and how does that change
# with what it sees the human do?
#
# This notebook goes from a table of costs to $p(a) \propto p_n(a)\, p_\alpha(a)$: what a *norm* expects
# everybody to do, times what this human's *personality* makes likely. The example is in the spirit of
# Figure 1 of Bansal et al.

# %%
from dataclasses import replace

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.patches import Rectangle

from ppinfer import Axis
from ppinfer.coordination import (
    BayesNash,
    MinNorm,
    Motion,
    NormNash,
    PlanSet,
    Selfish,
    Situation,
    coordination_equilibria,
)
from ppinfer.games import Game

plt.rcParams["figure.dpi"] = 110
plt.rcParams["axes.spines.top"] = plt.rcParams["axes.spines.right"] = False
ROBOT, HUMAN, STOP, FAINT = "#0072B2", "#E69F00", "#B22222", "#EFEFEF"

# %% [markdown]
# ## The game
#
# Each arm has a way of length 1 to go, of which a part is also the other's way: there is room for one of
# them at a time. The robot would be done sooner. Each has three plans: **go**, **let pass** (wait until
# the other, going, is through, and then go) and **stay**, which never moves and costs a second more than
# anything else that one could do. Costs are seconds; a collision costs infinitely many.

# %%
DURATION = {"robot": 6.0, "human": 7.5}  # s for the whole way
SHARED = 0.45, 0.7  # the part of the way in which there is room for one
PLANS = ["go", "let pass", "stay"]


def look(at, motion=None):
    """Return the situation with the arms at these places of their ways: a game of three plans each."""
    clear = {agent: max(0.0, SHARED[1] - at[agent]) * DURATION[agent] for agent in at}
    plans, inside = [], []
    for agent, other in (("robot", "human"), ("human", "robot")):
        rest, wait = max(0.1, (1 - at[agent]) * DURATION[agent]), clear[other] + 0.1
        plans.append(
            PlanSet(
                agent,
                [2, 3, 1],
                [0.0, rest, 0.0, wait, wait + rest, 0.0],
                [[at[agent]], [1.0], [at[agent]], [at[agent]], [1.0], [at[agent]]],
                static=2,
            )
        )
        enter = max(0.0, SHARED[0] - at[agent]) * DURATION[agent]
        never = (np.inf, np.inf)
        inside.append([(enter, clear[agent]), (wait + enter, wait + clear[agent]), never])
    collide = [
        [
            max(mine[0], yours[0]) if mine[0] < yours[1] and yours[0] < mine[1] else np.inf
            for yours in inside[1]
        ]
        for mine in inside[0]
    ]
    return Situation.from_contacts(plans, collide, motion=motion)


start = look({"robot": 0.0, "human": 0.0})
axes_of_plans = [Axis("robot_plan", PLANS), Axis("human_plan", PLANS)]
game = Game(start.game.costs, ["robot", "human"], axes_of_plans)
equilibria = coordination_equilibria(game)
[
    (robot, human)
    for robot in PLANS
    for human in PLANS
    if equilibria.restrict(robot_plan=robot, human_plan=human).values
]


# %%
def draw_table(ax, game, marked, title):
    """Draw a cell for every profile: the robot's cost below left, the human's above right."""
    for i in range(len(PLANS)):
        for j in range(len(PLANS)):
            mine, yours = game.costs[:, i, j]
            free = np.isfinite(mine)
            ax.add_patch(
                Rectangle((j, i), 1, 1, fc="white" if free else "#F3DCDC", ec="#BBBBBB", linewidth=0.8)
            )
            if not free:
                ax.text(j + 0.5, i + 0.5, "collide", ha="center", va="center", color=STOP)
                continue
            ax.text(j + 0.12, i + 0.86, f"{mine:.1f} s", color=ROBOT, ha="left", va="bottom")
            ax.text(j + 0.88, i + 0.14, f"{yours:.1f} s", color="#9A6A00", ha="right", va="top")
            if marked[i, j]:
                colour = ROBOT if mine < yours else HUMAN
                ax.add_patch(
                    Rectangle((j + 0.035, i + 0.035), 0.93, 0.93, fill=False, ec=colour, linewidth=3)
                )
    ax.set(xlim=(0, 3), ylim=(3, 0), title=title)
    ax.set_xticks(np.arange(3) + 0.5, PLANS, color="#9A6A00")
    ax.set_yticks(np.arange(3) + 0.5, PLANS, color=ROBOT, rotation=90, va="center")
    ax.set_xlabel("human", color="#9A6A00", weight="bold")
    ax.set_ylabel("robot", color=ROBOT, weight="bold")
    ax.tick_params(length=0)
    ax.spines[:].set_visible(False)


def draw_equilibrium(ax, profile, title, colour):
    """Draw where both are on their ways over time, and the part with room for one."""
    time = np.linspace(0, 13, 131)
    ax.axhspan(*SHARED, color=FAINT)
    for plans, plan, of_agent in zip(start.plans, profile, (ROBOT, HUMAN), strict=True):
        ax.plot(time, plans.positions(time)[PLANS.index(plan), :, 0], color=of_agent, linewidth=2.2)
    ax.set(xlabel="time [s]", xlim=(0, 13), ylim=(-0.02, 1.05))
    ax.set_title(title, color=colour, loc="left", fontsize="medium", weight="bold")


ROBOT_FIRST, HUMAN_FIRST = ("go", "let pass"), ("let pass", "go")
fig, (left, middle, right) = plt.subplots(
    1, 3, figsize=(11.5, 3.9), layout="constrained", width_ratios=[1.25, 1, 1]
)
draw_table(left, game, equilibria.values > 0, "costs, and the equilibria")
draw_equilibrium(middle, ROBOT_FIRST, "the robot goes first", ROBOT)
draw_equilibrium(right, HUMAN_FIRST, "the human goes first", "#9A6A00")
right.set_yticklabels([])
middle.set_ylabel("place on the way")
_ = middle.text(12.7, np.mean(SHARED), "room for one", ha="right", va="center", color="#767676")

# %% [markdown]
# In two profiles nobody has any regret (`regret(game)`). The one with the blue frame costs the robot
# less, the one with the orange frame the human. Nothing in the game itself says which of them will be
# played.
#
# ## A norm: who can be done first goes first
#
# The paper's norm (3) is $p_n(a) \propto \exp(-\lambda_n \min_i c_i(a))$. It prefers the equilibrium in
# which *somebody* is done early. How strongly depends on what a second counts: `MinNorm(rationality,
# cost_unit)` divides costs by `cost_unit` first. At the paper's scale (a unit is a second, $\lambda_n =
# 50$) the norm is as good as a law.

# %%
units = np.geomspace(1, 1000, 61)
default = BayesNash().norm


def robot_first(distribution):
    """Return how probable a distribution over profiles finds it that the robot goes first."""
    robot, human = ROBOT_FIRST
    return float(distribution.restrict(robot_plan=PLANS.index(robot), human_plan=PLANS.index(human)).values)


among = coordination_equilibria(start.game)
follows = [robot_first(MinNorm(cost_unit=unit).probabilities(start.game, among)) for unit in units]
fig, ax = plt.subplots(figsize=(6.6, 3.0), layout="constrained")
ax.axhline(0.5, color="#767676", linestyle="--", linewidth=1)
ax.semilogx(units, follows, color="#222222", linewidth=2)
for unit, name in ((1.0, "the paper's unit"), (default.cost_unit, "ppinfer's, in BayesNash")):
    at = np.interp(np.log(unit), np.log(units), follows)
    ax.plot(unit, at, "o", color=STOP)
    ax.annotate(name, (unit, at), xytext=(9, 5), textcoords="offset points", color=STOP)
_ = ax.set(
    xlabel="seconds that count as one unit of cost (λₙ = 50)",
    ylabel="$p_n$(robot first)",
    ylim=(0.4, 1.1),
    xlim=(0.9, 1000),
)

# %% [markdown]
# ## A personality, and p(a)
#
# θ says whom the human's choice of equilibria favours. Given a belief in θ, $p_\alpha$ spreads it over
# the equilibria of each kind (7), and $p(a) \propto p_n(a)\, p_\alpha(a)$ (2). On the left, p(robot
# first) for every belief, at four units of cost. On the right, the same for all units: above the line the
# robot lets the human go first.

# %%
state = BayesNash().personality.observe(start, "robot", None)
beliefs = np.linspace(0.002, 0.998, 121)
p_alpha = [replace(state, log_belief=np.log([1 - belief, belief])).p_alpha for belief in beliefs]


def robot_goes(unit):
    """Return p(robot first) for every belief, with this unit of cost."""
    p_n = MinNorm(cost_unit=unit).probabilities(start.game, among)
    return [robot_first((p_n * each).normalize("robot_plan", "human_plan")) for each in p_alpha]


surface = np.array([robot_goes(unit) for unit in units])
fig, (left, right) = plt.subplots(1, 2, figsize=(10, 3.9), layout="constrained")
left.axhline(0.5, color="#767676", linestyle="--", linewidth=1)
four = (1.0, default.cost_unit / 4, default.cost_unit, 10 * default.cost_unit)
for unit, colour in zip(four, ("#222222", "#7A5195", STOP, "#009E73"), strict=True):
    left.plot(beliefs, robot_goes(unit), color=colour, linewidth=2, label=f"{unit:g} s")
left.legend(title="unit of cost", frameon=False, loc="lower left")
left.set(xlabel="p(human favours itself)", ylabel="p(robot first)", xlim=(0, 1), ylim=(-0.02, 1.02))
mesh = right.pcolormesh(units, beliefs, surface.T, cmap="PuOr", vmin=0, vmax=1, shading="gouraud")
right.contour(units, beliefs, surface.T, levels=[0.5], colors="#222222", linewidths=1.5)
right.axvline(default.cost_unit, color=STOP, linewidth=1.2, linestyle=":")
right.text(2, 0.5, "robot goes first", color="white", weight="bold")
right.text(950, 0.9, "robot lets pass", color="white", weight="bold", ha="right")
right.set(xscale="log", xlabel="unit of cost [s]", ylabel="p(human favours itself)")
_ = fig.colorbar(mesh, ax=right, label="p(robot first)")

# %% [markdown]
# With the paper's unit the black curve never comes down: the norm drowns what is known of the human,
# however sure. (This is one of three things that the default model repairs; see [What the repairs
# change](what_the_repairs_change.py).) With a unit that is too large, on the other hand, the norm says
# nothing, and the slightest hint decides.
#
# ## How evidence moves it
#
# Now both arms move. Every 0.8 s both look at the table anew and choose; in between, the robot sees how
# far the human has come, and compares that with the human's plans in either equilibrium. It meets a human
# who keeps to the same norm, and a *selfish* one who does what would be best for itself: with the default
# norm, and with one whose unit is a second. The dotted line is p(robot first), as long as there is still
# a choice.


# %%
def cross(robot, human, replans=12):
    """Play; return times, places of both, p(human favours itself), p(robot first), and times of safety stops."""
    at, motion, memory = {"robot": 0.0, "human": 0.0}, None, None
    places, beliefs, first, held = [[0.0, 0.0]], [], [], []
    for _ in range(replans):
        situation = look(at, motion)
        decision = robot.decide(situation, "robot", memory)
        memory = decision.memory
        beliefs.append(decision.belief.prob(theta="human"))
        p = [decision.distribution.values[PLANS.index(mine), PLANS.index(yours)]
             for mine, yours in (ROBOT_FIRST, HUMAN_FIRST)]  # fmt: skip
        first.append(p[0] if min(p) > 0 else np.nan)
        chosen = decision.plan, human.decide(situation, "human").plan
        steps, stopped = [places[-1]], [False]
        for _ in range(8):
            then = 0.1 * (stopped.count(False))
            there = [
                plans.positions(then)[plan, 0, 0] for plans, plan in zip(situation.plans, chosen, strict=True)
            ]
            stop = all(SHARED[0] < place < SHARED[1] for place in there)
            steps.append(steps[-1] if stop else there)
            stopped.append(stop)
        moved = np.array(steps)[:, :, None]
        motion = Motion(moved, np.gradient(moved, 0.1, axis=0), np.array(stopped))
        places += steps[1:]
        held += stopped[1:]
        at = dict(zip(at, steps[-1], strict=True))
    return np.arange(len(places)) * 0.1, np.array(places), beliefs, first, np.flatnonzero(held) * 0.1 + 0.1


meetings = {
    "a norm-following human": (BayesNash(), NormNash()),
    "a selfish human": (BayesNash(), Selfish()),
    "a selfish human; unit of 1 s": (BayesNash(norm=MinNorm(cost_unit=1.0)), Selfish()),
}
fig, panels = plt.subplots(
    2, 3, figsize=(11, 5), layout="constrained", sharex=True, sharey="row", height_ratios=[1.5, 1]
)
for (name, (robot, human)), (above, below) in zip(meetings.items(), panels.T, strict=True):
    time, places, beliefs, first, stops = cross(robot, human)
    above.axhspan(*SHARED, color=FAINT)
    for column, (agent, colour) in enumerate((("robot", ROBOT), ("human", HUMAN))):
        above.plot(time, places[:, column], color=colour, linewidth=2.2, label=agent)
    above.plot(stops, np.full(len(stops), 1.06), "|", color=STOP, markersize=6)
    told = f"{len(stops)} steps held by a safety stop" if len(stops) else "no safety stop"
    above.set_title(f"{name}\n{told}", fontsize="medium", loc="left", color=STOP if len(stops) else "#222222")
    below.axhline(0.5, color="#767676", linestyle="--", linewidth=0.8)
    styles = {"color": HUMAN, "linewidth": 2.2}, {"color": "#222222", "linestyle": ":", "linewidth": 1.8}
    labels = "p(human favours itself)", "p(robot first)"
    for values, style, label in zip((beliefs, first), styles, labels, strict=True):
        below.step(time[::8], [*values, values[-1]], where="post", label=label, **style)
    below.set(xlabel="time [s]", ylim=(0, 1.04))
panels[0, 0].set(ylabel="place on the way", ylim=(-0.02, 1.12))
panels[0, 0].text(9.6, np.mean(SHARED), "room for one", ha="right", va="center", color="#767676")
panels[1, 0].set_ylabel("probability")
panels[0, 0].legend(frameon=False, loc="lower right", bbox_to_anchor=(1, 0.05))
_ = panels[1, 2].legend(frameon=False, loc="lower right", fontsize="small")

# %% [markdown]
# The norm-following human waits, as the robot expects it to. The selfish one sets out as well; after a
# step or two the robot believes that more than it believes the norm, and lets it pass. Once the way is
# free, nothing more is to be learned, and the belief slowly forgets (theta may change: `stay`). With a
# unit of one second the robot is as sure of whom it faces, and goes nevertheless, until the safety stop
# holds both. Nobody would get out of that again; in the simulated studies a coin then sends one of them
# home.
#
# ## Where to go next
#
# - The same on a table with real plans: [Whom does the human favour?](whom_does_the_human_favour.py).
# - A norm, a personality or a policy of your own is one small class: `docs/coordination.md`.
# - Games from arrays and from Gambit's files, and their equilibria: `docs/games.md`.
