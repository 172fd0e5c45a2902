"""The numbers of a study's members: their distributions, their strata, and that they last."""

from typing import Any

import numpy as np
import pytest

from trainer.analysis.sweep.draws import Draws, fill_normals, strata
from trainer.analysis.sweep.records import Sample, VaryRow

NORMAL = {"distribution": "normal", "mean": 2.0, "std": 0.5}
UNIFORM = {"distribution": "uniform", "low": -1.0, "high": 3.0}
TRIANGULAR = {"distribution": "triangular", "low": 1.0, "mode": 2.0, "high": 5.0}


def draws(plan: str, members: int | None, *rows: dict[str, Any], seed: int = 7) -> Draws:
    """Return the draws of variables named a, b, ..."""
    varied = tuple(VaryRow(name="abcdef"[i], key="-", **row) for i, row in enumerate(rows))
    return Draws(Sample(plan=plan, members=members, seed=seed), varied)


def test_the_normal_quantile_is_scipys_to_the_last_digits() -> None:
    from scipy import stats  # noqa: PLC0415  half a second of every collection

    shares = np.concatenate([np.linspace(1e-4, 1.0 - 1e-4, 5001), 10.0 ** -np.arange(1.0, 17.0)])
    found = np.empty(len(shares))
    fill_normals(shares, found)

    assert found == pytest.approx(stats.norm.ppf(shares), rel=3e-15, abs=1e-15)


@pytest.mark.parametrize(
    ("row", "law", "shape"),
    [
        (NORMAL, "norm", (2.0, 0.5)),
        (UNIFORM, "uniform", (-1.0, 4.0)),
        (TRIANGULAR, "triang", (0.25, 1.0, 4.0)),
    ],
)
@pytest.mark.parametrize("plan", ["monte-carlo", "latin-hypercube"])
def test_members_are_distributed_as_the_study_says(
    row: dict[str, Any], law: str, shape: tuple[float, ...], plan: str
) -> None:
    from scipy import stats  # noqa: PLC0415  half a second of every collection

    (values,) = draws(plan, 4000, row).drawn(0, 4000).values()

    assert stats.kstest(values, law, shape).pvalue > 0.01


def test_a_latin_hypercube_has_one_member_in_each_part_of_every_variable() -> None:
    members = 500
    for values in draws("latin-hypercube", members, UNIFORM, UNIFORM).drawn(0, members).values():
        parts = np.floor((values + 1.0) / 4.0 * members).astype(int)
        assert sorted(parts) == list(range(members))


def test_monte_carlo_leaves_parts_empty_as_chance_has_it() -> None:
    (values,) = draws("monte-carlo", 500, UNIFORM).drawn(0, 500).values()

    empty = 500 - len(set(np.floor((values + 1.0) / 4.0 * 500).astype(int)))
    assert 150 < empty < 220  # 500/e


@pytest.mark.parametrize("plan", ["monte-carlo", "latin-hypercube"])
def test_variables_and_members_know_nothing_of_each_other(plan: str) -> None:
    one, other = draws(plan, 4000, UNIFORM, UNIFORM).drawn(0, 4000).values()

    assert abs(np.corrcoef(one, other)[0, 1]) < 0.05
    assert abs(np.corrcoef(one[1:], one[:-1])[0, 1]) < 0.05


@pytest.mark.parametrize("plan", ["monte-carlo", "latin-hypercube"])
def test_a_member_alone_has_the_numbers_it_has_among_the_others(plan: str) -> None:
    study = draws(plan, 1000, NORMAL, UNIFORM, TRIANGULAR, {"values": ("calm", "rough")})
    among = study.drawn(0, 1000)

    for member in (0, 17, 511, 999):
        strata.cache_clear()
        alone = study.drawn(member, 1)
        assert all(alone[name][0] == values[member] for name, values in among.items())
        assert study.seeds(member, 1)[0] == study.seeds(0, 1000)[member]


def test_another_seed_gives_other_numbers_and_a_variable_more_leaves_the_rest() -> None:
    first = draws("latin-hypercube", 100, NORMAL).drawn(0, 100)["a"]

    assert not np.any(draws("latin-hypercube", 100, NORMAL, seed=8).drawn(0, 100)["a"] == first)
    wider = draws("latin-hypercube", 100, NORMAL, UNIFORM).drawn(0, 100)["a"]
    assert wider.tolist() == first.tolist()


def test_a_grid_is_all_points_and_its_last_variable_changes_fastest() -> None:
    study = draws("grid", None, {"values": (1.0, 2.0)}, {"values": ("x", "y", "z")})
    found = study.drawn(0, study.members)

    points = list(zip(found["a"].tolist(), found["b"].tolist(), strict=True))
    assert points == [(a, b) for a in (1.0, 2.0) for b in "xyz"]
    assert study.drawn(4, 1)["b"].tolist() == ["y"]


def test_seeds_are_each_members_own_unless_all_are_to_meet_the_same_sea() -> None:
    study = draws("monte-carlo", 1000, UNIFORM)
    seeds = study.seeds(0, 1000)

    assert len(set(seeds.tolist())) == 1000
    assert 0 <= seeds.min() < seeds.max() < 2**49
    alike = Draws(Sample(plan="monte-carlo", members=5, seed=9, seeds="one"), study.rows)
    assert alike.seeds(0, 5).tolist() == [9] * 5


def test_given_values_are_drawn_equally_often_on_a_hypercube() -> None:
    (values,) = draws("latin-hypercube", 300, {"values": (1.0, 2.0, 3.0)}).drawn(0, 300).values()

    assert [int((values == x).sum()) for x in (1.0, 2.0, 3.0)] == [100, 100, 100]
