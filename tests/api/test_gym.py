"""The exercises as environments of Gymnasium: its checkers have nothing to say."""

import subprocess
import sys
from typing import Any

import gymnasium
import numpy as np
import pytest
from gymnasium.utils.env_checker import check_env
from gymnasium.vector import AutoresetMode

import trainer
import trainer.gym

PLANES = "trainer/first-depth-change-v0"
SEA = "trainer/emergency-deep-v0"
CURRENT = "trainer/canyon-v0"


def test_gymnasium_makes_an_exercise_by_its_module() -> None:
    env = gymnasium.make(f"trainer.gym:{PLANES}")

    assert env.spec is not None
    assert env.spec.id == PLANES
    assert "trainer/watch-v0" in gymnasium.registry


@pytest.mark.parametrize("name", [PLANES, SEA, CURRENT])
def test_gymnasium_s_checker_has_neither_error_nor_warning(name: str) -> None:
    check_env(gymnasium.make(name).unwrapped)


def test_a_return_is_the_mark_and_a_seed_is_the_same_sea() -> None:
    env, flights = gymnasium.make(SEA), []
    for seed in (3, 3, 4):
        seen, _ = env.reset(seed=seed)
        info: dict[str, Any] = {}
        rows, total, over = [seen], 0.0, False
        while not over:
            action = np.clip(-seen[12:15], -1.0, 1.0).astype(np.float32)
            seen, reward, lost, ended, info = env.step(action)
            rows, total, over = [*rows, seen], total + float(reward), lost or ended
        assert total == pytest.approx(info["marks"], abs=1e-9)
        flights.append(np.array(rows))

    assert np.array_equal(flights[0], flights[1])
    assert not np.array_equal(flights[0], flights[2])


def steps_of(
    name: str, mode: AutoresetMode, vectorization: str, **options: Any
) -> list[tuple[Any, ...]]:
    """Return what 125 steps of three boats give, by one way to have many."""
    many = gymnasium.make_vec(name, num_envs=3, vectorization_mode=vectorization, **options)
    assert many.metadata["autoreset_mode"] is mode
    seen, _ = many.reset(seed=3)
    steps: list[tuple[Any, ...]] = [(seen,)]
    for _ in range(125):  # planes for the depth, and half speed where it is theirs
        planes = (0.25 * seen[:, 13] - 0.4 * seen[:, 5]) * (1.0, 0.5, 1.5)
        actions = np.column_stack((planes, planes, np.full(3, 0.5)))
        actions = actions[:, : many.action_space.sample().shape[1]]
        steps.append(many.step(np.clip(actions, -1.0, 1.0).astype(np.float32)))
        seen = steps[-1][0]
    return steps


@pytest.mark.parametrize("mode", [AutoresetMode.SAME_STEP, AutoresetMode.NEXT_STEP])
def test_many_boats_in_one_call_are_gymnasium_s_own_many_of_one(mode: AutoresetMode) -> None:
    ours, theirs = [], []
    for name in (PLANES, SEA):
        ours += steps_of(name, mode, "vector_entry_point", autoreset_mode=mode)
        theirs += steps_of(name, mode, "sync", vector_kwargs={"autoreset_mode": mode})

    ends, earned = 0, 0.0
    for own, other in zip(ours, theirs, strict=True):
        for one, two in zip(own[:4], other[:4], strict=True):
            assert one.dtype == two.dtype
            assert np.array_equal(one, two)
        if len(own) == 5:
            ends, earned = ends + bool(own[4]), earned + float(own[1].sum())
            assert_alike(own[4], other[4])
    assert ends >= 2
    assert earned > 60.0


def assert_alike(own: Any, other: Any) -> None:
    """Assert that infos have the same keys, and the same in them."""
    if isinstance(own, dict):
        assert own.keys() == other.keys()
        for key in own:
            assert_alike(own[key], other[key])
    elif own.dtype == object:
        assert all(np.array_equal(one, two) for one, two in zip(own, other, strict=True))
    else:
        assert np.array_equal(own, other)


def test_what_is_wrong_is_said_in_the_trainer_s_words() -> None:
    env = gymnasium.make(PLANES).unwrapped
    env.reset(seed=1)

    with pytest.raises(trainer.TrainerError, match="an action is a number from -1 to 1"):
        env.step(np.array([0.0, np.nan], np.float32))
    with pytest.raises(trainer.TrainerError, match="must be SameStep or NextStep, not Disabled"):
        trainer.gym.ExerciseVectorEnv("first-depth-change", autoreset_mode="Disabled")
    with pytest.raises(trainer.TrainerError, match="give 2 seeds, not 3"):
        trainer.gym.ExerciseVectorEnv("first-depth-change", 2).reset(seed=[1, 2, 3])
    with pytest.raises(trainer.TrainerError, match="an answer is an order in words"):
        gymnasium.make("trainer/watch-v0")


@pytest.mark.process
def test_without_gymnasium_the_trainer_says_what_to_install() -> None:
    program = (
        "import sys, trainer; sys.modules['gymnasium'] = None; trainer.vessels()\n"
        "import importlib.util as util; found = util.find_spec\n"
        "util.find_spec = lambda name, *more: None if name == 'gymnasium' else found(name, *more)\n"
        "try:\n    import trainer.gym\nexcept trainer.TrainerError as wrong:\n    print(wrong)\n"
    )
    ended = subprocess.run(
        [sys.executable, "-c", program], capture_output=True, text=True, check=True
    )

    assert ended.stdout == "trainer.gym needs gymnasium: pip install 'submarine-trainer[gym]'\n"
