"""Tanks, air and pumps: what they conserve, what limits them, and what the boat does with them."""

import math
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from helpers.boats import start_bb2, start_boat
from helpers.places import ROOT
from hypothesis import given, settings
from hypothesis import strategies as st

from trainer.analysis.programs import tanks as ec430
from trainer.boat.assemble import Method, ballast_record, fit_out
from trainer.boat.boat import Boat
from trainer.config.boat.vessel import load_vessel, parse_vessel
from trainer.config.files import ConfigError
from trainer.core import surfaced
from trainer.core.ballast import air, ballast, buoyancy
from trainer.core.ballast.tanks import (
    ATMOSPHERIC_PRESSURE,
    BLOWN_TANKS,
    PUMPED_TANKS,
    TANKS,
    new_ballast,
)
from trainer.core.kernel import Record
from trainer.core.state import new_scratch, new_state

pytestmark = pytest.mark.core

KNOT = 1852.0 / 3600.0
H = 0.5  # [s]
BB2 = load_vessel("bb2")
FITTED = fit_out(BB2, Method("full", "lagged", "exact", "adams2", H))
TONNE = 1000.0


def with_tanks(vessel: Record, tanks: Record) -> Record:
    """Return a copy of a vessel that has these tanks."""
    found = vessel.copy()
    for name in tanks.dtype.names or ():
        if name != "whole":
            found[name] = tanks[name]
    return found


class Tanks:
    """BB2's tanks, at a depth that the test says."""

    def __init__(self, depth: float) -> None:
        self.vessel = with_tanks(FITTED.vessel, ballast_record(BB2))
        self.record = new_state()
        self.state = self.record[0]
        for name in ("weight", "x_g", "y_g", "z_g"):
            self.state[name] = self.vessel[0][name]
        self.state.z = depth
        ballast.start_ballast(self.vessel, self.record)

    @property
    def b(self) -> Any:
        return self.vessel[0]

    def run(self, seconds: float) -> None:
        for _ in range(round(seconds / H)):
            ballast.advance_ballast(self.vessel, H, self.record)

    def pressure(self, bank: int) -> float:
        return float(self.state.bank[bank] * self.b.gas / self.b.bank_volume[bank])

    def volume(self, tank: int) -> float:
        """Return the air's volume [m3] in a tank."""
        return float((self.b.capacity[tank] - self.state.water[tank]) / self.vessel[0].rho)


@pytest.fixture
def tanks() -> Tanks:
    return Tanks(60.0)


# Weight and balance


@given(
    st.lists(
        st.tuples(st.floats(0.0, 1e6), *[st.floats(-100.0, 100.0)] * 3), min_size=0, max_size=6
    )
)
def test_no_filling_full_or_empty_goes_beyond_the_limits_and_some_reach_them(
    rows: list[tuple[float, float, float, float]],
) -> None:
    hull = ec430.Weight(1e6, 0.1, 0.2, 0.3)
    limits = ec430.limits(hull, [ec430.Weight(*row) for row in rows])
    centres = [
        ec430.balance(
            hull, [ec430.Weight(*row) for row, full in zip(rows, fill, strict=True) if full]
        )
        for fill in product((False, True), repeat=len(rows))
    ]

    for axis, found in enumerate((limits.x_g, limits.y_g, limits.z_g)):
        reached = [one.centre[axis] for one in centres]
        assert found.least == pytest.approx(min(reached), abs=1e-9)
        assert found.most == pytest.approx(max(reached), abs=1e-9)


def test_at_the_start_fillings_the_boat_is_the_one_of_its_file_to_the_bit(tanks: Tanks) -> None:
    tanks.run(10.0)

    s = tanks.state
    assert (s.weight, s.x_g, s.y_g, s.z_g) == (BB2.hull.weight, *BB2.hull.cg)


def test_a_boat_without_tanks_is_left_alone_to_the_bit() -> None:
    boat = start_boat(1.5, 10.0, vessel="remus100")
    boat.state.weight, boat.state.x_g = 301.0, 0.01
    boat.state.blow[:], boat.state.breach[:] = 2.0, 0.1
    before = boat.snapshot()

    ballast.start_ballast(boat.records.vessel, boat.records.state)
    ballast.advance_ballast(boat.records.vessel, H, boat.records.state)

    assert boat.records.state.tobytes() == before.tobytes()


@pytest.mark.laws
def test_trim_water_moved_and_moved_back_returns_the_same_trim() -> None:
    boat = start_bb2()
    r, s = boat.records, boat.state
    ballast.start_ballast(r.vessel, r.state)

    def trim() -> np.ndarray:
        assert boat.trimmed(10 * KNOT)
        return np.array([s.theta, s.w, s.delta_s, s.u_c, s.delta_b])

    level = trim()
    for order in (8 * TONNE, -8 * TONNE):
        s.move_trim, s.move_auxiliary, s.move_depth_control = order, 0.7 * order, -0.3 * order
        for _ in range(1200):
            ballast.advance_ballast(r.vessel, H, r.state)
        if order > 0.0:
            assert abs(trim() - level).max() > 0.01

    assert trim() == pytest.approx(level, abs=1e-10)
    assert s.weight == pytest.approx(boat.vessel.weight, rel=1e-14)


# Nothing is made or lost

SHARES = st.sampled_from([0.0, 0.0, 0.3, 1.0, 1.7, 2.0])
AMOUNTS = st.floats(-5e4, 5e4)
STEPS = st.fixed_dictionaries(
    {
        "z": st.floats(-3.0, 600.0),
        "theta": st.floats(-0.7, 0.7),
        "phi": st.floats(-0.5, 0.5),
        "vent": st.lists(SHARES, min_size=4, max_size=4),
        "blow": st.lists(SHARES, min_size=4, max_size=4),
        "negative_flood": st.sampled_from([0.0, 1.0]),
        "to_move": st.lists(AMOUNTS, min_size=3, max_size=3),
        "drained": st.sampled_from([0.0, 1.0, 2.0, 3.0]),
        "hover": st.sampled_from([0.0, 1.0]),
        "zdot": st.floats(-3.0, 3.0),
        "ordered_depth": st.floats(0.0, 300.0),
        "breach": st.lists(st.sampled_from([0.0, 0.0, 1e-3, 0.05]), min_size=7, max_size=7),
        "pump_fault": st.lists(SHARES, min_size=3, max_size=3),
        "bank_fault": st.lists(SHARES, min_size=2, max_size=2),
        "compressor": st.sampled_from([0.0, 0.0, 1.0]),
    }
)


@pytest.mark.laws
@settings(max_examples=60)
@given(st.lists(STEPS, min_size=1, max_size=12))
def test_water_and_air_are_conserved_and_kept_within_their_tanks(
    steps: list[dict[str, Any]],
) -> None:
    tanks = Tanks(60.0)
    s, b, c = tanks.state, tanks.b, tanks.vessel[0]
    water, air_aboard = s.water.sum(), s.bank.sum() + s.tank_air.sum()
    scale = b.capacity.sum()

    for step in steps:
        for name, value in step.items():
            s[name] = value
        for _ in range(6):
            bank = s.bank.copy()
            tanks.run(H)

            assert (s.water >= 0.0).all()
            assert (s.water <= b.capacity).all()
            assert (s.tank_air >= 0.0).all()
            assert (s.bank >= 0.0).all()
            assert (s.bank <= b.bank_full).all()
            if not s.compressor:
                assert (s.bank <= bank).all(), "a bank's energy rose by itself"
            assert s.water.sum() - water == pytest.approx(s.water_taken, abs=1e-12 * scale)
            held = s.bank.sum() + s.tank_air.sum()
            assert held - air_aboard == pytest.approx(s.air_taken, abs=1e-12 * air_aboard)

            hull = ec430.Weight(c.weight, c.x_g, c.y_g, c.z_g)
            moved = (s.water - b.start) * c.g
            found = ec430.balance(
                hull, [ec430.Weight(*row) for row in zip(moved, b.x, b.y, b.z, strict=True)]
            )
            assert s.weight == pytest.approx(found.weight, rel=1e-13)
            assert (s.x_g, s.y_g, s.z_g) == pytest.approx(found.centre, abs=1e-12)


# Air


def test_the_bank_flow_is_choked_until_the_tank_has_half_its_pressure() -> None:
    # St. Venant's equation for air, against the quarter ellipse used
    def st_venant(ratio: float) -> float:
        return math.sqrt(ratio ** (2 / 1.4) - ratio ** (2.4 / 1.4))

    choked = st_venant((2 / 2.4) ** 3.5)
    for ratio in (0.01, 0.3, 0.52):
        assert air.sonic_share(ratio) == 1.0
    for ratio in np.linspace(0.53, 0.999, 40):
        assert air.sonic_share(ratio) == pytest.approx(st_venant(ratio) / choked, abs=0.02)
    assert air.sonic_share(1.0) == 0.0


def test_a_full_bank_gives_the_flow_of_a_choked_nozzle(tanks: Tanks) -> None:
    tanks.state.blow_forward = 1.0

    tanks.run(H)

    # 0.0404 p A/sqrt(T): any text-book on gas dynamics, air
    expected = 0.04042 * 25e6 * 80e-6 / math.sqrt(283.15) * H
    assert tanks.state.air_forward == pytest.approx(expected, rel=1e-3)
    assert tanks.state.bank_emergency == tanks.b.bank_full[1]


def test_a_blow_leaves_the_bank_at_the_pressure_of_the_sea_and_no_lower() -> None:
    tanks = Tanks(400.0)
    tanks.state.blow[:3] = 2.0

    tanks.run(3600.0)

    # at 400 m two banks of 7 m3 at 25 MPa cannot empty 470 m3: 2 x 7 x (25 - 4.1)/4.1 = 71 m3
    top = ATMOSPHERIC_PRESSURE + 1025 * 9.81 * (400.0 - 0.47 - 3.5)
    assert top < tanks.pressure(1) < 1.05 * top
    assert tanks.pressure(0) > top
    blown = sum(tanks.volume(i) for i in range(3))
    assert blown == pytest.approx(71.0, rel=0.02)


def test_a_valve_that_empties_its_bank_within_a_tick_stops_at_equal_pressure(tanks: Tanks) -> None:
    s, b = tanks.state, tanks.b
    b.blow_area[0] = 1.0
    aboard = s.bank_main
    s.blow_forward = 1.0

    tanks.run(H)

    level = 60.0 - 0.47 - 3.5
    assert tanks.pressure(0) == pytest.approx(ATMOSPHERIC_PRESSURE + 1025 * 9.81 * level)
    assert s.bank_main + s.air_forward - s.air_taken == pytest.approx(aboard, rel=1e-14)


def test_with_no_valve_open_air_in_a_tank_keeps_its_mass_and_follows_the_pressure() -> None:
    tanks = Tanks(100.0)
    s = tanks.state
    s.blow_aft = 1.0
    tanks.run(20.0)
    s.blow_aft = 0.0
    tanks.run(20.0)
    mass, deep = s.air_aft, tanks.volume(2)

    s.z = 40.0
    tanks.run(60.0)
    shallow = tanks.volume(2)
    s.z = 100.0
    tanks.run(60.0)

    assert s.air_aft == mass
    assert shallow == pytest.approx(deep * 108.0 / 48.0, rel=0.03)  # about 10 m water an atmosphere
    assert tanks.volume(2) == pytest.approx(deep, rel=1e-9)


def test_air_that_an_empty_tank_cannot_hold_bubbles_out() -> None:
    tanks = Tanks(40.0)
    s = tanks.state
    s.blow[:3] = 2.0
    tanks.run(120.0)
    s.blow[:] = 0.0
    assert s.water_forward == 0.0
    held, spent = s.air_forward, s.air_taken

    s.z = 10.0
    tanks.run(10.0)

    assert s.water_forward == 0.0
    assert s.air_forward < 0.6 * held
    assert s.air_taken < spent


def test_an_open_vent_floods_a_tank_under_water_within_a_minute_or_two() -> None:
    tanks = Tanks(20.0)
    s = tanks.state
    s.blow[:3] = 2.0
    tanks.run(60.0)
    s.blow[:] = 0.0
    s.vent_forward = 1.0

    tanks.run(90.0)

    assert s.water_forward == tanks.b.capacity[0]
    assert s.air_forward == 0.0
    assert s.water_aft < tanks.b.capacity[2]


def test_at_the_surface_open_vents_flood_only_to_the_level_of_the_sea() -> None:
    tanks = Tanks(20.0)
    s = tanks.state
    s.blow[:3] = 2.0
    tanks.run(60.0)
    s.z, s.blow[:], s.vent[:3] = 2.0, 0.0, 1.0

    tanks.run(300.0)

    # vents 1.97 m above the water, 7 m above the ports
    assert tanks.volume(0) == pytest.approx(180.0 * 1.97 / 7.0, rel=1e-3)
    assert s.air_forward == pytest.approx(
        ATMOSPHERIC_PRESSURE * tanks.volume(0) / tanks.b.gas, rel=1e-3
    )


def test_a_full_tank_out_of_the_water_runs_down_to_the_level_of_the_sea_by_its_vent() -> None:
    tanks = Tanks(2.0)
    s = tanks.state
    tanks.run(60.0)
    assert s.water_aft == tanks.b.capacity[2]
    s.vent_aft = 1.0

    tanks.run(300.0)

    assert tanks.volume(2) == pytest.approx(180.0 * 1.97 / 7.0, rel=1e-3)
    assert s.air_taken == s.air_aft > 0.0


def test_the_compressor_charges_the_banks_and_not_beyond_full(tanks: Tanks) -> None:
    s = tanks.state
    s.bank[:] = tanks.b.bank_full - [30.0, 15.0]
    tanks.run(60.0)
    assert s.bank_main == tanks.b.bank_full[0] - 30.0
    s.compressor, s.z = 1.0, tanks.b.intake_depth + 0.1
    tanks.run(400.0)
    assert s.air_taken == 0.0  # there is no air from above
    s.z = tanks.b.intake_depth

    tanks.run(100.0)
    assert s.bank.sum() == pytest.approx(tanks.b.bank_full.sum() - 45.0 + 15.0)

    tanks.run(400.0)
    assert s.bank.tolist() == tanks.b.bank_full.tolist()


def test_the_negative_tank_is_sealed_until_its_flood_valve_opens(tanks: Tanks) -> None:
    s = tanks.state
    s.vent_negative = s.blow_negative = 1.0
    tanks.run(60.0)
    assert s.water_negative == 0.0
    assert s.bank_main == tanks.b.bank_full[0]

    s.blow_negative, s.negative_flood = 0.0, 1.0
    tanks.run(60.0)
    assert s.water_negative == tanks.b.capacity[3]
    assert s.x_g > 0.0

    s.vent_negative, s.blow_negative = 0.0, 1.0
    tanks.run(60.0)
    s.negative_flood = s.blow_negative = 0.0
    assert s.water_negative == 0.0


# Pumps


@pytest.mark.parametrize(("depth", "share"), [(0.0, 1.0), (150.0, 0.75**0.5), (450.0, 0.5)])
def test_a_pump_against_the_sea_delivers_less_with_depth(depth: float, share: float) -> None:
    tanks = Tanks(depth)
    tanks.state.move_depth_control = -15 * TONNE

    tanks.run(10.0)

    assert tanks.state.water_taken == pytest.approx(-333.0 * share)


def test_below_its_shut_off_depth_a_pump_lets_in_but_not_out() -> None:
    tanks = Tanks(650.0)
    tanks.state.move_depth_control = -TONNE
    tanks.run(10.0)
    assert tanks.state.water_taken == 0.0

    tanks.state.move_depth_control = 100.0
    tanks.run(10.0)
    assert tanks.state.water_taken == pytest.approx(100.0)


def test_an_order_is_carried_out_to_its_last_kilogram_and_then_ends(tanks: Tanks) -> None:
    s = tanks.state
    before = s.water.copy()
    s.move_auxiliary, s.move_trim = 1234.5, -777.7

    tanks.run(300.0)

    moved = dict(zip(TANKS, s.water - before, strict=True))
    assert moved["auxiliary"] == pytest.approx(1234.5, abs=1e-9)
    assert (moved["trim_forward"], moved["trim_aft"]) == pytest.approx((-777.7, 777.7), abs=1e-9)
    assert s.to_move.tolist() == [0.0, 0.0, 0.0]


@pytest.mark.parametrize("sign", [1, -1])
@pytest.mark.parametrize("more", [-3 * TONNE, 3 * TONNE])
def test_an_order_beyond_full_or_empty_lapses(tanks: Tanks, sign: int, more: float) -> None:
    s = tanks.state
    s.water_trim_forward += more
    total = s.water_trim_forward + s.water_trim_aft
    full = tanks.b.capacity[TANKS.index("trim_forward")]
    s.to_move[:] = [sign * 500 * TONNE, 500 * TONNE, -500 * TONNE]

    tanks.run(3000.0)

    to, fro = (s.water_trim_forward, s.water_trim_aft)[::sign]
    assert (to, fro) == pytest.approx((min(total, full), max(total - full, 0.0)))
    assert s.water_depth_control == 0.0
    assert s.water_auxiliary == tanks.b.capacity[TANKS.index("auxiliary")]
    assert s.to_move.tolist() == [0.0, 0.0, 0.0]


# Flooding


def test_a_hole_lets_in_water_by_the_orifice_law() -> None:
    for depth in (50.0, 200.0):
        tanks = Tanks(depth)
        tanks.state.breach_aft = 0.01

        tanks.run(H)

        below = depth + 0.5
        expected = 0.6 * 0.01 * 1025.0 * math.sqrt(2 * 9.81 * below) * H
        assert tanks.state.flood_aft == pytest.approx(expected, rel=1e-9)


def test_a_sealed_compartment_stops_flooding_when_its_air_has_the_pressure_of_the_sea() -> None:
    tanks = Tanks(90.0)
    s = tanks.state
    s.breach_forward = 0.5

    tanks.run(600.0)

    outside = ATMOSPHERIC_PRESSURE + 1025 * 9.81 * 90.5
    full = 450.0 * 1025.0
    assert s.flood_forward == pytest.approx(full * (1.0 - ATMOSPHERIC_PRESSURE / outside), rel=1e-9)
    assert s.x_g > 0.5


def test_a_closed_breach_lets_nothing_in_and_the_drain_pump_empties_the_compartment() -> None:
    tanks = Tanks(50.0)
    s = tanks.state
    s.breach_centre = 0.02
    tanks.run(10.0)
    s.breach_centre, flooded = 0.0, s.flood_centre
    tanks.run(60.0)
    assert s.flood_centre == flooded > TONNE
    s.drained, s.move_auxiliary = 2.0, 500.0

    tanks.run(10.0)
    assert flooded - s.flood_centre == pytest.approx(200.0 * math.sqrt(1.0 - 50.0 / 600.0))
    assert s.move_auxiliary == 500.0, "one pump: the compartment goes first"

    tanks.run(600.0)
    assert s.flood_centre == 0.0


# The whole boat


def stopped(depth: float) -> Boat:
    """Return BB2 dead in the water, in hand."""
    boat = start_bb2(depth=depth)
    s = boat.state
    s.motion[:9] = s.rates[:] = 0.0
    s.u_c = s.ordered_u_c = s.telegraph_answer = s.telegraph_order = 0.0
    s.surface[:] = s.ordered[:] = 0.0
    s.by_hand[:] = s.speed_by_hand = 1.0
    ballast.start_ballast(boat.records.vessel, boat.records.state)
    return boat


def ticks(boat: Boat, seconds: float) -> list[float]:
    """Run the boat; return the depth at each tick."""
    depths = []
    for _ in range(round(seconds / H)):
        assert boat.tick() == 0
        depths.append(float(boat.state.z))
    return depths


@pytest.mark.long
def test_hovering_takes_up_three_tonnes_and_settles_at_its_depth() -> None:
    boat = stopped(60.0)
    s = boat.state
    s.hover, s.ordered_depth = 1.0, 60.0
    s.water_auxiliary += 3 * TONNE

    depths = ticks(boat, 1500.0)

    # 3 t take the pump 90 s; until then she sinks
    assert max(depths) < 85.0
    assert min(depths) > 50.0
    assert abs(np.array(depths[-600:]) - 60.0).max() < 1.3
    assert s.water_depth_control == pytest.approx(17.5 * TONNE, rel=0.01)


@pytest.mark.long
def test_hovering_changes_depth_without_overshoot() -> None:
    boat = stopped(60.0)
    ticks(boat, 5.0)
    boat.state.hover, boat.state.ordered_depth = 1.0, 75.0

    depths = ticks(boat, 1200.0)

    assert max(depths) < 75.5
    assert depths[-1] == pytest.approx(75.0, abs=0.3)


# Buoyancy


def lift(constants: Record, **places: float) -> np.ndarray:
    """Return the six forces of changed buoyancy at a place and attitude."""
    record = new_state()
    for name, value in places.items():
        record[name] = value
    force = np.zeros(6)
    buoyancy.add_compression(with_tanks(FITTED.vessel, constants), record, force)
    surfaced.add_waterplane(FITTED.vessel, new_scratch(), record, force)
    return force


def test_a_segment_of_a_circle_is_right_to_half_a_percent() -> None:
    for t in np.linspace(0.0, 1.0, 41):
        angle = 2.0 * math.acos(1.0 - 2.0 * t)
        exact = (angle - math.sin(angle)) / (2.0 * math.pi)
        assert buoyancy.segment(t) == pytest.approx(exact, abs=0.005)
    assert (buoyancy.segment(-0.1), buoyancy.segment(1.1)) == (0.0, 1.0)


def test_the_surface_takes_buoyancy_from_what_is_above_it() -> None:
    constants = ballast_record(BB2)
    whole = FITTED.vessel[0].buoyancy

    assert lift(constants, z=60.0).tolist() == [0.0] * 6
    assert lift(constants, z=5.8).tolist() == [0.0] * 6
    axis = -float(constants[0].hull_axis)
    half = lift(constants, z=-float(constants[0].hull_axis))
    assert -axis == pytest.approx(-0.4724, abs=1e-3)  # middle of keel 4.83 and deck -5.77
    assert half[2] == pytest.approx(0.5 * whole, rel=1e-3)
    assert lift(constants, z=-10.0)[2] == pytest.approx(whole)
    # her main ballast blown she floats with 10.9 % of her volume out of the water
    blown = float(constants[0].capacity[:3].sum()) * FITTED.vessel[0].g
    assert lift(constants, z=3.5)[2] > blown > lift(constants, z=4.5)[2]


def test_a_bow_out_of_the_water_is_heavy_and_falls_back() -> None:
    constants = ballast_record(BB2)

    up, down = (lift(constants, z=6.0, theta=theta) for theta in (0.3, -0.3))

    assert up[4] < -1e7
    assert down[4] > 1e7
    rolled = [lift(constants, z=3.0, phi=phi) for phi in (0.2, -0.2)]
    assert rolled[0][1] == pytest.approx(-rolled[1][1])
    assert rolled[0][2] == pytest.approx(rolled[1][2])


def test_a_soft_hull_loses_buoyancy_with_depth_and_a_denser_layer_gives_it() -> None:
    constants = ballast_record(BB2)
    b = constants[0]
    b.compressibility, b.reference_depth = 50.0, 60.0

    assert lift(constants, z=160.0)[2] == pytest.approx(100 * 50.0 * 9.81)
    assert lift(constants, z=60.0)[2] == 0.0

    b.compressibility, b.layers = 0.0, 2
    b.layer_depth[:2], b.layer_density[:2] = [80.0, 100.0], [0.0, 2.0]
    weight = FITTED.vessel[0].buoyancy / 1025.0
    for depth, excess in ((50.0, 0.0), (90.0, 1.0), (100.0, 2.0), (300.0, 2.0)):
        assert lift(constants, z=depth)[2] == pytest.approx(-excess * weight, abs=1e-6)


# Files


def refused(old: str, new: str) -> str:
    """Return what BB2's file is refused for with one passage changed."""
    assert old in BB2.text
    with pytest.raises(ConfigError) as caught:
        parse_vessel(BB2.text.replace(old, new, 1), Path("bb2.toml"))
    return str(caught.value)


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        (
            'name = "mid"',
            'name = "middle"',
            '[ballast.blown[1]] name = "middle": must be forward or mid or aft or negative',
        ),
        ('name = "mid"', 'name = "aft"', "[ballast] blown: aft is given twice"),
        (
            "start_fill = 0.5",
            "start_fill = 1.5",
            "[ballast.pumped[0]] start_fill = 1.5: must be 0 to 1",
        ),
        ("drain_kg_s", "drian_kg_s", "[ballast.pumps] drian_kg_s = 20.0: no such key"),
        (
            "layer_depth_m = []",
            "layer_depth_m = [50, 40]",
            "[ballast] sea.layer_kg_m3 = []: has 0 entries, layer_depth_m has 2",
        ),
        ("[ballast.air]", "[ballast.hair]", "hair"),
    ],
)
def test_a_wrong_arrangement_is_refused_with_the_place(old: str, new: str, message: str) -> None:
    assert message in refused(old, new)


def test_the_document_names_every_tank() -> None:
    text = (ROOT / "docs" / "ballast.md").read_text(encoding="utf-8")

    for name in (*BLOWN_TANKS, *PUMPED_TANKS):
        assert f"`{name}`" in text


def test_a_boat_file_without_the_table_has_no_tanks() -> None:
    boat = load_vessel("sdv-mk9")

    assert boat.ballast is None
    record = ballast_record(boat)[0]
    assert record.fitted == 0.0
    assert record.hull_diameter > 0.0
    assert new_ballast()[0].fitted == 0.0
