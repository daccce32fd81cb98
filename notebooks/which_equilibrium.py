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
# **When either may go first, what does a norm expect, and what does a personality change?** (Figure 1 of
# Bansal et al.)
#
# A robot and a human reach across the same corner of a table, where there is room for one. Either may go
# first, and both ways are *equilibria*: given what the other does, nobody would rather do something else. But
# if each picks the one that favours itself, they collide.

# %%
import matplotlib.pyplot as plt
import numpy as np
from ipywidgets import Dropdown, FloatLogSlider, FloatSlider

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
from ppinfer.plots import explore

COLOUR = {"robot": "#0072B2", "human": "#E69F00"}
DURATION = {"robot": 6.0, "human": 7.5}  # s for the whole way
SHARED = 0.45, 0.7  # the part of the way in which there is room for one
PLANS = ["go", "let pass", "stay"]  # stay never moves, and costs a second more than anything else


def look(at, motion=None):
    """Return what both see with the arms at these places of their ways: a game of three plans each."""
    clear = {agent: max(0.0, SHARED[1] - at[agent]) * DURATION[agent] for agent in at}
    plans, inside = [], []
    for agent, other in (("robot", "human"), ("human", "robot")):
        rest, wait, here = max(0.1, (1 - at[agent]) * DURATION[agent]), clear[other] + 0.1, [at[agent]]
        times, places = [0.0, rest, 0.0, wait, wait + rest, 0.0], [here, [1.0], here, here, [1.0], here]
        plans.append(PlanSet(agent, [2, 3, 1], times, places, static=2))
        enter = max(0.0, SHARED[0] - at[agent]) * DURATION[agent]
        inside.append([(enter, clear[agent]), (wait + enter, wait + clear[agent]), (np.inf, np.inf)])
    meet = [[(max(a, c) if a < d and c < b else np.inf) for c, d in inside[1]] for a, b in inside[0]]
    return Situation.from_contacts(plans, meet, motion=motion)


start = look({"robot": 0.0, "human": 0.0})
FIRST = {"robot": (0, 1), "human": (1, 0)}  # who goes, while the other lets pass
fig, axes = plt.subplots(1, 2, figsize=(9, 3), layout="constrained", sharey=True)
time = np.linspace(0, 13, 131)
for ax, (first, profile) in zip(axes, FIRST.items(), strict=True):
    ax.axhspan(*SHARED, color="#EFEFEF")
    for plans, plan in zip(start.plans, profile, strict=True):
        ax.plot(time, plans.positions(time)[plan, :, 0], COLOUR[plans.agent], lw=2.5, label=plans.agent)
    ax.set(xlabel="time [s]", title=f"the {first} goes first")
axes[0].set_ylabel("share of the way")
axes[0].text(12.9, np.mean(SHARED), "room for one", ha="right", va="center", color="#767676")
_ = axes[1].legend(frameon=False, loc="lower right")

# %% [markdown]
# The game: costs in seconds, infinite where the arms would collide, and both equilibria marked. Nothing in it
# says which one will be played.

# %%
Game(start.game.costs, ["robot", "human"], [Axis("robot_plan", PLANS), Axis("human_plan", PLANS)])

# %% [markdown]
# ## Norm times personality
#
# The *norm* expects whoever can be done first to go first, pₙ(a) ∝ exp(−λ minᵢ cᵢ(a)). The *personality* pₐ
# spreads what is believed of this human over the equilibria that favour it, and those that favour the robot.
# What is to be expected is their product, p(a) ∝ pₙ(a) pₐ(a).
#
# Move λ, and what is believed of the human. At the paper's λ of 50 /s the norm is a law, and drowns every
# belief; at ppinfer's 0.5 /s a robot that is sure of a selfish human lets it pass; at 0.001 /s the norm says
# nothing.

# %%
among = coordination_equilibria(start.game)
beliefs = np.linspace(0.001, 0.999, 199)


def expected(norm, p_alpha):
    """Return p(robot first) by the norm alone, and times each personality."""
    p_n = norm.probabilities(start.game, among)
    robot, human = (float(p_n.restrict(robot_plan=r, human_plan=h).values) for r, h in FIRST.values())
    return robot, robot * (1 - p_alpha) / (robot * (1 - p_alpha) + human * p_alpha)


def product(left, right, *, sharpness, belief):
    """Draw norm, personality and their product, and the product for every belief."""
    norm, both = expected(MinNorm(rationality=sharpness), np.append(beliefs, belief))
    for place, value in enumerate((norm, 1 - belief, both[-1])):
        left.bar(place, value, color=COLOUR["robot"], width=0.6)
        left.bar(place, 1 - value, bottom=value, color=COLOUR["human"], width=0.6)
        left.text(place, 1.02, f"{value:.2f}", ha="center")
    left.set_xticks(range(3), ["norm pₙ", "personality pₐ", "product p(a)"])
    left.set(ylim=(0, 1.1), ylabel="p(robot first) below, p(human first) above")
    right.plot(beliefs, both[:-1], color="#222222", linewidth=2)
    right.plot(belief, both[-1], "o", color="#B22222")
    right.axhline(0.5, color="#767676", linestyle="--", linewidth=1)
    right.set(xlabel="p(human favours itself)", ylabel="p(robot first)", xlim=(0, 1), ylim=(-0.02, 1.02))
    right.set_title(f"λ = {sharpness:.3g} /s, p(human favours itself) = {belief:.2f}", fontsize="medium")


explore(
    product,
    figsize=(10.0, 3.6),
    widths=(1.0, 1.2),
    sharpness=FloatLogSlider(value=0.5, min=-3, max=1.7, step=0.1, description="λ, norm's sharpness [1/s]"),
    belief=FloatSlider(value=0.9, min=0.01, max=0.99, step=0.01, description="p(human favours itself)"),
)

# %% [markdown]
# ## Evidence
#
# Now both move. Every 0.8 s each looks anew and chooses; in between, the robot compares how far the human
# came with the human's plan in either equilibrium. With a selfish human and λ of 50 /s, it is as sure of whom
# it faces as with 0.5 /s, and goes nevertheless, until a safety stop (red) holds both.


# %%
def cross(robot, human, replans=12):
    """Play; return the places every 0.1 s, p(human favours itself) at replans, and which steps were held."""
    at, motion, memory = {"robot": 0.0, "human": 0.0}, None, None
    places, beliefs, held = np.zeros((1, 2)), [], []
    for _ in range(replans):
        situation = look(at, motion)
        decision = robot.decide(situation, "robot", memory)
        memory = decision.memory
        beliefs.append(decision.belief.prob(theta="human"))
        chosen = zip(situation.plans, (decision.plan, human.decide(situation, "human").plan), strict=True)
        steps = np.column_stack([plans.positions(np.arange(9) / 10)[plan, :, 0] for plans, plan in chosen])
        stop = np.logical_or.accumulate(((steps > SHARED[0]) & (steps < SHARED[1])).all(axis=1))
        stop[0] = False
        steps[stop] = steps[~stop][-1]
        motion = Motion(steps[:, :, None], np.gradient(steps, 0.1, axis=0)[:, :, None], stop)
        places, held, at = (
            np.vstack([places, steps[1:]]),
            [*held, *stop[1:]],
            dict(zip(at, steps[-1], strict=True)),
        )
    return places, beliefs, np.array(held)


def meet(left, right, *, human, sharpness):
    """Draw where both went, and what the robot believed."""
    robot = BayesNash(norm=MinNorm(rationality=sharpness))
    places, beliefs, held = cross(robot, {"selfish": Selfish(), "keeps to the norm": NormNash()}[human])
    time = np.arange(len(places)) / 10
    left.axhspan(*SHARED, color="#EFEFEF")
    for path, (agent, colour) in zip(places.T, COLOUR.items(), strict=True):
        left.plot(time, path, color=colour, linewidth=2.5, label=agent)
    left.plot(time[1:][held], np.full(held.sum(), 1.07), "|", color="#B22222")
    left.set(xlabel="time [s]", ylabel="share of the way", xlim=(0, time[-1]), ylim=(-0.02, 1.12))
    left.legend(frameon=False, loc="lower right")
    left.set_title(f"human: {human}; {held.sum()} steps of 0.1 s held by a safety stop", fontsize="medium")
    right.step(time[::8], [*beliefs, beliefs[-1]], where="post", color=COLOUR["human"], linewidth=2.5)
    right.axhline(0.5, color="#767676", linestyle="--", linewidth=1)
    right.set(xlabel="time [s]", ylabel="p(human favours itself)", xlim=(0, time[-1]), ylim=(0, 1.02))
    right.set_title(f"λ = {sharpness:.3g} /s", fontsize="medium")


explore(
    meet,
    figsize=(10.0, 3.4),
    widths=(1.4, 1.0),
    human=Dropdown(options=["selfish", "keeps to the norm"], description="human"),
    sharpness=FloatLogSlider(value=50.0, min=-3, max=1.7, step=0.1, description="λ, norm's sharpness [1/s]"),
)

# %% [markdown]
# ## Where to go next
#
# - With arms, real plans and two hundred scenes: [What the repairs change](what_the_repairs_change.py).
# - A norm, a personality or a policy of your own is one small class: the page on coordination.
