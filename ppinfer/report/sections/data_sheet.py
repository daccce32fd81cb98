"""The data sheet: what there is in a log or posterior, and what is missing from it."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import xarray as xr

from ppinfer.report.facts import Facts, counted, listed, shown_time
from ppinfer.report.parts import Draw, Part
from ppinfer.studies.posterior import trial_starts


def data_part(rows: Facts, figures: Sequence[Draw] = ()) -> Part:
    """Return the part with the data sheet, and pictures of what was recorded."""
    return Part("sections/facts.html.j2", {"rows": rows}, {"figures": figures})


def log_sheet(log: xr.Dataset, *, shown: int | None = None, more: Facts | None = None) -> Facts:
    """Say what a log holds.

    Parameters
    ----------
    log
        A log whose variables are all there in their shapes; it need not be sound.
    shown
        How many trials the page is about; all by default.
    more
        Further facts, of one kind of log, told after what was recorded when.
    """
    agents = [str(name) for name in log["agent"].values]
    facts = [
        ("trials", f"{log.sizes['trial']:,}"),
        *([("trials on this page", f"{shown:,}")] if shown is not None else []),
        *_people(log),
        *_times(log),
        *(more or []),
        ("agents", listed(agents)),
        *_controllers(log, agents),
        *_motion(log, agents),
        *_goals(log),
    ]
    if "outcome" in log and any(str(text) for text in log["outcome"].values):
        facts.append(("outcomes", counted(log["outcome"].values.astype(str).tolist())))
    if "replan_row_size" in log:
        replans = log["replan_row_size"].values
        facts += [
            ("replans", f"{int(replans.sum()):,} (median {np.median(replans):,.0f} a trial)"),
            ("plans", f"{log.sizes['plan']:,}"),
            ("profiles", f"{log.sizes['profile']:,}"),
        ]
    return facts


def posterior_sheet(posterior: xr.Dataset) -> Facts:
    """Say what a posterior over goals holds."""
    missing = int((posterior["observed"].values == 0).sum())
    samples = posterior.sizes["sample"]
    return [
        ("trials", f"{posterior.sizes['trial']:,}"),
        *_people(posterior),
        *_times(posterior),
        ("units of position", _units(posterior)),
        ("samples not seen", f"{missing:,} ({100 * missing / samples:.2g} %)"),
        ("outliers gated", f"{int(posterior.attrs.get('outliers_gated', 0)):,}"),
        *_goals(posterior),
    ]


def _people(data: xr.Dataset) -> Facts:
    people = np.unique(data["participant"].values.astype(str))
    facts = [("participants", f"{len(people):,}")]
    if "condition" in data:
        facts.append(("trials by condition", counted(data["condition"].values.astype(str).tolist())))
    if "round" in data:
        rounds = np.unique(data["round"].values)
        facts.append(("rounds", listed([str(one) for one in rounds.tolist() if one >= 0])))
    return facts


def _times(data: xr.Dataset) -> Facts:
    sizes = data["row_size"].values
    starts = trial_starts(data)
    time = data["time"].values
    duration = time[starts + sizes - 1] - time[starts]
    many = sizes > 1
    step = float(np.median(duration[many] / (sizes[many] - 1))) if many.any() else float("nan")
    return [
        ("samples", f"{data.sizes['sample']:,}"),
        ("recorded time", shown_time(float(duration.sum()))),
        (
            "time between samples",
            f"{step:.3g} s (median over trials)" if many.any() else "one sample a trial",
        ),
        ("samples a trial", f"{sizes.min():,} to {sizes.max():,} (median {np.median(sizes):,.0f})"),
    ]


def _controllers(log: xr.Dataset, agents: Sequence[str]) -> Facts:
    if "controller" not in log or log["controller"].dims != ("trial", "agent"):
        return []
    names = log["controller"].values.astype(str)
    return [
        (f"who controlled {agent}", counted(names[:, index].tolist()))
        for index, agent in enumerate(agents)
        if (names[:, index] != "").any()
    ]


def _motion(log: xr.Dataset, agents: Sequence[str]) -> Facts:
    unseen = (log["observed"].values == 0).mean(axis=0)
    told = [f"{agent}: {100 * share:.2g} %" for agent, share in zip(agents, unseen.tolist(), strict=True)]
    facts = [
        ("coordinates", f"{', '.join(str(name) for name in log['space'].values)}, in {_units(log)}"),
        ("samples not seen", ", ".join(told[:12]) + ", ..." * (len(told) > 12)),
    ]
    logged = []
    for name, called in (("velocity", "velocities"), ("control", "controls")):
        if f"has_{name}" in log:
            whose = [agent for agent, has in zip(agents, log[f"has_{name}"].values, strict=True) if has]
            if whose:
                logged.append(f"{called} of {', '.join(whose[:12])}")
    facts.append(("logged besides positions", "; ".join(logged) or "neither velocities nor controls"))
    return facts


def _goals(data: xr.Dataset) -> Facts:
    if "goal_position" not in data:
        return [("goals", "none")]
    moving = data["goal_position"].dims[0] == "sample"
    known = int(sum(str(goal) != "" for goal in data["true_goal"].values)) if "true_goal" in data else 0
    segments = f"{data.sizes.get('segment', 0):,} ({known:,} with a known true goal)"
    if "segment_agent" in data and data.sizes["segment"]:
        segments += f"; {counted(data['segment_agent'].values.astype(str).tolist())}"
    return [
        ("goals", listed([str(goal) for goal in data["goal"].values])),
        ("goals' places", "may change within trials" if moving else "fixed within each trial"),
        ("segments", segments),
    ]


def _units(data: xr.Dataset) -> str:
    return str(data["position"].attrs.get("units", "m"))
