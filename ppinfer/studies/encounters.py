"""From a study log to the evidence of goal and personality: the motion of a human and of a robot among goals."""

from __future__ import annotations

import numpy as np
import xarray as xr

from ppinfer.distributions.ragged import row_starts
from ppinfer.goals.yielding import EncounterEvidence
from ppinfer.studies.goal_evidence import goal_evidence


def encounter_evidence(
    log: xr.Dataset, *, human: str = "human", robot: str = "robot", time_step: float | None = None
) -> EncounterEvidence:
    """Return the evidence that a log holds about where a human is heading and whether it yields to a robot.

    A row begins wherever goals change; what is known of the human's personality is kept throughout a trial.

    Parameters
    ----------
    log : xarray.Dataset
        A study log with goals.
    human, robot : str
        The agent whose goal and personality are asked for, and the one it may yield to.
    time_step : float, optional
        Nominal seconds between samples; default: the median of this log.

    Raises
    ------
    LogError
        Where an agent is unknown, or the log holds no goals.

    Examples
    --------
    >>> from ppinfer.goals.yielding import Yielding
    >>> from ppinfer.studies import build_log
    >>> log = build_log(
    ...     agents=["human", "robot"], goals=["cup", "pan"], row_size=[3], time=[0.0, 0.1, 0.2],
    ...     position=np.arange(12.0).reshape(3, 2, 2), goal_position=np.array([[9.0, 0.0], [9.0, 9.0]]), trial_id=["a"],
    ... )
    >>> Yielding().infer(encounter_evidence(log))
    Distribution p(goal, theta; sample): sample 3, goal 2, theta 2
    """
    one, other = (
        goal_evidence(log, agent, time_step=time_step, partner=partner)
        for agent, partner in ((human, robot), (robot, human))
    )
    trial = np.searchsorted(row_starts(log["row_size"].values), one.row_start, side="right") - 1
    return EncounterEvidence(one, other, trial)
