"""A study of two arms: scenes, robots and simulated humans, every robot with every human in every scene."""

from __future__ import annotations

from dataclasses import asdict, dataclass, field
from functools import cached_property
from typing import Any

import numpy as np

from ppinfer.coordination import Policy
from ppinfer.studies import RecordingHeader, Trial
from ppinfer.studies.personality_models import personality_text
from ppinfer.studies.replans import Replan
from ppsim.arms.execution import PLAN_SETS, Execution
from ppsim.arms.geometry import ARMS
from ppsim.arms.playing import Played, play
from ppsim.arms.robots import HUMANS, ROBOTS, checked_names, make_human, make_robot
from ppsim.arms.scene import Scene
from ppsim.arms.world import STEP
from ppsim.errors import SimulationError
from ppsim.seeds import trial_seed

AGENTS = tuple(ARMS)
ROBOT, HUMAN = AGENTS


@dataclass(frozen=True)
class ArmsStudy:
    """All that a study of two arms is, its seed included: trial i is a function of this and of i.

    Trials run over robots first, then humans, plan sets and scenes, so that a study of more scenes begins with the same
    trials. Those of one scene share what has to be picked and placed, and the seeds of all plans: they are paired.

    Parameters
    ----------
    scenes : int
        How many.
    robots, humans : tuple of str
        Names of `ROBOTS` and `HUMANS`, or ``module:attribute`` of a policy of one's own.
    plan_sets : tuple of {"shared", "independent"}
        Whether both agents look at the same plans, or each samples its own.
    seed : int
        Of the study.
    cost_unit : float
        Seconds that count as one unit of cost in the norm of the robot "bayes"; the paper's literal one is 1 s.
    execution : Execution
        How plans are judged and carried out.

    Raises
    ------
    SimulationError
        If there is no scene, or a name is unknown or given twice.
    ModelError
        If a robot's model of personality is none that a log can keep.

    Examples
    --------
    >>> study = ArmsStudy(scenes=2, robots=("norm",), humans=("selfish",), seed=3)
    >>> study.trials, study.trial_id(1)
    (2, 'scene-1/shared/norm/selfish')
    """

    scenes: int = 10
    robots: tuple[str, ...] = ("norm", "bayes")
    humans: tuple[str, ...] = tuple(HUMANS)
    plan_sets: tuple[str, ...] = ("shared",)
    seed: int = 0
    cost_unit: float = 100.0
    execution: Execution = field(default_factory=Execution)

    def __post_init__(self) -> None:
        for name in ("robots", "humans", "plan_sets"):
            object.__setattr__(self, name, tuple(getattr(self, name)))
        if self.scenes < 1:
            raise SimulationError(f"scenes must be at least 1; got {self.scenes}")
        if self.seed < 0:
            raise SimulationError(f"seed must be at least 0; got {self.seed}")
        if not 0.0 < self.cost_unit < 1e6:
            raise SimulationError(f"cost_unit must be a positive number of seconds; got {self.cost_unit!r}")
        checked_names("plan sets", self.plan_sets, PLAN_SETS)
        checked_names("robots", self.robots, ROBOTS, own=True)
        checked_names("humans", self.humans, HUMANS, own=True)
        # whatever cannot be played or logged is told now
        for robot, human in self._pairs:
            model = self.policies(robot, human)[ROBOT].belief_model()
            if model is not None:
                personality_text(model)

    @cached_property
    def _theta(self) -> tuple[str, ...]:
        """All that some robot may believe of the human: whom equilibria favour, and more where a model knows more."""
        models = [self.policies(robot, human)[ROBOT].belief_model() for robot, human in self._pairs]
        labels = [label for model in models if model is not None for label in model.theta(AGENTS).labels]
        return tuple(dict.fromkeys([*AGENTS, *map(str, labels)]))

    @property
    def trials(self) -> int:
        """How many trials there are."""
        return self.scenes * len(self.plan_sets) * len(self._pairs)

    @cached_property
    def _pairs(self) -> tuple[tuple[str, str], ...]:
        return tuple((robot, human) for human in self.humans for robot in self.robots)

    def cell(self, index: int) -> tuple[int, str, str, str]:
        """Return scene, plan sets, robot and human of a trial."""
        rest, pair = divmod(index, len(self._pairs))
        scene, sets = divmod(rest, len(self.plan_sets))
        robot, human = self._pairs[pair]
        return scene, self.plan_sets[sets], robot, human

    def trial_id(self, index: int) -> str:
        """Return the name of a trial."""
        scene, plan_sets, robot, human = self.cell(index)
        return f"scene-{scene}/{plan_sets}/{robot}/{human}"

    def policies(self, robot: str, human: str) -> dict[str, Policy]:
        """Return who plays whom."""
        other = make_human(human)
        return {ROBOT: make_robot(robot, other, cost_unit=self.cost_unit), HUMAN: other}

    def scene(self, number: int) -> Scene:
        """Return what has to be picked and placed in a scene."""
        return Scene.random(np.random.default_rng(trial_seed(self.seed, number)))

    def header(self) -> RecordingHeader:
        """Return what a recording of this study says once."""
        return RecordingHeader(
            agents=AGENTS,
            space=("shoulder", "elbow"),
            position_units="rad",
            title="Simulated parallel play: two arms, each with an object to pick and place",
            source="ppsim study",
            theta=self._theta,
            configuration=self.configuration(),
        )

    def configuration(self) -> dict[str, Any]:
        """Return the parameters as JSON can hold them."""
        return {
            "world": "arms",
            **{
                name: list(value) if isinstance(value, tuple) else value
                for name, value in asdict(self).items()
            },
            "dt": STEP,
            "arms": {agent: asdict(arm) for agent, arm in ARMS.items()},
        }

    def trial(self, index: int) -> Trial:
        """Play trial `index` and return what is logged of it."""
        number, plan_sets, robot, human = self.cell(index)
        policies = self.policies(robot, human)
        seed = trial_seed(self.seed, number)
        scene = self.scene(number)
        played = play(scene, policies, seed=seed, plan_sets=plan_sets, execution=self.execution)
        return Trial(
            trial_id=self.trial_id(index),
            participant=f"simulated {human}",
            time=np.arange(len(played.held)) * STEP,
            position=played.position,
            velocity=played.velocity,
            condition=f"{robot}, {plan_sets} plan sets",
            seed=seed,
            outcome="timeout" if np.isnan(played.finish_time).any() else "completed",
            controller={ROBOT: robot, HUMAN: human},
            replans=[Replan.of(one.situation, ROBOT, one.sample, one.decision) for one in played.replans],
            variables=_variables(played, scene, number, plan_sets, policies[ROBOT]),
        )


def _variables(
    played: Played, scene: Scene, number: int, plan_sets: str, robot: Policy
) -> dict[str, tuple[Any, ...]]:
    model = robot.belief_model()
    tips = np.stack(
        [scene.arms[agent].end_effector(played.position[:, at]) for at, agent in enumerate(AGENTS)], axis=1
    )
    tasks = np.array([[scene.tasks[agent].pick, scene.tasks[agent].place] for agent in AGENTS])
    return {
        "held": (("sample",), played.held.astype(np.int8)),
        "end_effector": (("sample", "agent", "table"), tips),
        "finish_time": (("agent",), played.finish_time),
        "stops": ((), np.int64(played.stops)),
        "stop_episodes": ((), np.int64(played.stop_episodes)),
        "scene": ((), np.int64(number)),
        "plan_sets": ((), plan_sets),
        "live_model": ((), "" if model is None else personality_text(model)),
        "task_position": (
            ("agent", "step", "table"),
            tasks,
            {"long_name": "where each agent picks up (first) and puts down (then)", "units": "m"},
        ),
    }
