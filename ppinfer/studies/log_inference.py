"""Inference in memory: from a log to the posterior over an agent's goals, as one Dataset."""

from __future__ import annotations

import json
from collections.abc import Mapping
from typing import Any

import numpy as np
import xarray as xr
from jaxtyping import Float, Int, Shaped

from ppinfer.errors import LogError
from ppinfer.goals import GoalModel, infer_goals
from ppinfer.goals.belief import Mode
from ppinfer.goals.configuration import other_parameters_of, parameters_of
from ppinfer.goals.evidence import GoalEvidence
from ppinfer.studies.goal_evidence import Restart, agent_index, goal_evidence
from ppinfer.studies.posterior_layout import POSTERIOR_FORMAT, POSTERIOR_FORMAT_VERSION

DEFAULT_AGENT = "human"
TIME_STEP_SAMPLES = 1_000_000
TRIAL_LEVEL = (
    "trial_id", "row_size", "participant", "condition", "round", "goal_position", "goal_present",
    "segment_trial", "segment_agent", "segment_start", "segment_stop", "true_goal",
)  # fmt: skip


def infer_log(
    log: xr.Dataset,
    model: GoalModel,
    *,
    agent: str | None = None,
    mode: Mode = "filter",
    restart: Restart = "goals",
    carry: bool = False,
    partner: str | None = None,
) -> xr.Dataset:
    """Return the posterior over an agent's goals at every sample of a log in memory.

    The numbers are those that `infer_posterior` writes from a file, and the Dataset has the form of that file: it can
    be scored, compared and plotted as it is, and `write_posterior` writes it.

    Parameters
    ----------
    log : xarray.Dataset
        A study log.
    model : GoalModel
        The likelihood.
    agent : str, optional
        Whose goals; default ``human`` where there is one, or the only agent.
    mode : {"filter", "smooth"}
        Given the samples so far, or given the whole row.
    restart, carry
        Where the belief starts anew within a trial, and from what; see `goal_evidence`.
    partner : str, optional
        The other agent that a model looks at which looks at any; default: all other agents of the log.

    Returns
    -------
    xarray.Dataset
        ``log_posterior(sample, goal)`` with the trials and the agent's segments.

    Raises
    ------
    LogError
        Where the log has no goals or not that agent, or its numbers cannot be used.
    ImpossibleEvidenceError
        Where every goal is ruled out.

    Examples
    --------
    >>> from ppinfer.goals import GoalLQR
    >>> from ppinfer.testing import example_log
    >>> posterior = infer_log(example_log(), GoalLQR())
    >>> bool((abs(np.exp(posterior["log_posterior"]).sum("goal") - 1) < 1e-12).all())
    True
    """
    whose = default_agent(log) if agent is None else agent
    step = nominal_time_step(log)
    evidence = goal_evidence(log, whose, restart=restart, carry=carry, time_step=step, partner=partner)
    belief = infer_goals(model, evidence, mode=mode)
    attrs = {
        "mode": mode,
        "model": model.name,
        "configuration": configuration_text(
            model, whose, mode, restart, carry=carry, time_step=step, partner=partner
        ),
        "state_source": belief.state_source,
        "outliers_gated": 0 if belief.outliers is None else int(belief.outliers.sum()),
    }
    posterior = posterior_dataset(log, evidence, belief.log_posterior, whose, attrs)
    if belief.outliers is not None:
        posterior["outlier"] = ("sample", belief.outliers.astype(np.int8))
    return posterior


def posterior_dataset(
    log: xr.Dataset,
    evidence: GoalEvidence,
    log_posterior: Float[np.ndarray, "sample goal"],
    agent: str,
    attrs: Mapping[str, Any] | None = None,
) -> xr.Dataset:
    """Return a posterior in memory, in the form of a posterior file.

    Parameters
    ----------
    log : xarray.Dataset
        The log, in memory.
    evidence : GoalEvidence
        What `goal_evidence` made of it.
    log_posterior : (sample, goal) float64
        The log belief at every sample.
    agent : str
        Whose goals.
    attrs : mapping, optional
        Further attributes.

    Examples
    --------
    >>> from ppinfer.goals import GoalLQR, infer_goals
    >>> from ppinfer.testing import example_log
    >>> log = example_log(participants=1, trials=1)
    >>> evidence = goal_evidence(log, "human")
    >>> belief = infer_goals(GoalLQR(), evidence)
    >>> posterior_dataset(log, evidence, belief.log_posterior, "human")["log_posterior"].dims
    ('sample', 'goal')
    """
    index = agent_index(log, agent)
    kept = [
        name
        for name in TRIAL_LEVEL
        if name in log and not name.startswith("segment_") and name != "true_goal"
    ]
    out = log[kept].drop_vars("agent", errors="ignore")
    out = out.assign(
        log_posterior=(("sample", "goal"), log_posterior),
        time=log["time"],
        position=(("sample", "space"), log["position"].values[:, index], log["position"].attrs),
        observed=("sample", evidence.seen.astype(np.int8)),
    )
    if "goal_present" not in out:
        out["goal_present"] = (log["goal_position"].dims[:2], presence(log))
    out = out.assign({name: ("segment", values) for name, values in segments_of_agent(log, agent).items()})
    out.attrs = {
        "ppinfer_format": POSTERIOR_FORMAT,
        "ppinfer_format_version": POSTERIOR_FORMAT_VERSION,
        "ppinfer_version": ppinfer_version(),
        "hypothesis": "goal",
        "agent": agent,
        "samples_missing": int((~evidence.seen).sum()),
        **(attrs or {}),
    }
    return out


def segments_of_agent(log: xr.Dataset, agent: str) -> dict[str, Shaped[np.ndarray, " segment"]]:
    """Return the segments of one agent, by the names of a posterior's variables; none where the log has none.

    Examples
    --------
    >>> from ppinfer.testing import example_log
    >>> segments_of_agent(example_log(participants=1, trials=2, samples=9), "human")["segment_stop"]
    array([9, 9])
    """
    names = ("segment_trial", "segment_start", "segment_stop", "true_goal")
    if "segment_trial" not in log:
        kinds = (np.int64, np.int64, np.int64, object)
        return {name: np.zeros(0, kind) for name, kind in zip(names, kinds, strict=True)}
    mine = log["segment_agent"].values.astype(str) == agent
    return {name: log[name].values[mine] for name in names}


def default_agent(log: xr.Dataset) -> str:
    """Return ``human`` where there is one, or the only agent.

    Raises
    ------
    LogError
        Where there are several agents and none is called human.
    """
    agents = [str(label) for label in log["agent"].values]
    if DEFAULT_AGENT in agents:
        return DEFAULT_AGENT
    if len(agents) == 1:
        return agents[0]
    raise LogError(f"the log has agents {', '.join(agents)}; say whose goals to infer (--agent)")


def nominal_time_step(log: xr.Dataset) -> float | None:
    """Return the median time between samples within trials, over the first million samples of a log, in s.

    None where no trial among them holds two samples.

    Examples
    --------
    >>> from ppinfer.testing import example_log
    >>> round(nominal_time_step(example_log()), 9)
    0.1
    """
    time = log["time"][:TIME_STEP_SAMPLES].values
    if len(time) < 2:
        return None
    within = np.ones(len(time) - 1, dtype=bool)
    ends: Int[np.ndarray, " trial"] = np.cumsum(log["row_size"].values)
    within[ends[ends < len(time)] - 1] = False
    gaps = np.diff(time)[within]
    return float(np.median(gaps)) if len(gaps) else None


def configuration_text(
    model: GoalModel,
    agent: str,
    mode: Mode,
    restart: Restart,
    *,
    carry: bool,
    time_step: float | None,
    partner: str | None = None,
) -> str:
    """Return as JSON everything that a posterior depends on besides the log."""
    return json.dumps(
        {
            "model": model.name,
            "parameters": parameters_of(model),
            "other_parameters": other_parameters_of(model),
            "agent": agent,
            "mode": mode,
            "restart": restart,
            "carry": carry,
            "time_step": time_step,
            **({"partner": partner} if partner is not None else {}),
        },
        allow_nan=False,
    )


def ppinfer_version() -> str:
    """Return the version that results are marked with."""
    from ppinfer import __version__

    return __version__


def presence(log: xr.Dataset) -> Int[np.ndarray, "where goal"]:
    """Return ``goal_present``, ones where the log does not have it."""
    if "goal_present" in log:
        present: np.ndarray = log["goal_present"].values
        return present
    return np.ones(log["goal_position"].shape[:2], dtype=np.int8)
