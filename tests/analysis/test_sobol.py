"""The plan sobol: its points, and the indices that they give."""

import numpy as np
import pytest

from trainer.analysis.sweep.draws import Draws
from trainer.analysis.sweep.records import Sample, VaryRow
from trainer.analysis.sweep.sobol import places_of, sobol_indices

NAMES = ("x1", "x2", "x3")
SETS = len(NAMES) + 2
POINTS = 4096


def plan_of(points: int, seed: int = 7, **sample: str) -> Draws:
    """Return the draws of three angles from -pi to pi."""
    row = {"distribution": "uniform", "low": -np.pi, "high": np.pi}
    rows = tuple(VaryRow(name=name, key="-", **row) for name in NAMES)  # type: ignore[arg-type]
    return Draws(Sample(plan="sobol", members=SETS * points, seed=seed, **sample), rows)


def table_of(plan: Draws, first: int, count: int) -> np.ndarray:
    """Return the numbers of members, a column a variable."""
    return np.column_stack([plan.drawn(first, count)[name] for name in NAMES])


def test_the_function_of_ishigami_has_its_indices_to_two_per_cent() -> None:
    x1, x2, x3 = table_of(plan_of(POINTS), 0, SETS * POINTS).T
    values = np.sin(x1) + 7.0 * np.sin(x2) ** 2 + 0.1 * x3**4 * np.sin(x1)
    found = {each.variable: each for each in sobol_indices(NAMES, values, 7)}

    # Ishigami and Homma (1990), a = 7, b = 0.1, in closed form
    whole = 49.0 / 8.0 + 0.1 * np.pi**4 / 5.0 + 0.01 * np.pi**8 / 18.0 + 0.5
    alone = (0.5 * (1.0 + 0.1 * np.pi**4 / 5.0) ** 2, 49.0 / 8.0, 0.0)
    both = 0.01 * np.pi**8 * (1.0 / 18.0 - 1.0 / 50.0)
    together = (alone[0] + both, alone[1], both)
    for name, first, total in zip(NAMES, alone, together, strict=True):
        index = found[name]
        assert index.first == pytest.approx(first / whole, abs=0.02)
        assert index.total == pytest.approx(total / whole, abs=0.02)
        assert index.first_interval[0] <= first / whole <= index.first_interval[1]
        assert index.total_interval[0] <= total / whole <= index.total_interval[1]
    assert [each.variable for each in sobol_indices(NAMES, values, 7)] == ["x1", "x2", "x3"]


def test_a_mixed_member_has_one_number_of_the_second_set_and_the_others_of_the_first() -> None:
    numbers = table_of(plan_of(8), 0, SETS * 8).reshape(8, SETS, 3)
    for first, second, *mixed in numbers:
        assert not np.any(first == second)
        for j, each in enumerate(mixed):
            assert each[j] == second[j]
            assert np.all(np.delete(each, j) == np.delete(first, j))


def test_a_member_alone_has_its_numbers_and_another_seed_others() -> None:
    plan = plan_of(64)
    whole = table_of(plan, 0, SETS * 64)
    for first, count in ((0, 1), (1, 6), (137, 1), (SETS * 64 - 1, 1)):
        assert np.array_equal(table_of(plan, first, count), whole[first : first + count])
    assert not np.any(table_of(plan_of(64, seed=8), 0, SETS * 64) == whole)


def test_each_set_fills_every_part_of_a_variable() -> None:
    numbers = table_of(plan_of(64), 0, SETS * 64).reshape(64, SETS, 3)
    for at in (0, 1):
        parts = np.floor((numbers[:, at] + np.pi) / (2.0 * np.pi) * 64).astype(int)
        for column in parts.T:
            assert sorted(column) == list(range(64))


def test_what_is_compared_flies_in_the_same_sea() -> None:
    points, _ = places_of(3, 0, SETS * 16)
    seeds = plan_of(16).seeds(0, SETS * 16)
    assert [len(set(seeds[points == each])) for each in range(16)] == [1] * 16
    assert len(set(seeds)) == 16
    assert plan_of(16).seeds(37, 9).tolist() == seeds[37:46].tolist()
    assert len(set(plan_of(16, seeds="one").seeds(0, SETS * 16))) == 1


def test_a_point_with_a_member_that_came_to_nothing_is_left_out() -> None:
    x1, x2, x3 = table_of(plan_of(POINTS), 0, SETS * POINTS).T
    values = x1 + 2.0 * x2 + 0.0 * x3
    spoilt = values.copy()
    spoilt[[3, 777, 4000]] = np.nan
    found = {each.variable: each for each in sobol_indices(NAMES, spoilt, 1)}
    assert found["x2"].first == pytest.approx(0.8, abs=0.01)
    assert found["x1"].total == pytest.approx(0.2, abs=0.01)
    assert found["x3"].total == 0.0
    assert sobol_indices(NAMES, values[: SETS * 7], 1) == ()
    assert sobol_indices(NAMES, np.ones(SETS * 64), 1) == ()
