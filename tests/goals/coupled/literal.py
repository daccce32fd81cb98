"""goal-coupled as one would write it down: plain loops over samples and goals, nothing shared with the package."""

from __future__ import annotations

import math

import numpy as np
from scipy.special import i0

# what METHODS prints: fitted by others to some of these people
PRINTED = {
    "stay": 0.757,
    "motion.concentration": 12.7,
    "motion.half_speed": 2.1,
    "motion.outliers": 0.063,
    "motion.tempering": 0.289,
    "distance.weight": 0.29,
    "lead.weight": 0.18,
    "lead.cap": 4.0,
    "partner.distance": 0.39,
    "partner.closing": 0.54,
}


def literal_posterior(evidence, p):
    """Return the posterior for evidence without dropouts in which all goals are present."""
    out = np.empty((evidence.samples, len(evidence.goal_labels)))
    for row in range(evidence.rows):
        goals = evidence.goals[row]
        n = len(goals)
        belief = [1 / n] * n
        first = int(evidence.row_start[row])
        for t in range(first, first + int(evidence.row_size[row])):
            x = evidence.position[t]
            if t > first:
                before = evidence.position[t - 1]
                dt = evidence.time[t] - evidence.time[t - 1]
                speed = math.dist(x, before) / dt
                kappa = p["motion.concentration"] * speed / (speed + p["motion.half_speed"])
                moved = [p["stay"] * b + (1 - p["stay"]) / n for b in belief]
                for g in range(n):
                    a, b = x - before, goals[g] - before
                    cosine = float(a @ b) / (math.hypot(*a) * math.hypot(*b))
                    likelihood = (1 - p["motion.outliers"]) * math.exp(kappa * cosine) / i0(kappa)
                    likelihood += p["motion.outliers"]
                    belief[g] = moved[g] * likelihood ** p["motion.tempering"]
                total = sum(belief)
                belief = [b / total for b in belief]
            weights = []
            for g in range(n):
                d = math.dist(x, goals[g])
                weight = belief[g] * math.exp(-p["distance.weight"] * d)
                for partner in evidence.partners:
                    lead = min(math.dist(partner.position[t], goals[g]) - d, p["lead.cap"])
                    weight *= math.exp(p["lead.weight"] * lead)
                    weight *= 1 - goal_of(partner, evidence, t, t == first, goals, p)[g]
                weights.append(weight)
            out[t] = np.array(weights) / sum(weights)
    return out


def goal_of(partner, evidence, t, is_first, goals, p):
    """Return q, the belief over a partner's goal."""
    y = partner.position[t]
    if partner.velocity is not None:
        velocity = partner.velocity[t]
    elif is_first:
        velocity = np.zeros(2)
    else:
        velocity = (y - partner.position[t - 1]) / (evidence.time[t] - evidence.time[t - 1])
    scores = []
    for goal in goals:
        away = goal - y
        closing = float(velocity @ away) / math.hypot(*away)
        scores.append(math.exp(-p["partner.distance"] * math.hypot(*away) + p["partner.closing"] * closing))
    return [score / sum(scores) for score in scores]
