"""Fitting a goal model to motion whose goals are known: by what it predicts, or by its likelihood."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable, Collection
from dataclasses import dataclass
from typing import Literal

import numpy as np
from jaxtyping import Float, Int

from ppinfer.errors import ModelError
from ppinfer.goals.belief import infer_goals
from ppinfer.goals.evidence import GoalEvidence
from ppinfer.goals.lqr import GoalLQR
from ppinfer.goals.model import GoalModel
from ppinfer.goals.motion import causal_motion
from ppinfer.goals.quadratic import quadratic_form

Objective = Literal["predictive", "likelihood"]


def _logit(value: float) -> float:
    return math.log(value / (1 - value))


def _expit(value: float) -> float:
    return 1 / (1 + math.exp(-value)) if value >= 0 else math.exp(value) / (1 + math.exp(value))


@dataclass(frozen=True)
class _Scale:
    """How a parameter is searched: on which scale, and within which bounds."""

    least: float
    most: float
    to: Callable[[float], float]
    back: Callable[[float], float]

    def start(self, value: float) -> float:
        """Return where a search begins that is asked to begin at `value`: a little inside the bounds."""
        return self.to(min(max(value, self.least / 10 if self.least < 0 else 10 * self.least), self._below))

    @property
    def bounds(self) -> tuple[float, float]:
        return self.to(self.least), self.to(self.most)

    @property
    def _below(self) -> float:
        return 1 - 10 * (1 - self.most) if self.most < 1 else self.most / 10


def _same(value: float) -> float:
    return value


#: How a parameter may be searched, by what models call it: a positive number, a share, or any number of order one.
SCALES = {
    "log": _Scale(1e-12, 1e12, math.log, math.exp),
    "logit": _Scale(1e-7, 1 - 1e-7, _logit, _expit),
    "linear": _Scale(-1e3, 1e3, _same, _same),
}
# how far the first steps of a search reach on each parameter's scale
_CONTROL_WEIGHTS = np.geomspace(0.1, 1000.0, 9)
_FIRST_STEP = 0.7
# steps of the differences, and the relative gain at which an ascent ends
_DIFFERENCE = 1e-6
_FLAT = 1e-11
# standard deviation, on the scales of the search, of the prior of a model with many parameters about where it starts
_PRIOR_SPREAD = 1.0
# the plain model without a floor is taken where it predicts as well as this
_AS_GOOD = 1e-6
# on the scales of the search; e^3 on the logarithmic one
_NEAR_BOUND = 3.0
_WORST = -745.0


@dataclass(frozen=True, eq=False)
class LabelledEvidence:
    """Evidence together with the goal that was pursued, where it is known.

    Parameters
    ----------
    evidence : GoalEvidence
        Rows, all of them restarting.
    true_goal : (sample,) int64
        Index of the goal pursued at each sample; -1 where it is not known.
    weight : (sample,) float64
        How much each sample counts; zero where the goal is not known. Sums to one.
    """

    evidence: GoalEvidence
    true_goal: Int[np.ndarray, " sample"]
    weight: Float[np.ndarray, " sample"]

    def __post_init__(self) -> None:
        if not (self.weight > 0).any():
            raise ModelError(
                "no sample has a known goal, so there is nothing to fit; the log needs segments with true_goal"
            )


@dataclass(frozen=True)
class Fit:
    """A fitted model and how it was found.

    Parameters
    ----------
    model : GoalModel
        With the fitted parameters.
    objective : {"predictive", "likelihood"}
        What was maximised.
    value : float
        The mean log posterior of the true goal, or the mean log likelihood of a control, at the maximum.
    evaluations : int
        How often the objective was evaluated.
    converged : bool
        Whether the search stopped by its own tolerance.
    at_bound : tuple of str
        Parameters that ended at a bound of the search: the data do not say how much further they want to go.
    """

    model: GoalModel
    objective: Objective
    value: float
    evaluations: int
    converged: bool
    at_bound: tuple[str, ...] = ()


def fit_goals(
    model: GoalModel,
    data: LabelledEvidence,
    *,
    objective: Objective = "predictive",
    fixed: Collection[str] = (),
) -> Fit:
    """Return the model with its parameters fitted to motion whose goals are known.

    ``predictive`` maximises the weighted mean log posterior of the true goal over all samples: what a user of the
    posterior is scored by. The posterior depends on the product of rationality and tempering only, so for goal-lqr that
    product is fitted, together with the control weight, ``stay`` and the evidence floor; then rationality is set to its
    likelihood estimate at that control weight, and tempering to what remains. On people, whose residuals are correlated
    from sample to sample, it is far from 1. Where one of the two is fixed, the other is fitted. ``stay`` is fitted as
    if one more change of mind had been seen than was (log(1 - stay) / samples is added to the objective): people who
    never changed theirs do not make a change impossible. The floor is set to 0 where that predicts as well.

    A model with many parameters that trade off against each other (``search = "gradient"``, goal-coupled) has a weak
    prior: each parameter is normal about where the search starts, with standard deviation 1 on the scale that it is
    searched on (a factor e), worth as much as one stretch of motion among all. So the maximum does not depend on the
    order of the data, and a few segments do not drive a parameter to its bounds.

    ``likelihood`` (goal-lqr only) maximises the likelihood (22) of the controls given the true goals; tempering is 1
    and there is no evidence floor.

    Parameters
    ----------
    model : GoalModel
        Its parameters in `fixed` stay; the others in its ``parameter_scales`` are fitted (and tempering with goal-lqr);
        those that are not there, such as ``dynamics``, are never changed. Its class says how they are searched for
        (``search``) and from where (``starts``, or else from what they are).
    data : LabelledEvidence
        What to fit to.
    objective : {"predictive", "likelihood"}
        What to maximise.
    fixed : collection of str
        Parameters to leave as they are.

    Raises
    ------
    ModelError
        Where nothing is left to fit, or the model has no such objective.

    Examples
    --------
    >>> from ppinfer.goals import GoalDesign, GoalLQR
    >>> rng = np.random.default_rng(0)
    >>> design = GoalDesign.random(rng, rows=60, samples=30)
    >>> evidence = GoalLQR(control_weight=5.0, rationality=0.5).simulate(design, rng)
    >>> true_goal = np.repeat(design.true_goal, design.row_size)
    >>> data = LabelledEvidence(evidence, true_goal, np.full(len(true_goal), 1 / len(true_goal)))
    >>> fitted = fit_goals(GoalLQR(), data, objective="likelihood").model
    >>> abs(fitted.control_weight / 5 - 1) < 0.2, abs(fitted.rationality / 0.5 - 1) < 0.2
    (True, True)
    """
    if objective not in ("predictive", "likelihood"):
        raise ModelError(f"unknown objective {objective!r}: expected 'predictive' or 'likelihood'")
    unknown = sorted(set(fixed) - set(model.parameters))
    if unknown:
        raise ModelError(f"model {model.name!r} has no parameter {unknown[0]!r} to hold fixed")
    if objective == "likelihood":
        if not isinstance(model, GoalLQR) or model.agent is not None:
            raise ModelError(
                "the likelihood objective is that of goal-lqr with its own parameters; use 'predictive'"
            )
        return _fit_likelihood(model, data, fixed)
    free = _free_parameters(model, fixed)
    if not free:
        raise ModelError(
            f"model {model.name!r} has nothing left to fit: everything that can be fitted is held fixed"
        )
    from threadpoolctl import threadpool_limits

    # thousands of tiny matrix products: threads would only wait for each other, and their number must not matter
    with threadpool_limits(limits=1, user_api="blas"):
        return _fit_predictive(model, data, free)


def _free_parameters(model: GoalModel, fixed: Collection[str]) -> list[str]:
    free = list(model.parameter_scales)
    if isinstance(model, GoalLQR):
        # the matrices of an agent of one's own are not touched; how its evidence is weighed is open all the same
        free = ["stay", "evidence_floor"] if model.agent is not None else free
        free.append("tempering")
    return [name for name in free if name not in fixed]


def predictive_score(model: GoalModel, data: LabelledEvidence) -> float:
    """Return the weighted mean log posterior of the true goal; -745 (the log of the least float) stands for -inf."""
    counted = np.flatnonzero(data.weight > 0)
    log_posterior = infer_goals(model, data.evidence).log_posterior[counted, data.true_goal[counted]]
    return float((np.maximum(log_posterior, _WORST) * data.weight[counted]).sum())


def _fit_predictive(model: GoalModel, data: LabelledEvidence, free: list[str]) -> Fit:
    starts = {name: value for name, value in model.starts.items() if name in free}
    base = _coarse_start(model.with_parameters(**starts), data, free)
    # the posterior knows the product of rationality and tempering only: tempering is taken apart afterwards
    merged = isinstance(base, GoalLQR) and {"rationality", "tempering"} <= set(free)
    if merged:
        free = [name for name in free if name != "tempering"]
    kinds = [_scale_name(model, name) for name in free]
    scales = [SCALES[kind] for kind in kinds]

    def at(point: Float[np.ndarray, " free"]) -> GoalModel:
        values = {name: scale.back(float(x)) for name, scale, x in zip(free, scales, point, strict=True)}
        return base.with_parameters(**values)

    begin = base.parameters
    start = np.array([scale.start(float(begin[name])) for name, scale in zip(free, scales, strict=True)])
    bounds = [scale.bounds for scale in scales]
    seen = int((data.weight > 0).sum())

    def objective(point: Float[np.ndarray, " free"]) -> float:
        model = at(point)
        # as if one more change of mind had been seen: people of whom none was seen may change theirs tomorrow
        caution = math.log1p(-model.stay) / seen if "stay" in free else 0.0
        return predictive_score(model, data) + caution

    if model.search == "gradient":
        stretches = len(np.unique(data.evidence.row_of_sample[data.weight > 0]))

        def regularised(point: Float[np.ndarray, " free"]) -> float:
            # many parameters trade off against each other: a few segments, or their order, must not decide
            return objective(point) - float(((point - start) ** 2).sum()) / (2 * _PRIOR_SPREAD**2 * stretches)

        point, _, evaluations, converged = _ascend(regularised, start, bounds)
    else:
        point, _, evaluations, converged = _climb(objective, start, bounds)
    fitted = at(point)
    value = predictive_score(fitted, data)
    at_bound = tuple(
        name
        for name, kind, x, (low, high) in zip(free, kinds, point, bounds, strict=True)
        # a share may well be all or nothing
        if kind != "logit" and min(x - low, high - x) < _NEAR_BOUND
    )
    if "evidence_floor" in free:
        plain = fitted.with_parameters(evidence_floor=0.0)
        plain_value = predictive_score(plain, data)
        if plain_value >= value - _AS_GOOD:
            fitted, value = plain, plain_value
    if merged and isinstance(fitted, GoalLQR):
        beta, _ = _control_likelihood(fitted, data, fit_rationality=True)
        fitted = dataclasses.replace(fitted, rationality=beta, tempering=fitted.rationality / beta)
    return Fit(fitted, "predictive", value, evaluations, converged, at_bound)


def _coarse_start(model: GoalModel, data: LabelledEvidence, free: list[str]) -> GoalModel:
    """Return the best of a few control weights, each with the rationality that its likelihood asks for, tempered."""
    candidates: list[GoalModel] = []
    if isinstance(model, GoalLQR) and model.agent is None and {"control_weight", "rationality"} & set(free):
        weights = _CONTROL_WEIGHTS if "control_weight" in free else [model.control_weight]
        model = dataclasses.replace(model, tempering=1.0) if "tempering" in free else model
        for weight in weights:
            agent = dataclasses.replace(model, control_weight=float(weight))
            beta = (
                _control_likelihood(agent, data, fit_rationality=True)[0]
                if "rationality" in free
                else model.rationality
            )
            tempers = (1.0, 0.3, 0.1) if "rationality" in free else (1.0,)
            candidates += [dataclasses.replace(agent, rationality=beta * temper) for temper in tempers]
    elif model.search == "gradient":
        return model
    else:
        positive = [name for name in free if _scale_name(model, name) == "log"]
        begin = model.parameters
        for factor in (0.1, 0.3, 1.0, 3.0, 10.0):
            candidates.append(
                model.with_parameters(**{name: float(begin[name]) * factor for name in positive})
            )
    return max(candidates, key=lambda candidate: predictive_score(candidate, data))


def _scale_name(model: GoalModel, name: str) -> str:
    return {"tempering": "log", **model.parameter_scales}[name]


def _fit_likelihood(model: GoalLQR, data: LabelledEvidence, fixed: Collection[str]) -> Fit:
    free = [name for name in ("control_weight", "rationality") if name not in fixed]
    if not free:
        raise ModelError(
            "control_weight and rationality are both fixed, so the likelihood has nothing to fit"
        )
    model = dataclasses.replace(model, tempering=1.0, evidence_floor=0.0)

    def profile(point: Float[np.ndarray, " 1"]) -> float:
        candidate = dataclasses.replace(model, control_weight=float(np.exp(point[0])))
        return _control_likelihood(candidate, data, fit_rationality="rationality" in free)[1]

    evaluations, converged = 1, True
    if "control_weight" in free:
        best = max(np.log(_CONTROL_WEIGHTS), key=lambda start: profile(np.array([start])))
        point, _, evaluations, converged = _climb(profile, np.array([best]), [SCALES["log"].bounds])
        model = dataclasses.replace(model, control_weight=float(np.exp(point[0])))
    beta, value = _control_likelihood(model, data, fit_rationality="rationality" in free)
    return Fit(dataclasses.replace(model, rationality=beta), "likelihood", value, evaluations, converged)


def _control_likelihood(
    model: GoalLQR, data: LabelledEvidence, *, fit_rationality: bool
) -> tuple[float, float]:
    """Return the rationality and the weighted mean log likelihood of the controls given the true goals.

    With e the residual of a control, the mean of log p is 1/2 log det(2 beta S / 2 pi) - beta E[e'Se], whose maximum
    lies at beta = m / (2 E[e'Se]).
    """
    evidence = data.evidence
    agent = model.agent_at(evidence.dt, evidence.position.shape[1])
    motion = causal_motion(evidence, agent.dynamics)
    counted = np.flatnonzero((data.weight > 0) & motion.informative)
    if len(counted) == 0:
        raise ModelError("no labelled sample tells of a control; rows need at least two samples")
    weight = data.weight[counted] / data.weight[counted].sum()
    goals = evidence.goals[evidence.row_of_sample[counted], data.true_goal[counted]]
    best = agent.mean_control(motion.state[counted], agent.dynamics.goal_states(goals))
    mean_square = float(weight @ quadratic_form(motion.control[counted] - best, agent.S))
    if not mean_square > 0:
        raise ModelError(
            "the controls follow the model without any noise (or there is no motion): no rationality fits"
        )
    m = agent.dynamics.controls
    beta = 0.5 * m / mean_square if fit_rationality else model.rationality
    _, log_determinant = np.linalg.slogdet(agent.S)
    value = 0.5 * (float(log_determinant) + m * math.log(beta / math.pi)) - beta * mean_square
    return beta, value


def _climb(
    objective: Callable[[Float[np.ndarray, " free"]], float],
    start: Float[np.ndarray, " free"],
    bounds: list[tuple[float, float]],
) -> tuple[Float[np.ndarray, " free"], float, int, bool]:
    from scipy.optimize import minimize

    simplex = np.vstack([start, start + _FIRST_STEP * np.eye(len(start))])

    def cost(point: np.ndarray) -> float:
        return -objective(point)

    found = minimize(
        cost,
        start,
        method="Nelder-Mead",
        bounds=bounds,
        options={"initial_simplex": simplex, "xatol": 2e-3, "fatol": 1e-6, "maxfev": 300 * len(start)},
    )
    return np.asarray(found.x), -float(found.fun), int(found.nfev), bool(found.success)


def _ascend(
    objective: Callable[[Float[np.ndarray, " free"]], float],
    start: Float[np.ndarray, " free"],
    bounds: list[tuple[float, float]],
) -> tuple[Float[np.ndarray, " free"], float, int, bool]:
    """Climb along gradients by differences: for smooth objectives of many parameters that begin near the top."""
    from scipy.optimize import minimize

    def cost(point: np.ndarray) -> float:
        return -objective(point)

    found = minimize(
        cost,
        start,
        method="L-BFGS-B",
        jac="2-point",
        bounds=bounds,
        options={"eps": _DIFFERENCE, "ftol": _FLAT, "gtol": 1e-6, "maxiter": 200},
    )
    return np.asarray(found.x), -float(found.fun), int(found.nfev), bool(found.success)
