"""The plant by its kernels: the numbers of an independent program, and what is fed.

The fixed numbers come from a second program, written from the statement of the model alone.
"""

import math

import numpy as np
import pytest

from trainer.boat.assemble import Method
from trainer.boat.boat import Boat
from trainer.boat.helm import obey_order
from trainer.boat.plant import plant_facts
from trainer.config.boat.vessel import load_vessel
from trainer.core.plant.fire import advance_fire
from trainer.core.plant.oil import advance_oil, draw_oil, fed_share, oil_pressure, rate_share
from trainer.core.plant.parts import (
    BUS_NAMES,
    CONSUMER_NAMES,
    FIRST_LEG,
    MAIN,
    PORT,
    RUNNING,
    is_dead,
)
from trainer.core.plant.plant import work_plant
from trainer.core.plant.power import bus_load, drain_battery
from trainer.io.orders.grammar import Order, parse
from trainer.units import KNOT

H = 0.5  # [s]
AFT = 2
FIRE_AFT = 13  # in plant_fault


@pytest.fixture
def boat() -> Boat:
    """Return BB2 at 10 kn and 60 m, with all of its plant well."""
    made = Boat(load_vessel("bb2"), Method("modified", "lagged", "exact", "adams2", H))
    made.start(10.0 * KNOT, 60.0, 0.0)
    return made


def ordered(boat: Boat, *lines: str) -> None:
    """Give orders that must be taken."""
    for line in lines:
        order = parse(line)
        assert isinstance(order, Order), line
        answer = obey_order(boat, order)
        assert isinstance(answer, str), answer


def pressure(boat: Boat) -> float:
    """Return the pressure of the main system [MPa]."""
    return 1e-6 * float(oil_pressure(boat.records.vessel, MAIN, boat.records.state))


@pytest.mark.parametrize(
    ("litres", "shown"),
    [(120, 20.7), (102, 17.8371), (60, 13.4853), (20, 10.9427), (0.001, 10.0), (0, 0.0)],
)
def test_an_accumulator_has_the_pressure_of_its_gas(
    boat: Boat, litres: float, shown: float
) -> None:
    boat.state.oil_spent_main = 0.120 - 1e-3 * litres

    assert pressure(boat) == pytest.approx(shown, rel=5e-6)


@pytest.mark.parametrize(
    ("mpa", "share"),
    [(20.7, 1.0), (14, 1.0), (12, 0.881917), (10, 0.745356), (5.5, 0.235702), (5, 0.0)],
)
def test_a_surface_has_the_share_of_its_rate_that_the_pressure_gives(
    boat: Boat, mpa: float, share: float
) -> None:
    assert rate_share(boat.records.vessel, 1e6 * mpa) == pytest.approx(share, abs=5e-7)


def test_two_and_a_half_strokes_are_in_an_accumulator_without_pumps(boat: Boat) -> None:
    vessel, state = boat.records.vessel, boat.records.state
    rate, angle = math.radians(7.1) * H, 0.0
    found = []
    for ordered_deg in (30.0, -30.0, 30.0, -30.0):
        target, ticks = math.radians(ordered_deg), 0
        while abs(angle - target) > 1e-12:
            most = rate * float(fed_share(vessel, 1, state))
            if most == 0.0:
                break
            step = max(-most, min(most, target - angle))
            draw_oil(vessel, 0.0, abs(step), 0.0, state)
            angle += step
            ticks += 1
        litres = 1e3 * (0.120 - float(boat.state.oil_spent_main))
        found.append((ticks, round(litres, 3), round(pressure(boat), 4)))

    assert found == [(9, 100.0, 17.5672), (17, 60.0, 13.4853), (19, 20.0, 10.9427), (11, 0.0, 0.0)]
    assert math.degrees(angle) == pytest.approx(-0.479671, abs=5e-7)
    assert boat.state.tank_gain_main == pytest.approx(0.120), "oil that was drawn is in the tank"


def test_a_leak_runs_the_pumps_and_then_the_tank_dry(boat: Boat) -> None:
    vessel, state, s = boat.records.vessel, boat.records.state, boat.state
    s.plant_fault[FIRST_LEG + 1] = 2e-3
    moments: dict[str, float] = {}
    for tick in range(1, 401):
        advance_oil(vessel, H, state)
        tank, oil = 0.200 + float(s.tank_gain_main), 0.120 - float(s.oil_spent_main)
        met = {
            "pump 1": s.hydraulic_pump_1 == RUNNING,
            "pump 2": s.hydraulic_pump_2 == RUNNING,
            "half": tank < 0.1,
            "dry": tank <= 0.0,
            "below 14": pressure(boat) < 14.0,
            "empty": oil <= 0.0,
        }
        for what, is_met in met.items():
            if is_met:
                moments.setdefault(what, tick * H)
        if tick == 200:
            assert 1e3 * oil == pytest.approx(119.0, rel=5e-6)
            assert 1e3 * tank == pytest.approx(15.3443, rel=5e-6)
            assert pressure(boat) == pytest.approx(20.5171, rel=5e-6)

    shown = {"pump 1": 9.5, "pump 2": 62.5, "half": 69.0, "dry": 108.0}
    assert moments == {**shown, "below 14": 137.0, "empty": 181.5}


@pytest.mark.parametrize(
    ("knots", "kilowatts", "hours"),
    [(5, 240.45, 48.2491), (10, 809.2, 13.2928), (15, 2352.95, 3.81696), (20, 5359.2, 1.2682)],
)
def test_a_battery_lasts_so_long_at_a_speed(
    boat: Boat, knots: float, kilowatts: float, hours: float
) -> None:
    vessel, state = boat.records.vessel, boat.records.state
    boat.state.u_c = knots * KNOT
    boat.state.trim_forward = boat.state.trim_flood = 0.0

    drain_battery(vessel, H, state)

    loads = sum(float(bus_load(vessel, bus, state)) for bus in range(len(BUS_NAMES)))
    assert loads == pytest.approx(159.2e3)
    assert loads + 5.2e6 * (knots / 20.0) ** 3 == pytest.approx(1e3 * kilowatts, rel=5e-6)
    spent = float(boat.state.battery_spent) / H
    assert float(boat.vessel.battery_full) / spent / 3600.0 == pytest.approx(hours, rel=5e-6)


def test_a_fire_grows_and_smokes_as_the_statement_has_it(boat: Boat) -> None:
    vessel, state, s = boat.records.vessel, boat.records.state, boat.state
    s.plant_fault[FIRE_AFT] = 1.0
    found = []
    for tick in range(1, 721):
        advance_fire(vessel, H, state)
        if tick in (120, 240, 480, 720):
            found.append([float(s.fire_aft), float(s.burnt[AFT]), float(s.smoke_aft)])

    assert np.array(found) == pytest.approx(
        np.array(
            [
                [0.124782, 4.95493, 0.0720036],
                [0.278795, 16.635, 0.208707],
                [0.740725, 78.1079, 0.608974],
                [0.95504, 182.958, 0.807078],
            ]
        ),
        rel=5e-6,
    )


def test_a_fire_that_is_fought_well_is_out_at_its_time(boat: Boat) -> None:
    vessel, state, s = boat.records.vessel, boat.records.state, boat.state
    s.plant_fault[FIRE_AFT] = 1.0
    s.ventilation = s.starboard_dead = 1.0
    out = 0.0
    for tick in range(1, 601):
        if tick == 51:  # 25 s, and the party takes 60 s
            s.fighting, s.fight_ticks = 3.0, -1.0
        advance_fire(vessel, H, state)
        if s.fire_aft == 0.0 and not out:
            out = tick * H

    assert out == 248.0
    assert s.burnt[AFT] == pytest.approx(17.841, rel=5e-6)
    assert s.fire_aft == 0.0, "its casualty does not kindle it again"


def test_a_fire_that_is_cleared_gives_back_what_it_burnt(boat: Boat) -> None:
    s = boat.state
    ordered(boat, "casualty fire-aft")
    for _ in range(700):
        boat.tick()
    assert s.starboard_dead == 1.0
    assert is_dead(CONSUMER_NAMES.index("propulsion"), boat.records.state) == (
        s.burnt[AFT] >= 180.0
    )

    ordered(boat, "clear fire-aft")
    boat.tick()
    boat.tick()

    assert (s.fire_aft, s.burnt[AFT], s.starboard_dead, s.unpowered) == (0.0, 0.0, 0.0, 0.0)


def test_a_bus_that_is_lost_stops_what_hangs_on_it_alone(boat: Boat) -> None:
    s = boat.state
    ordered(boat, "casualty bus-starboard-lost")
    boat.tick()

    dead = {name for i, name in enumerate(CONSUMER_NAMES) if is_dead(i, boat.records.state)}
    assert dead == {"hydraulic_2", "drain", "compressor", "log", "sounder"}
    assert bus_load(boat.records.vessel, 1, boat.records.state) == 0.0

    ordered(boat, "loads shed", "bus tie shut")
    boat.tick()

    assert s.unpowered == 0.0
    assert bus_load(boat.records.vessel, 1, boat.records.state) > 0.0


def test_the_gyro_goes_on_for_a_quarter_of_an_hour(boat: Boat) -> None:
    s, gyro = boat.state, CONSUMER_NAMES.index("gyro")
    s.port_fault = 1.0
    for tick in range(1, 1803):
        work_plant(boat.records.vessel, H, boat.records.state)
        assert is_dead(gyro, boat.records.state) == (tick > 1800)


def test_an_overload_opens_the_breaker_and_the_tie_after_20_s(boat: Boat) -> None:
    s = boat.state
    ordered(boat, "breaker port open", "compressor on", "breaker port shut", "bus tie shut")
    s.port_fault = 1.0
    for _ in range(39):
        work_plant(boat.records.vessel, H, boat.records.state)
    assert (s.starboard_open, s.bus_tie, s.overload) == (0.0, 1.0, 19.5)

    work_plant(boat.records.vessel, H, boat.records.state)
    work_plant(boat.records.vessel, H, boat.records.state)

    assert (s.starboard_open, s.bus_tie, s.overload) == (1.0, 0.0, 0.0)
    assert (s.port_dead, s.starboard_dead, s.dc_dead) == (1.0, 1.0, 0.0)


def test_cells_that_are_lost_take_their_share_of_the_charge(boat: Boat) -> None:
    s, full = boat.state, float(boat.vessel.battery_full)
    s.battery_spent = 0.5 * full
    s.cells_fault = 0.4
    work_plant(boat.records.vessel, 1e-9, boat.records.state)
    assert s.battery_spent == pytest.approx(0.7 * full)

    s.cells_fault = 0.0
    work_plant(boat.records.vessel, 1e-9, boat.records.state)
    assert s.battery_spent == pytest.approx(0.7 * full), "bridged cells do not charge it"


def test_an_empty_battery_leaves_all_dead(boat: Boat) -> None:
    s = boat.state
    s.battery_spent = float(boat.vessel.battery_full) - 1.0
    for _ in range(22):
        boat.tick()

    assert [s.bus_dead[i] for i in range(3)] == [1.0, 1.0, 1.0]
    assert is_dead(CONSUMER_NAMES.index("propulsion"), boat.records.state)
    assert s.plant_touched == 1.0


def test_smoke_is_exhausted_where_there_is_air_from_above(boat: Boat) -> None:
    s = boat.state
    s.ventilation, s.smoke_control = 2.0, 0.5
    advance_fire(boat.records.vessel, H, boat.records.state)
    assert s.smoke_control == 0.5

    s.z = float(boat.vessel.intake_depth)
    advance_fire(boat.records.vessel, H, boat.records.state)
    assert s.smoke_control == pytest.approx(0.5 - 0.5 * H / 60.0)


def test_power_dips_for_its_seconds(boat: Boat) -> None:
    ordered(boat, "casualty power-dip")
    dead = []
    for _ in range(10):
        boat.tick()
        dead.append(bool(boat.state.bus_dead[PORT]))

    assert dead == [True] * 6 + [False] * 4


def test_a_check_tells_how_long_the_battery_lasts_as_the_core_drains_it() -> None:
    plant = load_vessel("bb2").plant
    assert plant

    facts = plant_facts(plant, 15.0)

    assert facts.endurance_h == pytest.approx(
        {"5": 48.2491, "10": 13.2928, "15": 3.81696}, rel=5e-6
    )
    assert facts.strokes == {"main": 3.0, "vital": 1.5}
