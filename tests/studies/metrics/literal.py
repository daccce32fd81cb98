"""Every metric written out trial by trial and sample by sample: what the array programs have to equal."""

from __future__ import annotations

import itertools
import math

import numpy as np

ROLES = ("robot", "human")


def literal_metrics(log, *, speed=0.5, flags=False):
    """Return {metric: [value of each trial]} of a log like `example_team_log`; NaN where a value is undefined."""
    trials = log.sizes["trial"]
    # arrays, not data sets: each of many thousand looks into a data set makes a new array
    log = {str(name): variable.values for name, variable in log.variables.items()}
    agents = log["agent"].tolist()
    edges = np.concatenate([[0], np.cumsum(log["row_size"])])
    found: dict[str, list[float]] = {}
    for trial in range(trials):
        samples = range(edges[trial], edges[trial + 1])
        for name, value in one_trial(log, trial, samples, agents, speed, flags).items():
            found.setdefault(name, []).append(value)
    return found


def one_trial(log, trial, samples, agents, speed, flags):
    """Return every metric of one trial."""
    time = {k: float(log["time"][k]) for k in samples}
    began, ended = time[samples[0]], time[samples[-1]]
    length = ended - began
    finish = {role: float(log["finish_time"][trial, agents.index(role)]) for role in ROLES}
    first = float(log["first_score_s"][trial])
    told = {
        "duration_s": length,
        "total_s": max(length if math.isnan(finish[role]) else finish[role] - began for role in ROLES),
        "failures": float(any(math.isnan(finish[role]) for role in ROLES)),
        "stops": float(log["stops"][trial]),
        "stop_episodes": float(log["stop_episodes"][trial]),
        "score": float(log["team_score"][trial]),
        "collisions": float(runs([log["collision"][k] for k in samples])),
        "first_score_s": length if math.isnan(first) else first - began,
        "scoreless": float(math.isnan(first)),
    }
    pairs = list(itertools.pairwise(samples))
    done = min((f for f in finish.values() if not math.isnan(f)), default=math.inf)
    busy = [pair for pair in pairs if time[pair[1]] <= done]
    task = sum(time[b] - time[a] for a, b in busy)
    states = {}
    for role in ROLES:
        agent = agents.index(role)
        where = {k: log["position"][k, agent] for k in samples}
        hand = {k: log["end_effector"][k, agent] for k in samples}
        seen = [
            pair for pair in pairs if not (np.isnan(where[pair[0]]).any() or np.isnan(where[pair[1]]).any())
        ]
        walked = sum(math.dist(where[a], where[b]) for a, b in seen)
        seen_time = sum(time[b] - time[a] for a, b in seen)
        told[f"{role}_s"] = length if math.isnan(finish[role]) else finish[role] - began
        told[f"{role}_path_length"] = walked if seen else math.nan
        told[f"{role}_hand_path_m"] = sum(math.dist(hand[a], hand[b]) for a, b in seen) if seen else math.nan
        told[f"{role}_mean_speed"] = walked / seen_time if seen else math.nan
        picks = sum(log[f"{role}_pick"][k] >= 0 for k in samples)
        told[f"{role}_picks_per_minute"] = 60 * picks / length if length else math.nan
        segments = sum(
            log["segment_agent"][s] == role and log["segment_trial"][s] == trial
            for s in range(len(log["segment_trial"]))
        )
        told[f"{role}_segments_per_minute"] = 60 * segments / length if length else math.nan
        told[f"{role}_goal_changes"] = float(goal_changes(log, samples, agent))
        state = {}
        for a, b in pairs:
            if flags:
                state[b] = "idle" if log[f"is_{role}_waiting"][a] else "active"
            elif (a, b) not in seen:
                state[b] = "unseen"
            else:
                moved = math.dist(where[a], where[b])
                state[b] = "idle" if moved <= speed * (time[b] - time[a]) else "active"
        for kind in ("idle", "active", "unseen"):
            spent = sum(time[b] - time[a] for a, b in busy if state[b] == kind)
            told[f"{role}_{kind}_share"] = spent / task if task else math.nan
        states[role] = state
    both = sum(time[b] - time[a] for a, b in busy if {states[role][b] for role in ROLES} == {"active"})
    told["concurrent_share"] = both / task if task else math.nan
    told["functional_delay"] = functional_delay(states, busy, time, task)
    return told


def runs(marks):
    """Count runs of marks."""
    return sum(bool(mark) and not (k and marks[k - 1]) for k, mark in enumerate(marks))


def goal_changes(log, samples, agent):
    """Count changes of the goal pursued that no change of the goals explains; waits (-1) are skipped."""
    count, last = 0, None
    for k in samples:
        if last is not None and k > samples[0] and moved(log, k):
            last = "another draw"
        goal = int(log["pursued"][k, agent])
        if goal < 0:
            continue
        count += last not in (None, "another draw", goal)
        last = goal
    return count


def moved(log, k):
    """Return whether a goal is elsewhere than at the sample before."""
    now, before = log["goal_position"][k], log["goal_position"][k - 1]
    return not all(a == b or (a != a and b != b) for a, b in zip(now.ravel(), before.ravel(), strict=True))


def functional_delay(states, busy, time, task):
    """Add up the delays from one agent's actions to the other's, action by action."""
    actions = []
    for role in ROLES:
        begin = None
        for at, (a, b) in enumerate(busy):
            if states[role][b] != "active":
                continue
            if at == 0 or states[role][busy[at - 1][1]] != "active":
                begin = time[a]
            if at + 1 == len(busy) or states[role][busy[at + 1][1]] != "active":
                actions.append((begin, time[b], ROLES.index(role)))
    actions.sort(key=lambda action: action[:2])
    delays = [
        second[0] - min(one[1], second[1])
        for one, second in itertools.pairwise(actions)
        if one[2] != second[2]
    ]
    return sum(delays) / task if delays else math.nan
