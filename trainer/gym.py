"""The shipped exercises as environments of Gymnasium, one boat or many.

    import gymnasium

    env = gymnasium.make("trainer.gym:trainer/first-depth-change-v0")

A reward is the rise of the marks, so that a return is the exercise's mark. The page
docs/learning.md says what is ordered and seen. Gymnasium finds an environment by its module,
because it has loaded none by itself since 1.0.
"""

import threading
from collections.abc import Sequence
from pathlib import Path
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from trainer.api.by_number import BoatByNumber
from trainer.api.exercise_fleet import (
    MOST_SEEN,
    SEED_COUNT,
    SIGHT_NAMES,
    ExerciseFleet,
    drill_of,
    look_out_order,
    start_of,
)
from trainer.boat.due_orders import obey_all
from trainer.config.extras import require_library
from trainer.config.files import ConfigError, shipped_names
from trainer.debrief.ticks.judge import TickJudge

require_library("gymnasium", "trainer.gym")

import gymnasium  # noqa: E402  only after it is known to be there
from gymnasium import spaces  # noqa: E402
from gymnasium.utils import seeding  # noqa: E402
from gymnasium.vector import AutoresetMode, VectorEnv  # noqa: E402
from gymnasium.vector.utils import batch_space  # noqa: E402

Seen = NDArray[np.float32]
Actions = NDArray[np.float32]
Infos = dict[str, Any]
ResetOptions = dict[str, Any]
NO_NUMBER: Final = "step(): an action is a number from -1 to 1, and none is NaN"
AUTORESET_MODES: Final = (AutoresetMode.SAME_STEP, AutoresetMode.NEXT_STEP)


def sight_space() -> Any:
    """Return the space of what is seen, which is typed otherwise from version to version."""
    return spaces.Box(-MOST_SEEN, MOST_SEEN, (len(SIGHT_NAMES),), np.float32)


def control_space(count: int) -> Any:
    """Return the space of so many controls."""
    return spaces.Box(-1.0, 1.0, (count,), np.float32)


class ExerciseEnv(gymnasium.Env[Seen, Actions]):
    """One boat in an exercise, by numbers; it is terminated where it is lost."""

    metadata: dict[str, Any] = {"render_modes": []}  # noqa: RUF012  Gymnasium's own form

    def __init__(self, exercise: str | Path, step_s: float | None = None) -> None:
        self.drill, self._exercise = drill_of(exercise, step_s), exercise
        self.action_space = control_space(len(self.drill.controls))
        self.observation_space = sight_space()
        self._boat = self.drill.plan.launch_boat()
        names, ticks = (self.drill.controls, self.drill.reads), self.drill.ticks
        self._steered = BoatByNumber(self._boat, threading.Lock(), *names, ticks, ticks)
        self._judge, self._marks, self._tick = TickJudge(self.drill.plan), 0.0, 0

    def reset(
        self, *, seed: int | None = None, options: ResetOptions | None = None
    ) -> tuple[Seen, Infos]:
        """Begin anew, in a sea that the seed draws."""
        super().reset(seed=seed, options=options)
        start = start_of(self._exercise, draw_sea(self.np_random))
        np.asarray(self._boat.plain)[:] = start.whole
        row, count = start.whole[self._steered.places], len(self.drill.judge_reads)
        self._judge.begin(0, row[:count], start.nobody)
        self._marks, self._tick = 0.0, 0
        return self.drill.sights(row[None, count:])[0], {}

    def step(self, action: Actions) -> tuple[Seen, float, bool, bool, Infos]:
        """Obey, advance, judge. At the end ``info`` has the ``marks``."""
        drill, values = self.drill, self.drill.values(action)
        if not np.isfinite(values).all():
            raise ConfigError(NO_NUMBER)
        if self._tick and (orders := drill.due.get(self._tick)):
            obey_all(self._boat, orders)
        count, marks, lost = len(drill.judge_reads), self._marks, False
        try:
            rows = self._steered.step(values).reshape(1, drill.ticks, -1)
        except ConfigError:  # the actions are sound, so the boat is lost
            lost, row = True, np.asarray(self._boat.plain)[self._steered.places]
        else:
            self._marks = float(self._judge.look(rows[..., :count])[0])
            lost, row = bool(self._judge.ended[0]), rows[0, -1]
        self._tick += drill.ticks
        over = not lost and self._tick >= drill.last
        info = {"marks": self._marks} if lost or over else {}
        return drill.sights(row[None, count:])[0], self._marks - marks, lost, over, info

    def order(self, text: str) -> None:
        """Have the look-out carry out ``scope raise``, ``scope lower`` or ``mark contact 064``."""
        self._judge.hear(0, look_out_order(text, self._tick))


class ExerciseVectorEnv(VectorEnv[Seen, Actions, Any]):
    """Many boats in an exercise, each at its own step of it.

    ``autoreset_mode`` is that of Gymnasium, SameStep or NextStep; ``metadata`` says which.
    """

    def __init__(
        self,
        exercise: str | Path,
        num_envs: int = 1,
        step_s: float | None = None,
        autoreset_mode: AutoresetMode | str = AutoresetMode.SAME_STEP,
        threads: int = 1,
    ) -> None:
        mode = AutoresetMode(autoreset_mode)
        if mode not in AUTORESET_MODES:
            known = " or ".join(each.value for each in AUTORESET_MODES)
            raise ConfigError(f"autoreset_mode: must be {known}, not {mode.value}")
        self.metadata = {"render_modes": [], "autoreset_mode": mode}
        self.fleet = ExerciseFleet(exercise, num_envs, step_s=step_s, threads=threads)
        self.num_envs, self._same_step = num_envs, mode is AutoresetMode.SAME_STEP
        self.single_action_space = control_space(len(self.fleet.controls))
        self.single_observation_space = sight_space()
        self.action_space = batch_space(self.single_action_space, num_envs)
        self.observation_space = batch_space(self.single_observation_space, num_envs)
        self._randoms = [seeding.np_random()[0] for _ in range(num_envs)]

    def reset(
        self,
        *,
        seed: int | Sequence[int | None] | None = None,
        options: ResetOptions | None = None,  # noqa: ARG002  there are none
    ) -> tuple[Seen, Infos]:
        """Begin anew with all. A seed is that of the first boat, the next has the next one."""
        if seed is not None:
            given = range(seed, seed + self.num_envs) if isinstance(seed, int) else seed
            if len(given) != self.num_envs:
                raise ConfigError(f"reset(): give {self.num_envs} seeds, not {len(given)}")
            for index, own in enumerate(given):
                if own is not None:
                    self._randoms[index] = seeding.np_random(own)[0]
        return self._begin(np.ones(self.num_envs, bool)), {}

    def _begin(self, which: NDArray[np.bool_]) -> Seen:
        draws = [draw_sea(self._randoms[index]) for index in np.flatnonzero(which).tolist()]
        return self.fleet.reset(which, draws)

    def step(
        self, actions: Actions
    ) -> tuple[Seen, NDArray[np.float64], NDArray[np.bool_], NDArray[np.bool_], Infos]:
        """Obey, advance, judge; begin anew with those that end, as ``autoreset_mode`` says."""
        fleet, was_over = self.fleet, self.fleet.over
        marks = np.where(fleet.begun, fleet.marks, 0.0)
        seen = fleet.step(actions)
        rewards = np.where(was_over, 0.0, fleet.marks - marks)
        lost = fleet.lost & ~was_over
        ended = fleet.over & ~was_over & ~lost
        over = lost | ended
        infos: Infos = {}
        if over.any():
            infos = {"marks": np.where(over, fleet.marks, 0.0), "_marks": over.copy()}
        if self._same_step and over.any():
            final = np.full(self.num_envs, None, object)
            for index in np.flatnonzero(over).tolist():
                final[index] = seen[index].copy()
            infos = {"final_obs": final, "_final_obs": over.copy(), "final_info": infos}
            infos["_final_info"] = over.copy()
        anew = over if self._same_step else was_over
        return self._begin(anew) if anew.any() else seen, rewards, lost, ended, infos


def draw_sea(random: np.random.Generator) -> int:
    """Return which sea a boat has that begins anew."""
    return int(random.integers(SEED_COUNT))


for _name in shipped_names("exercises"):
    gymnasium.register(
        f"trainer/{_name}-v0",
        entry_point=f"{__name__}:ExerciseEnv",
        vector_entry_point=f"{__name__}:ExerciseVectorEnv",
        kwargs={"exercise": _name},
    )
