"""A beam sea for any boat, and what a compact set does in it."""

import math
from dataclasses import replace

import numpy as np
import pytest

from trainer.analysis.guide.programme import Leg, guide_legs, own_method
from trainer.analysis.guide.verdicts import allowed_multiple
from trainer.analysis.manoeuvres.catalogue import find_manoeuvre
from trainer.analysis.manoeuvres.flight import fly_manoeuvre
from trainer.analysis.manoeuvres.page import ManoeuvreOptions, fly_boat, render
from trainer.analysis.manoeuvres.seakeeping import (
    WAVE_STEEPNESS,
    BeamSea,
    fast_part,
    peak_period,
    wave_number,
)
from trainer.analysis.manoeuvres.submarine import Rig, Submarine
from trainer.analysis.reduce.objective import Candidate, Yardstick
from trainer.analysis.reduce.reduction import as_filed
from trainer.config.boat.vessel import VesselFile, load_vessel
from trainer.config.files import ConfigError
from trainer.units import KNOT

BOATS = ("bb2", "sdv-mk9", "remus100")


def sea_leg(file: VesselFile) -> Leg:
    """Return the guide's flight in waves."""
    (leg,) = (leg for leg in guide_legs(file) if leg.manoeuvre.in_waves)
    return leg


def worst_in_the_sea(file: VesselFile, factors: dict[str, float]) -> float:
    """Return the largest difference [-] of the allowed of a modified set."""
    candidate = Candidate(file, "modified")
    candidate.take([factors[name] for name in candidate.terms])
    ((_, judged),) = Yardstick(file, (sea_leg(file),)).judged(candidate)
    return max(abs(allowed_multiple(one)) for one in judged)


def test_the_sea_of_bb2_is_sea_state_5_and_smaller_boats_have_less() -> None:
    heights = [WAVE_STEEPNESS * math.tau / wave_number(length) for length in (70.2, 5.3, 1.33)]
    periods = [peak_period(length) for length in (70.2, 5.3, 1.33)]

    assert heights == pytest.approx([3.25, 1.16, 0.66], rel=0.01)
    assert periods == pytest.approx([9.0, 5.37, 4.07], rel=0.01)


def test_what_is_slower_than_the_waves_is_taken_off() -> None:
    t = np.arange(0.0, 600.0, 0.5)
    wave, drift = np.sin(math.tau * t / 9.0), 0.01 * t
    count = 59

    assert np.std(fast_part(drift, count)) < 1e-9
    assert np.std(fast_part(wave + drift, count)) == pytest.approx(math.sqrt(0.5), rel=0.08)


def test_every_set_is_flown_in_waves_by_one_method() -> None:
    file = load_vessel("bb2")
    leg = sea_leg(file)

    methods = {each: leg.task(file, each).method for each in ("full", "modified", "basic")}

    assert {(one.rates, one.integrator) for one in methods.values()} == {("lagged", "adams2")}
    calm = replace(leg, manoeuvre=find_manoeuvre("turn"))
    assert calm.task(file, "full").method == own_method(file, "full")


def test_waves_roll_the_boat_and_it_keeps_depth_and_course() -> None:
    file = load_vessel("bb2")
    leg = sea_leg(file)
    boat = Submarine(file, leg.method(file, "full"), leg.rig)

    flight = fly_manoeuvre(boat, leg.manoeuvre, leg.speed_kn * KNOT)

    sizes = {one.name: one.value for one in leg.manoeuvre.measures(flight)}
    assert set(sizes) == {f"rms of {name}" for name in ("v", "w", "phi", "theta", "r", "z")}
    assert all(value and value > 0.0 for value in sizes.values())
    assert abs(flight.change("psi")).max() < math.radians(5.0)
    assert abs(flight.change("z")).max() < 4.0


def test_where_no_sea_is_felt_it_is_refused() -> None:
    file = load_vessel("bb2")
    with pytest.raises(ConfigError, match=r"these waves: no sea is felt 1000 m down.* --depth"):
        fly_manoeuvre(Submarine(file, own_method(file, "full")), BeamSea(), 5.0)


def test_a_sea_that_was_asked_for_takes_the_place_of_the_boat_s_own() -> None:
    file = load_vessel("bb2")
    boat = Submarine(file, own_method(file, "full"), Rig(depth=20.0, sea="sea-state-3"))
    boat.start(5.0)
    boat.meet_sea(3.25, 9.0)

    assert float(boat.boat.state.sea_height) == pytest.approx(0.875)


def test_the_page_tells_the_waves_that_the_manoeuvre_brings() -> None:
    report, _ = fly_boat(
        load_vessel("bb2"), "beam-sea", ManoeuvreOptions(rig=Rig(depth=20.0, seed=4))
    )

    assert "from 20 m; sea: 3.25 m, 9 s, from port, seed 4" in render(report)


@pytest.mark.parametrize("name", BOATS)
def test_the_modified_set_moves_in_a_beam_sea_as_the_full_one_does(name: str) -> None:
    file = load_vessel(name)

    assert worst_in_the_sea(file, as_filed(file)) <= 1.0


def test_a_set_with_less_of_an_added_mass_moves_otherwise() -> None:
    file = load_vessel("bb2")
    factors = as_filed(file)

    assert worst_in_the_sea(file, {**factors, "Y_vdot": 0.7, "K_vdot": 0.0}) > 1.5
