"""The network of Appendix II: LSTMs with attention over motion and plan, and linear layers to goal probabilities."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from ppinfer.goals.learned.configuration import NetworkConfiguration
from ppinfer.goals.learned.extra import require_torch
from ppinfer.goals.learned.features import GOAL_FEATURES, PAST_FEATURES, PLAN_FEATURES, Features


def build_network(configuration: NetworkConfiguration, seed: int = 0) -> Any:
    """Return the layers, with weights drawn from the seed.

    All layers after the LSTMs are applied to each goal alike, so the network takes any number of goals, and permuting
    the goals permutes the answer.
    """
    torch = require_torch()
    nn, h = torch.nn, configuration.hidden
    # the layers draw from PyTorch's own generator, whose state is nobody else's business
    with torch.random.fork_rng(devices=[]):
        torch.manual_seed(seed)
        return nn.ModuleDict(
            {
                "past": nn.LSTM(PAST_FEATURES, h, batch_first=True),
                "plan": nn.LSTM(PLAN_FEATURES, h, batch_first=True),
                "goal": nn.Sequential(nn.Linear(GOAL_FEATURES, h), nn.ReLU(), nn.Linear(h, h)),
                "query": nn.Linear(h, 2 * h),
                "each": nn.Sequential(nn.Linear(5 * h, h), nn.ReLU()),
                "among": nn.Sequential(nn.Linear(3 * h, h), nn.ReLU(), nn.Linear(h, 1)),
            }
        )


def log_probabilities(network: Any, features: Features, hidden: int) -> Any:
    """Return log p(post goal), (example, goal), for inputs in the network's units.

    1. An LSTM reads the past of both agents, another one the robot's plan.
    2. Every goal attends to the steps of each: softmax(q_g . s_t / sqrt(h)) weighs the LSTM's states s_t.
    3. Linear layers turn a goal, what it attended to and where both LSTMs ended into a vector; beside the mean and the
       largest entries of all goals' vectors it becomes one number, and a softmax over the goals that exist ends it.
    """
    torch = require_torch()
    kind = network["query"].weight.dtype
    past, _ = network["past"](torch.from_numpy(features.past).to(kind))
    plan, _ = network["plan"](torch.from_numpy(features.plan).to(kind))
    present = torch.tensor(features.present)
    goal = network["goal"](torch.from_numpy(features.goals).to(kind))
    queries = network["query"](goal).split(hidden, dim=-1)
    attended = []
    for query, states in zip(queries, (past, plan), strict=True):
        weight = torch.softmax(query @ states.transpose(1, 2) / math.sqrt(hidden), dim=-1)
        attended.append(weight @ states)
    ends = torch.cat([past[:, -1], plan[:, -1]], dim=-1)
    ends = ends[:, None].expand(-1, goal.shape[1], -1)
    each = network["each"](torch.cat([goal, *attended, ends], dim=-1))
    there = present[..., None]
    # the vectors end in a ReLU: 0 is the least that any of them has
    mean = (each * there).sum(dim=1) / there.sum(dim=1)
    largest = (each * there).amax(dim=1)
    others = torch.cat([mean, largest], dim=-1)[:, None].expand(-1, goal.shape[1], -1)
    logits = network["among"](torch.cat([each, others], dim=-1))[..., 0]
    return torch.log_softmax(logits.double().masked_fill(~present, -math.inf), dim=-1)


def weights_of(network: Any) -> dict[str, np.ndarray]:
    """Return the weights by name, as arrays of their own."""
    return {name: tensor.detach().numpy().copy() for name, tensor in network.state_dict().items()}


def load_weights(network: Any, weights: dict[str, np.ndarray]) -> None:
    """Put weights, which must be all that the network has and of the same shapes, in their places."""
    torch = require_torch()
    network.load_state_dict({name: torch.from_numpy(array.copy()) for name, array in weights.items()})
