"""Overshoots by tankage: Table 5 and Figure 4 of 1969 for the shipped boats."""

from functools import cache

import pytest
from helpers.places import DATA

from trainer.analysis.programs.tanks import (
    CHANGED_VARIABLES,
    IN_BALANCE,
    PERCENT_1969,
    Flights,
    TankageReport,
    centres_of,
    overshoot_panels,
    survey_tankage,
)
from trainer.config.boat.vessel import load_vessel
from trainer.config.files import ConfigError

PAGE = (DATA.parents[1] / "docs" / "sweeps.md").read_text(encoding="utf-8")


@cache
def surveyed(boat: str) -> tuple[TankageReport, Flights]:
    return survey_tankage(load_vessel(boat), {})


def figures_of(boat: str) -> dict[tuple[float, str], list[float | None]]:
    """Return the nine figures [%] at each speed [kn]."""
    return {
        (one.speed_kn, one.tankage): [one.percent[name] for name in CHANGED_VARIABLES]
        for one in surveyed(boat)[0].changes
    }


NINE: dict[
    str, dict[tuple[float, str], list[float | None]]
] = {  # [%] of u, theta, z; None: too little change
    "bb2": {
        (6.0, "largest z_G"): [2.9, 3.2, 5.9],
        (6.0, "as filled"): [0.0, 0.0, 0.0],
        (6.0, "largest x_G"): [-64.7, -231.7, 100.0],
        (20.0, "largest z_G"): [0.1, 1.3, 7.3],
        (20.0, "as filled"): [0.0, 0.0, 0.0],
        (20.0, "largest x_G"): [7.7, -17.0, -99.3],
    },
    "remus100": {
        (2.0, "largest z_G"): [0.4, 0.8, 2.6],
        (2.0, "as filled"): [0.0, 0.0, 0.0],
        (2.0, "largest x_G"): [-5.8, -5.1, -250.1],
        (4.5, "largest z_G"): [0.8, -1.2, -3.5],
        (4.5, "as filled"): [0.0, 0.0, 0.0],
        (4.5, "largest x_G"): [-2.8, -4.5, -32.0],
    },
    "sdv-mk9": {
        (1.0, "largest z_G"): [None, 0.3, 1.0],
        (1.0, "as filled"): [None, 0.0, 0.0],
        (1.0, "largest x_G"): [None, 6.2, 31.1],
        (6.0, "largest z_G"): [0.0, 0.1, 1.8],
        (6.0, "as filled"): [0.0, 0.0, 0.0],
        (6.0, "largest x_G"): [0.0, 1.3, -29.9],
    },
}


@pytest.mark.parametrize("boat", NINE)
def test_tankage_changes_an_overshoot_of_a_shipped_boat_by_the_figures_of_the_page(
    boat: str,
) -> None:
    found, told = figures_of(boat), NINE[boat]

    assert list(found) == list(told)
    for row, figures in told.items():
        assert found[row] == pytest.approx(figures, abs=0.06), row
    for speed, tankage in told:
        if tankage != "as filled":
            cells = " | ".join(
                "-" if figure is None else f"{figure:.1f}" for figure in told[speed, tankage]
            )
            assert f"| {boat} | {speed:g} | {tankage} | {cells} |" in PAGE


@pytest.mark.parametrize("boat", NINE)
def test_slow_x_g_counts_for_more_than_z_g_and_than_fast_as_in_1969(boat: str) -> None:
    found = figures_of(boat)
    slow, fast = sorted({speed for speed, _ in found})
    largest = {row: max(abs(figure or 0.0) for figure in found[row]) for row in found}

    assert largest[slow, "largest x_G"] > 5.0 * largest[slow, "largest z_G"]
    assert largest[slow, "largest x_G"] > largest[fast, "largest x_G"]


def test_pumped_tanks_move_the_centre_and_as_filled_is_the_filling_asked_for() -> None:
    moved_by, centres = centres_of(load_vessel("bb2"), {"trim_forward": 0.6, "trim_aft": 0.4})

    assert moved_by == "pumped tanks"
    assert centres["largest z_G"] == pytest.approx((0.0, 0.0, 0.0331), abs=5e-5)
    assert centres["largest x_G"] == pytest.approx((0.1325, 0.0, 0.0), abs=5e-5)
    # 20.1 kN from 26 m abaft to 26 m before, twice its half, of 43348.7 kN
    assert centres["as filled"] == pytest.approx((0.0241, 0.0, 0.0), abs=5e-5)


def test_a_boat_without_tanks_is_moved_by_ballast_and_has_none_to_fill() -> None:
    file = load_vessel("remus100")
    moved_by, centres = centres_of(file, {})

    assert moved_by == "ballast, 2% of BG"
    assert centres["largest x_G"][0] == pytest.approx(0.02 * file.hull.cg[2])
    with pytest.raises(ConfigError, match="there are no tanks to fill"):
        survey_tankage(file, {"auxiliary": 0.5})


def test_figure_4_draws_u_theta_and_z_slow_and_fast_by_tankage() -> None:
    report, flights = surveyed("bb2")
    drawn = overshoot_panels(report, flights)

    assert [panel.title.split(": ")[1] for panel in drawn] == [
        f"{name} at {speed} kn" for speed in (6, 20) for name in CHANGED_VARIABLES
    ]
    for panel in drawn:
        assert [curve.label for curve in panel.curves] == [IN_BALANCE, *PERCENT_1969]
    fast_z = dict(zip((curve.label for curve in drawn[5].curves), drawn[5].curves, strict=True))
    assert fast_z["largest x_G"].y[-1] == pytest.approx(359.7, abs=0.1)
    assert drawn[5].downwards
