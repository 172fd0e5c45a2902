"""Manoeuvres of what goes wrong, and backing: what they order, and what is measured."""

from typing import Any

import numpy as np
import pytest

from trainer.analysis.guide.programme import own_method
from trainer.analysis.manoeuvres.casualties import OutOfBalance, PlaneJam, RudderJam
from trainer.analysis.manoeuvres.flight import Flight, Manoeuvre, fly_manoeuvre
from trainer.analysis.manoeuvres.speeds import Backing
from trainer.analysis.manoeuvres.submarine import Submarine
from trainer.analysis.manoeuvres.vehicle import DIVE, PORT, RISE
from trainer.config.boat.vessel import load_vessel
from trainer.units import KNOT


@pytest.fixture(scope="module")
def sdv() -> Submarine:
    """Return a boat that is alike on both sides but for her propeller."""
    file = load_vessel("sdv-mk9")
    return Submarine(file, own_method(file, "full"))


def figures(manoeuvre: Manoeuvre, flight: Flight) -> dict[str, float | None]:
    return {one.name: one.value for one in manoeuvre.measures(flight)}


def test_a_jam_to_dive_goes_down_and_one_to_rise_up_and_both_are_brought_level(
    sdv: Submarine,
) -> None:
    jams = {way: PlaneJam(5.0, 2.0, direction=way) for way in (DIVE, RISE)}
    flown = {way: fly_manoeuvre(sdv, jam, 3.0 * KNOT) for way, jam in jams.items()}
    told = {way: figures(jams[way], flight) for way, flight in flown.items()}

    assert (told[DIVE]["largest pitch"] or 0.0) < 0.0 < (told[RISE]["largest pitch"] or 0.0)
    for way, side in ((DIVE, 1.0), (RISE, -1.0)):
        assert side * (told[way]["depth lost"] or 0.0) > 0.5
        assert [mark.name for mark in flown[way].marks] == ["jam", "free", "level"]
        free = flown[way].time_of("free") or 0.0
        hard = flown[way].at(free + 1.0, "delta_s") or 0.0
        jammed = flown[way].at(free - 1.0, "delta_s") or 0.0
        assert hard * jammed < 0.0  # hard over the other way
        assert (told[way]["time to level"] or 0.0) > free - flown[way].marks[0].t


def test_a_jammed_rudder_is_measured_alike_to_either_side_and_the_engine_is_stopped(
    sdv: Submarine,
) -> None:
    to_starboard, to_port = RudderJam(angle_deg=15.0), RudderJam(angle_deg=15.0, side=PORT)
    flown = [fly_manoeuvre(sdv, jam, 3.0 * KNOT) for jam in (to_starboard, to_port)]
    one, other = (figures(jam, f) for jam, f in zip((to_starboard, to_port), flown, strict=True))

    assert flown[0].column("psi")[-1] > 0.5
    assert flown[1].column("psi")[-1] < -0.5
    assert (one["psi after 1 of it"] or 0.0) > 0.5
    for name in ("psi after 1 of it", "u after 1 of it", "r after 0.5 of it"):
        assert other[name] == pytest.approx(one[name], rel=0.02), name
    for flight in flown:
        assert flight.column("u")[-1] < 0.7 * flight.speed
        assert flight.column("u_c")[-1] == pytest.approx(0.0, abs=0.01)


def test_a_heavy_boat_sinks_through_the_water_and_a_light_one_does_the_opposite(
    sdv: Submarine,
) -> None:
    loads = [OutOfBalance(share=share, keep=()) for share in (0.002, -0.002)]
    heavy, light = (figures(load, fly_manoeuvre(sdv, load, 3.0 * KNOT)) for load in loads)

    assert (heavy["w after 0.17 of it"] or 0.0) > 0.005
    for part in np.arange(1, 7) / 6:
        for name in ("w", "theta", "z"):
            told = f"{name} after {part:.2g} of it"
            assert light[told] == pytest.approx(-(heavy[told] or 0.0), rel=0.1), told


def test_backing_gathers_sternway_to_a_steady_speed(sdv: Submarine) -> None:
    backing = Backing(duration_s=200.0)
    flight = fly_manoeuvre(sdv, backing, 0.0)
    told: dict[str, Any] = figures(backing, flight)

    assert flight.column("u_c")[-1] == pytest.approx(sdv.controls["engine"].low, rel=0.01)
    assert told["speed after 20 s"] > told["speed after 50 s"] > told["speed after 100 s"]
    assert told["speed after 200 s"] == pytest.approx(told["speed after 160 s"], rel=0.1)
    assert told["way after 200 s"] < told["way after 100 s"] < 0.0
