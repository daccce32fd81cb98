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
# Is a robot that infers whom the human favours safer, or faster, than one that only keeps to a norm? And
# which of the repairs to the paper's posterior does it take? Here is the paper's Figure 4, played anew at
# a small size; then the repairs, taken back one by one; and then the harder case, in which robot and
# human do not imagine the same plans.
#
# **`SCENES` is the size of all that follows, and it is too small.** Most intervals below are wide, and
# one trial in which the arms stand off for a minute moves a mean by seconds: with another `SEED` a
# difference may well point the other way. What is to be believed takes 200 scenes or more; `ppsim study`
# plays them on several cores.

# %%
SCENES = 8
SEED = 0

# %%
from dataclasses import replace

import matplotlib.pyplot as plt
import numpy as np
from IPython.display import Markdown

from ppinfer.coordination import BayesNash, LiteralPersonality, MinNorm, Personality
from ppinfer.plots import (
    mean_beliefs,
    plot_against_personalities,
    plot_paired_differences,
    plot_task_performance,
    read_beliefs,
)
from ppinfer.studies import infer_log_personality, play_history, select_trials
from ppinfer.studies.task_performance import METRICS, task_performance
from ppsim.arms.study import ArmsStudy
from ppsim.study import log_of_study

# %matplotlib inline
plt.rcParams["figure.dpi"] = 110
plt.rcParams["axes.spines.top"] = plt.rcParams["axes.spines.right"] = False


def play(robots, plan_sets):
    """Play every robot with a defensive, a selfish and a norm-following human in every scene; return the log."""
    study = ArmsStudy(scenes=SCENES, robots=robots, plan_sets=(plan_sets,), seed=SEED)
    return log_of_study(study, range(study.trials))


# %% [markdown]
# ## Figure 4: times and safety stops
#
# Both look at the same candidate plans. `bayes-literal` is the paper's posterior as printed, `bayes-cost`
# the repaired one. `bayes` tells besides whom an equilibrium favours by what each *loses* by it, not by
# what it costs: who has the shorter way is often favoured by all equilibria, and then the other's choice
# would say nothing.

# %%
shared = play(("defensive", "selfish", "norm", "bayes-literal", "bayes-cost", "bayes"), "shared")
performance = task_performance(shared)
axes = plot_task_performance(performance, whiskers="95%")
axes[0].figure

# %% [markdown]
# Whiskers are 95 % intervals of each mean, over scenes. But scenes differ more than robots do, and the
# robots met the same scenes, humans and plans; so it is the *paired* differences that tell robots apart:

# %%
axes = plot_paired_differences(
    performance.differences(against=["norm"]), "norm", metrics=("total_s", "robot_s", "stops")
)
axes[0].figure


# %%
def in_words(performance, robots):
    """Return differences from the norm in words, and how far to trust them."""
    rows = {(one["robot"], one["metric"]): one for one in performance.differences(against=["norm"])}
    lines = []
    for robot in robots:
        for metric, of_what in (("total_s", "s in total"), ("stops", "safety stops a trial")):
            one = rows[robot, metric]
            low, high = round(one["low"], 2), round(one["high"], 2)
            clear = "clear of 0" if low * high > 0 else "which does not exclude 0"
            lines.append(
                f"- **{robot}** minus norm: {one['mean']:+.2f} {of_what}, 95 % interval "
                f"[{low:+.2f}, {high:+.2f}], {clear}"
            )
    stops = performance.values[:, METRICS.index("stops")]
    lines += [
        "",
        f"{SCENES} scenes with three humans each. {np.count_nonzero(stops)} of {len(stops)} trials had a safety "
        f"stop at all, so that the intervals of stops are rough themselves. 200 scenes make intervals about "
        f"{np.sqrt(200 / SCENES):.0f} times as narrow.",
    ]
    return Markdown("\n".join(lines))


in_words(performance, ["bayes-literal", "bayes-cost", "bayes"])

# %% [markdown]
# And the repaired robot by whom it met (the paper's Figure 6b):

# %%
axes = plot_against_personalities(performance, "bayes")
axes[0].figure

# %% [markdown]
# ## The posterior, repair by repair
#
# A posterior that is worth anything tells the humans apart: the selfish one should get a high p(human
# favours itself), the defensive one a low one. Below is the mean belief over each trial, all inferred
# afterwards from the same motion (that of the `bayes` trials). At the top is what `bayes` believes, and
# the repaired posterior with the printed classes (`bayes-cost`); below that the latter with one repair at
# a time switched off; at the bottom the paper's posterior as a whole. The number on the right is how far
# the selfish human is above the defensive one.

# %%
repaired = Personality()
variants = {
    "all repairs, and classes by loss": BayesNash().personality,
    "all repairs": repaired,
    "a game with an empty class counts": replace(repaired, skip_empty=False),
    "sum over a class, not its mean": replace(repaired, average=False),
    "ties belong to no class": replace(repaired, ties=False),
    "plans of the first replan only": replace(repaired, reanchor=False),
    "velocities count": replace(repaired, velocities=True),
    "the robot's own motion counts": replace(repaired, observed="all"),
    "no contamination": replace(repaired, contamination=0.0),
    "theta never changes": replace(repaired, stay=1.0),
    "literal, (5)-(10)": LiteralPersonality(),
}
of_bayes = select_trials(shared, np.flatnonzero(shared.controller.sel(agent="robot") == "bayes"))
humans = {"defensive": ("#009E73", "o"), "norm": ("#767676", "D"), "selfish": ("#D55E00", "s")}
fig, ax = plt.subplots(figsize=(8.6, 4.6), layout="constrained")
gap = {}
for row, (name, model) in enumerate(variants.items()):
    found = mean_beliefs(read_beliefs(infer_log_personality(of_bayes, model)))
    mean = {one.human: one.mean for one in found}
    gap[name] = mean["selfish"] - mean["defensive"]
    for one in found:
        colour, marker = humans[one.human]
        place = row + 0.2 * (list(humans).index(one.human) - 1)
        ax.plot(one.mean + np.array([-1, 1]) * one.sem, [place, place], color=colour, alpha=0.5, linewidth=2)
        ax.plot(one.mean, place, marker, color=colour, ms=6, label=f"{one.human} human" if row == 0 else None)
    ax.text(1.03, row, f"{gap[name]:+.2f}", va="center")
ax.axvline(0.5, color="#767676", linestyle="--", linewidth=1)
ax.axhline(1.5, color="#D9D9D9", linewidth=1)
ax.axhline(len(variants) - 1.5, color="#D9D9D9", linewidth=1)
ax.set_yticks(range(len(variants)), variants)
ax.set(xlim=(0, 1), ylim=(len(variants) - 0.5, -0.5), xlabel="mean p(human favours itself) ± standard error")
ax.tick_params(axis="y", length=0)
_ = ax.legend(frameon=False, ncols=3, loc="lower left", bbox_to_anchor=(0, 1))

# %%
costly = sorted(list(variants)[2:-1], key=gap.get)[:2]
Markdown(f"What costs most of that, here, once it is switched off: *{costly[0]}*, and *{costly[1]}*.")

# %% [markdown]
# Contamination and a theta that may change are not there for this number, and may even cost some of it:
# they see to it that nobody is written off for ever, and that a belief gone wrong can come back.
#
# ## The third repair: what a second counts
#
# A belief is worth nothing if it changes no decision. In the paper's norm a unit of cost is a second, and
# $\lambda_n = 50$ of them drown $p_\alpha$. Of the replans of the same trials at which there was more
# than one equilibrium to choose from: at how many does p(a) choose another one than the norm alone?

# %%
model = BayesNash().personality
history = play_history(of_bayes)
human_of_trial = of_bayes.controller.sel(agent="human").values
states, human_of_replan = [], []
for trial, replans in enumerate(of_bayes.replan_row_size.values):
    state = None
    for number in range(replans):
        state = model.observe(history.situation(trial, number), "robot", state)
        if state.equilibria.sum() > 1:
            states.append(state)
            human_of_replan.append(human_of_trial[trial])
human_of_replan = np.array(human_of_replan)


def changes(unit):
    """Return at which replans the belief changes what the norm with this unit would choose."""
    norm = MinNorm(cost_unit=unit)
    log_p_n = [
        np.where(one.equilibria, norm.log_weights(one.game.costs, one.equilibria), -np.inf) for one in states
    ]
    return np.array(
        [(p_n + one.log_p_alpha).argmax() != p_n.argmax() for p_n, one in zip(log_p_n, states, strict=True)]
    )


units = np.geomspace(1, 1000, 25)
changed = np.array([changes(unit) for unit in units])
fig, ax = plt.subplots(figsize=(7.4, 3.2), layout="constrained")
for human, (colour, _) in humans.items():
    mine = human_of_replan == human
    ax.semilogx(units, 100 * changed[:, mine].mean(axis=1), color=colour, linewidth=2, label=f"{human} human")
default = BayesNash().norm.cost_unit
ax.set_title(
    f"of {len(states)} choices, the belief changes {changes(1.0).sum()} with the paper's unit of 1 s, "
    f"{changes(default).sum()} with {default:g} s",
    loc="left",
    fontsize="medium",
)
ax.axvline(default, color="#B22222", linestyle=":")
ax.text(
    0.97 * default,
    1.0,
    "ppinfer's default",
    color="#B22222",
    transform=ax.get_xaxis_transform(),
    va="top",
    ha="right",
)
ax.set(
    xlabel="seconds that count as one unit of cost",
    ylabel="choices changed [%]",
    xlim=(1, 1000),
    ylim=(0, None),
)
_ = ax.legend(frameon=False, loc="upper left")

# %% [markdown]
# ## Independent plans: what a person would bring
#
# So far both looked at the same candidates. A person imagines their own, and the robot's samples do not
# contain what the human is about to do. Then it helps to keep to what one is doing (`norm-committed`),
# and to weigh the risk of all that the human might do (`bayes-risk`):

# %%
independent = play(("norm", "norm-committed", "bayes", "bayes-risk"), "independent")
apart = task_performance(independent)
axes = plot_task_performance(apart, whiskers="95%")
axes[0].figure

# %%
axes = plot_paired_differences(
    apart.differences(against=["norm"]), "norm", metrics=("total_s", "robot_s", "stops")
)
axes[0].figure

# %%
in_words(apart, ["norm-committed", "bayes-risk"])

# %% [markdown]
# ## Where to go next
#
# - The study at full size: `ppsim study --scenes 200 --seed 1000 --workers 2 -o LOG.nc`, and with
#   `--plan-sets independent`; then `ppinfer report LOG.nc -o DIR` draws these figures.
# - One trial at a time: [Whom does the human favour?](whom_does_the_human_favour.py)
# - What p(a) is: [Which equilibrium?](which_equilibrium.py)
