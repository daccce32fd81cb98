"""Comparing posteriors on the same segments: paired differences with intervals over participants."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass

import numpy as np
import xarray as xr
from jaxtyping import Float, Int

from ppinfer.errors import LogError
from ppinfer.studies.resampling import cluster_sums, resampled_sums
from ppinfer.studies.scores import DEFAULT_SHARES, score_segments
from ppinfer.studies.segment_selection import SegmentSelection, require_segments, select_segments

SegmentKey = tuple[str, int, int]
_INTERVAL = (2.5, 97.5)


@dataclass(frozen=True)
class Difference:
    """One posterior minus the first one, after one share of each segment.

    Attributes
    ----------
    name, against
        The posterior and the one it is compared with.
    at
        The share of the segment seen.
    accuracy, accuracy_low, accuracy_high
        Mean difference of the accuracy and its 95 % interval over participants (NaN for one participant).
    mean_log_posterior, mean_log_posterior_low, mean_log_posterior_high
        The same of the log posterior of the true goal; infinite or NaN where some true goal was held
        impossible.
    impossible
        Segments whose true goal had probability zero in either posterior.
    segments, participants
        How many were compared.
    """

    name: str
    against: str
    at: float
    accuracy: float
    accuracy_low: float
    accuracy_high: float
    mean_log_posterior: float
    mean_log_posterior_low: float
    mean_log_posterior_high: float
    impossible: int
    segments: int
    participants: int


@dataclass(frozen=True)
class PosteriorScore:
    """The score of one posterior on the segments that are compared."""

    name: str
    at: float
    accuracy: float
    mean_log_posterior: float


@dataclass(frozen=True)
class Comparison:
    """Scores of several posteriors on the same segments, and paired differences from the first.

    Attributes
    ----------
    scores
        One for every posterior and share.
    differences
        One for every later posterior and share.
    left_out
        How many segments were left out, by reason; ``not_in_every_posterior`` when only common ones were
        compared.
    """

    scores: tuple[PosteriorScore, ...]
    differences: tuple[Difference, ...]
    left_out: dict[str, int]

    @property
    def warnings(self) -> list[str]:
        """What a reader of the numbers has to know."""
        found = [
            f"{each.name} against {each.against} at {each.at:g}: the true goal of {each.impossible} of "
            f"{each.segments} "
            "segments has probability zero in one of them, so the mean difference of the log posterior is "
            "undefined"
            for each in self.differences
            if each.impossible
        ]
        if self.differences and self.differences[0].participants < 2:
            found.append("one participant only: no intervals over participants")
        return found

    def to_json(self) -> dict[str, object]:
        """Return what ``ppinfer compare --json`` prints."""
        return {
            "scores": [asdict(each) for each in self.scores],
            "differences": [asdict(each) for each in self.differences],
            "left_out": self.left_out,
            "warnings": self.warnings,
        }


def compare_posteriors(
    posteriors: Mapping[str, xr.Dataset],
    *,
    at: Sequence[float] = DEFAULT_SHARES,
    min_samples: int | None = None,
    min_distance: float | None = None,
    participants: Sequence[str] | None = None,
    exclude: Sequence[str] | None = None,
    common_only: bool = False,
    resamples: int = 10_000,
    seed: int = 0,
) -> Comparison:
    """Compare posteriors of the same trials: every later one against the first, segment by segment.

    1. The segments are chosen by the first posterior; all others must hold the same ones (trial, samples)
    with the
       same true goals.
    2. Each segment is scored in every posterior (`ppinfer.studies.scores.score_segments`).
    3. Differences are averaged over segments. Their interval is the percentile bootstrap over participants,
    who are
       drawn with all their segments.

    Parameters
    ----------
    posteriors
        At least two, by name; the first is what the others are compared with.
    at, min_samples, min_distance, participants, exclude
        As in `ppinfer.studies.scores.score_posterior`.
    common_only
        Compare the segments that all posteriors share, instead of refusing posteriors whose segments differ.
    resamples, seed
        Resamples of the participants and the seed of the draws; the same draws serve every difference.

    Raises
    ------
    LogError
        If the posteriors are not of the same agent and segments, saying which differ, or nothing is left to
        compare.

    Examples
    --------
    >>> from ppinfer.goals import GoalLQR, NearestGoal
    >>> from ppinfer.studies import infer_log
    >>> from ppinfer.testing import example_log
    >>> log = example_log()
    >>> both = {model.name: infer_log(log, model) for model in (NearestGoal(), GoalLQR())}
    >>> found = compare_posteriors(both, at=[0.5], resamples=100)
    >>> [(each.name, each.against) for each in found.differences]
    [('goal-lqr', 'nearest')]
    """
    if len(posteriors) < 2:
        raise LogError(f"at least two posteriors are expected, got {len(posteriors)}")
    if resamples < 1:
        raise LogError(f"resamples is {resamples}; at least 1 is expected")
    names = list(posteriors)
    _refuse_other_agents(posteriors)
    first = posteriors[names[0]]
    selected = select_segments(
        first, min_samples=min_samples, min_distance=min_distance, participants=participants, exclude=exclude
    )
    require_segments(selected)
    every = {name: select_segments(each) for name, each in posteriors.items()}
    keys = {name: _keys(posteriors[name], every[name]) for name in names}
    if not common_only:
        _refuse_other_segments(keys)
    common = [key for key in _keys(first, selected) if all(key in each for each in keys.values())]
    _refuse_other_goals(posteriors, every, keys, common)
    left_out = dict(selected.left_out)
    if common_only:
        left_out["not_in_every_posterior"] = len(selected.index) - len(common)
    scored = {
        name: score_segments(posteriors[name], _reordered(every[name], keys[name], common), at=at)
        for name in names
    }
    kept = _reordered(every[names[0]], keys[names[0]], common)
    scores = tuple(
        PosteriorScore(
            name, float(share), float(each["correct"][i].mean()), float(each["log_posterior"][i].mean())
        )
        for name, each in scored.items()
        for i, share in enumerate(each["at"].values)
    )
    differences = tuple(
        difference
        for name in names[1:]
        for difference in _differences(scored, name, names[0], kept, resamples, seed)
    )
    return Comparison(scores, differences, left_out)


def _differences(
    scored: Mapping[str, xr.Dataset],
    name: str,
    against: str,
    kept: SegmentSelection,
    resamples: int,
    seed: int,
) -> list[Difference]:
    one, other = scored[name], scored[against]
    logs = one["log_posterior"].values, other["log_posterior"].values
    impossible = (np.isneginf(logs[0]) | np.isneginf(logs[1])).sum(axis=1)
    with np.errstate(invalid="ignore"):  # -inf - -inf: undefined, and reported as such
        values = np.stack([one["correct"].values - other["correct"].values, logs[0] - logs[1]], axis=1)
        means = values.mean(axis=-1)
    low, high = _intervals(values, kept, resamples, np.random.default_rng(seed))
    return [
        Difference(
            name=name,
            against=against,
            at=share,
            accuracy=float(means[i, 0]),
            accuracy_low=float(low[i, 0]),
            accuracy_high=float(high[i, 0]),
            mean_log_posterior=float(means[i, 1]),
            mean_log_posterior_low=float(low[i, 1]),
            mean_log_posterior_high=float(high[i, 1]),
            impossible=int(impossible[i]),
            segments=len(kept.index),
            participants=len(np.unique(kept.participant)),
        )
        for i, share in enumerate(one["at"].values.tolist())
    ]


def _intervals(
    values: Float[np.ndarray, "at statistic segment"],
    kept: SegmentSelection,
    resamples: int,
    rng: np.random.Generator,
) -> tuple[Float[np.ndarray, "at statistic"], Float[np.ndarray, "at statistic"]]:
    people, participant = np.unique(kept.participant, return_inverse=True)
    shape = values.shape[:-1]
    if len(people) < 2:
        return np.full(shape, np.nan), np.full(shape, np.nan)
    finite = np.isfinite(values).all(axis=-1)
    flat = np.where(finite[..., None], values, 0.0).reshape(-1, values.shape[-1])
    counted = np.concatenate([np.ones((1, flat.shape[1])), flat])
    drawn = resampled_sums(cluster_sums(counted, participant, len(people)), resamples=resamples, rng=rng)
    low, high = np.percentile(drawn[:, 1:] / drawn[:, :1], _INTERVAL, axis=0)
    return (
        np.where(finite, low.reshape(shape), np.nan),
        np.where(finite, high.reshape(shape), np.nan),
    )


def _keys(posterior: xr.Dataset, selection: SegmentSelection) -> dict[SegmentKey, int]:
    index = selection.index
    trial = posterior["trial_id"].values[posterior["segment_trial"].values[index]]
    start = posterior["segment_start"].values[index].tolist()
    stop = posterior["segment_stop"].values[index].tolist()
    keys = [(str(name), first, last) for name, first, last in zip(trial, start, stop, strict=True)]
    return {key: i for i, key in enumerate(keys)}


def _refuse_other_segments(keys: Mapping[str, dict[SegmentKey, int]]) -> None:
    first, *others = keys
    for name in others:
        for one, other in ((first, name), (name, first)):
            missing = [key for key in keys[one] if key not in keys[other]]
            if missing:
                raise LogError(
                    f"{other} lacks {len(missing)} of the {len(keys[one])} segments of {one}, such as "
                    f"{_describe(missing[0])}; compare posteriors of the same log, or ask for the common "
                    "segments only"
                )


def _refuse_other_goals(
    posteriors: Mapping[str, xr.Dataset],
    every: Mapping[str, SegmentSelection],
    keys: Mapping[str, dict[SegmentKey, int]],
    common: Sequence[SegmentKey],
) -> None:
    if not common:
        raise LogError("the posteriors have no segment in common that can be scored")
    first, *others = posteriors
    goals = {
        name: np.array([str(goal) for goal in each["goal"].values])[
            every[name].true_goal[[keys[name][key] for key in common]]
        ]
        for name, each in posteriors.items()
    }
    for name in others:
        for i in np.flatnonzero(goals[first] != goals[name])[:1].tolist():
            raise LogError(
                f"{_describe(common[i])}: the true goal is {str(goals[first][i])!r} in {first} and "
                f"{str(goals[name][i])!r} in {name}; compare posteriors of the same log"
            )


def _describe(key: SegmentKey) -> str:
    return f"trial {key[0]!r}, samples [{key[1]}, {key[2]})"


def _reordered(
    selection: SegmentSelection, keys: Mapping[SegmentKey, int], wanted: Sequence[SegmentKey]
) -> SegmentSelection:
    order: Int[np.ndarray, " segment"] = np.array([keys[key] for key in wanted], dtype=np.int64)
    return SegmentSelection(
        index=selection.index[order],
        first=selection.first[order],
        length=selection.length[order],
        true_goal=selection.true_goal[order],
        participant=selection.participant[order],
        participants=selection.participants,
        left_out=selection.left_out,
    )


def _refuse_other_agents(posteriors: Mapping[str, xr.Dataset]) -> None:
    agents = {name: str(each.attrs.get("agent", "")) for name, each in posteriors.items()}
    first = next(iter(agents))
    for name, agent in agents.items():
        if agent != agents[first]:
            raise LogError(
                f"{first} is about agent {agents[first]!r} and {name} about {agent!r}; compare one agent"
            )
