"""What a robot believed about theta at its replans, taken out of a study log or a posterior over theta."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import xarray as xr
from jaxtyping import Bool, Float, Int, Shaped

from ppinfer.errors import LogError
from ppinfer.studies.resampling import mean_and_cluster_se

SHARES = np.linspace(0.0, 1.0, 21)
# a log holds what was believed live, a posterior what was inferred afterwards
_VARIABLES = ("log_posterior", "live_log_posterior")


@dataclass(frozen=True, eq=False)
class ReplanBeliefs:
    """The robot's belief at every replan at which it held one, trials end to end.

    Attributes
    ----------
    theta
        Whom an agent's equilibria favour: labels.
    trial
        Index of each replan's trial.
    time
        Seconds.
    probability
        p(theta).
    robot, human, plan_sets, scene
        Of every trial, those without any belief included.
    """

    theta: tuple[str, ...]
    trial: Int[np.ndarray, " replan"]
    time: Float[np.ndarray, " replan"]
    probability: Float[np.ndarray, "replan theta"]
    robot: Shaped[np.ndarray, " trial"]
    human: Shaped[np.ndarray, " trial"]
    plan_sets: Shaped[np.ndarray, " trial"]
    scene: Int[np.ndarray, " trial"]

    def of(self, label: str) -> Float[np.ndarray, " replan"]:
        """Return the probability of one label.

        Raises
        ------
        LogError
            If there is no such label.
        """
        if label not in self.theta:
            raise LogError(f"theta has no label {label!r}; it has {', '.join(self.theta) or 'none'}")
        return self.probability[:, self.theta.index(label)]

    def among(self, trials: Bool[np.ndarray, " trial"]) -> ReplanBeliefs:
        """Return the beliefs of these trials only; the others stay, without any."""
        kept = trials[self.trial]
        return ReplanBeliefs(
            self.theta,
            self.trial[kept],
            self.time[kept],
            self.probability[kept],
            self.robot,
            self.human,
            self.plan_sets,
            self.scene,
        )


@dataclass(frozen=True, eq=False)
class MeanBelief:
    """How one robot's belief that a human favours itself goes through its trials, on average.

    Attributes
    ----------
    label
        Of theta: who favours itself.
    trials
        With any belief.
    mean, sem
        Over trials, of each trial's mean over its replans; the standard error is robust to what trials of a scene
        have in common, and NaN with one scene.
    curve, curve_sem
        The same after each of `SHARES` of the time between a trial's first and last belief.
    """

    label: str
    robot: str
    human: str
    plan_sets: str
    trials: int
    mean: float
    sem: float
    curve: Float[np.ndarray, " share"]
    curve_sem: Float[np.ndarray, " share"]

    def to_json(self) -> dict[str, object]:
        """Return it without the curve."""
        return {
            name: getattr(self, name) for name in ("robot", "human", "plan_sets", "trials", "mean", "sem")
        }


def belief_variable(dataset: xr.Dataset) -> str | None:
    """Return the name of the variable that holds beliefs over theta at replans; None where there is none."""
    for name in _VARIABLES:
        if name in dataset.variables and dataset.variables[name].dims == ("replan", "theta"):
            return name
    return None


def read_beliefs(dataset: xr.Dataset, *, robot: str = "robot", human: str = "human") -> ReplanBeliefs:
    """Read what the robot believed at its replans.

    Parameters
    ----------
    dataset
        A study log with ``live_log_posterior``, or a posterior over theta with ``log_posterior``.
    robot, human
        Which agents these are.

    Raises
    ------
    LogError
        If it holds no beliefs over theta.

    Examples
    --------
    >>> from ppinfer.testing.example_plays import example_planned_log
    >>> beliefs = read_beliefs(example_planned_log(trials=2, replans=3))
    >>> beliefs.theta, beliefs.trial.tolist()
    (('human', 'robot'), [0, 0, 0, 1, 1, 1])
    """
    name = belief_variable(dataset)
    if name is None:
        raise LogError(
            "there are no beliefs over theta: no log_posterior or live_log_posterior of dimensions (replan, theta); "
            "make a posterior of the log with 'ppinfer infer LOG -o POST.nc --model personality'"
        )
    sizes = dataset["replan_row_size"].values.astype(np.int64)
    logs = dataset[name].values
    held = (dataset["replan_agent"].values.astype(str) == robot) & ~np.isnan(logs).any(axis=1)
    return ReplanBeliefs(
        theta=tuple(str(label) for label in dataset["theta"].values),
        trial=np.repeat(np.arange(len(sizes)), sizes)[held],
        time=dataset["replan_time"].values[held],
        probability=np.exp(logs[held]),
        robot=controllers(dataset, robot),
        human=controllers(dataset, human),
        plan_sets=dataset["plan_sets"].values.astype(str)
        if "plan_sets" in dataset
        else np.full(len(sizes), ""),
        scene=dataset["scene"].values.astype(np.int64) if "scene" in dataset else np.arange(len(sizes)),
    )


def controllers(dataset: xr.Dataset, agent: str) -> Shaped[np.ndarray, " trial"]:
    """Return who controlled an agent in each trial; empty where it is not known."""
    unknown = np.full(dataset.sizes["trial"], "", object)
    if "controller" not in dataset:
        return unknown
    names = dataset["controller"]
    if names.dims == ("trial",):
        return names.values.astype(str) if agent == "robot" else unknown
    agents = [str(one) for one in dataset["agent"].values]
    return names.values[:, agents.index(agent)].astype(str) if agent in agents else unknown


def mean_beliefs(beliefs: ReplanBeliefs, label: str = "human") -> list[MeanBelief]:
    """Return the mean belief in a label for each robot, human and way of sharing plans.

    A belief holds until the next one. Each trial counts the same, however many replans it has.

    Parameters
    ----------
    beliefs
        From `read_beliefs`.
    label
        Of theta: the human favours itself, by default.

    Raises
    ------
    LogError
        If theta has no such label.

    Examples
    --------
    >>> from ppinfer.testing.example_plays import example_planned_log
    >>> (one,) = mean_beliefs(read_beliefs(example_planned_log()))
    >>> one.robot, one.human, one.trials, len(one.curve) == len(SHARES)
    ('bayes', 'norm', 3, True)
    """
    believed = beliefs.of(label)
    if not len(believed):
        return []
    trials, first, count = np.unique(beliefs.trial, return_index=True, return_counts=True)
    average = np.add.reduceat(believed, first) / count
    curves = believed[_replan_at(beliefs, trials, first, count)]
    keys = list(
        zip(
            *(getattr(beliefs, name)[trials].tolist() for name in ("robot", "human", "plan_sets")),
            strict=True,
        )
    )
    found = []
    for robot, human, plan_sets in dict.fromkeys(keys):
        here = np.array([one == (robot, human, plan_sets) for one in keys])
        scenes, cluster = np.unique(beliefs.scene[trials][here], return_inverse=True)
        mean, sem = mean_and_cluster_se(average[here], cluster, len(scenes))
        curve = np.array([mean_and_cluster_se(at, cluster, len(scenes)) for at in curves[here].T])
        found.append(
            MeanBelief(
                label=label,
                robot=str(robot),
                human=str(human),
                plan_sets=str(plan_sets),
                trials=int(here.sum()),
                mean=mean,
                sem=sem,
                curve=curve[:, 0],
                curve_sem=curve[:, 1],
            )
        )
    return found


def _replan_at(
    beliefs: ReplanBeliefs,
    trials: Int[np.ndarray, " held"],
    first: Int[np.ndarray, " held"],
    count: Int[np.ndarray, " held"],
) -> Int[np.ndarray, "held share"]:
    # one search for all trials: trial i's times, as shares of its own span, lie in [2 i, 2 i + 1]
    began = beliefs.time[first]
    span = beliefs.time[first + count - 1] - began
    row = np.repeat(np.arange(len(trials)), count)
    share = (beliefs.time - began[row]) / np.where(span > 0, span, 1.0)[row]
    asked = 2.0 * np.arange(len(trials))[:, None] + SHARES
    # a share that rounding puts just before a replan is that replan's
    found = np.searchsorted(2.0 * row + share, asked + 1e-9, side="right") - 1
    return np.clip(found, first[:, None], (first + count - 1)[:, None])
