"""What a crew sees of the plant, and who sees what; the cause is the instructor's."""

from typing import cast

import numpy as np
import pytest
from helpers.boats import make_boat, start_bb2, start_boat
from helpers.crewed import Crewed
from helpers.line import Line, fields_of
from helpers.sessions import frame_of, prompt_sender

from trainer.boat.boat import Boat
from trainer.boat.flown_ticks import FlownTicks
from trainer.boat.helm import obey_order
from trainer.boat.plant_alerts import PlantMonitor
from trainer.io.orders.grammar import Order, parse
from trainer.session.stations.channels import CHANNELS
from trainer.session.stations.display import panel
from trainer.session.stations.roles import ROLES, Access
from trainer.session.stations.station import Station
from trainer.units import KNOT

ORDERS = ("role ballast", "subscribe plant", "subscribe tanks")


def shown(line: Line, channel: str) -> dict[str, str]:
    """Return the last values that a program was sent of a channel."""
    *_, last = (each for each in fields_of(line.sent, "TRS") if each[0] == channel)
    names = [field.name for field in CHANNELS[channel].fields]
    return dict(zip(names, last[3:], strict=True))


def test_a_crew_sees_what_broke_by_pressure_and_bus_and_the_instructor_the_cause(
    ship: Crewed,
) -> None:
    ballast, planes = ship.comes("ballast"), ship.comes("planes")
    for line, channel in ((ballast, "plant"), (planes, "supply"), (ship.instructor, "casualties")):
        assert ship.say(line, f"subscribe {channel}")[0] == "ok"
    assert ship.say(planes, "subscribe plant")[0] == "no"
    for order in ("casualty oil-leak-header", "casualty bus-port-lost"):
        assert ship.say(ship.instructor, order)[0] == "ok"
    ship.say(planes, "stern planes emergency")
    ship.fly(2)
    assert shown(planes, "supply")["stern_shifted_to"] == "emergency"
    ship.fly(18)

    seen, moved = shown(ballast, "plant"), shown(planes, "supply")

    assert (seen["port_bus"], seen["starboard_bus"]) == ("dead", "live")
    assert "autopilot" in seen["dead"]
    assert float(seen["main_pressure"]) < 16.0 < float(seen["vital_pressure"])
    assert (moved["stern_supply"], moved["bow_supply"]) == ("emergency", "normal")
    assert moved["main_pressure"] == seen["main_pressure"]
    assert not any("oil-leak" in told for told in (*ballast.sent, *planes.sent))
    assert "oil-leak-header" in shown(ship.instructor, "casualties").values()


def test_who_works_a_surface_sees_what_moves_it_and_who_works_the_plant_sees_it_whole() -> None:
    has = {
        channel: {name for name, role in ROLES.items() if channel in role.channels}
        for channel in ("plant", "supply")
    }
    whole = {"ballast", "diving", "pilot", "trainee", "instructor", "observer"}

    assert has["plant"] == whole
    assert has["supply"] == whole - {"ballast"} | {"helm", "planes"}


def test_a_boat_without_a_plant_has_no_such_channel() -> None:
    boat = make_boat("remus100")
    boat.start(2.0, 10.0, 0.0)
    line = Line("line 1")
    station = Station(line, Access(), prompt_sender(boat), lambda *_: None)
    line.waiting = [*ORDERS]

    list(station.take(len(ORDERS)))

    assert "plant" not in " ".join(line.sent[:-3])
    assert "you may see" in " ".join(line.sent[:-3])
    assert "no [plant] table" in line.sent[-2]
    assert line.sent[-1].startswith("tanks")


def test_its_past_is_told_as_it_was_shown(ship: Crewed) -> None:
    ballast = ship.comes("ballast")
    ship.order("casualty oil-leak-header")
    ship.fly(20)
    ship.recording.flush()
    now = panel(("plant",), frame_of(ship.boat))

    assert ship.say(ballast, "history plant 1 min")[0] == "ok"

    ship.settle(lambda: "end,plant" in ship.facts(ballast, "past"))
    told = shown(ballast, "plant")
    assert f"main_pressure {told['main_pressure']} MPa" in " ".join(now)
    rows = [each for each in fields_of(ballast.sent, "TRS") if each[0] == "plant"]
    assert len(rows) > 5
    assert rows[0][3] == "20.7"


# Alerts


def called(line: Line) -> list[tuple[float, str]]:
    """Return the time [s] and the words of each alert of the plant that a line was told."""
    told = [each[1:] for each in fields_of(line.sent, "TRE") if each[2] == "plant"]
    return [(float(seconds), text.rpartition(" s): ")[2]) for seconds, _, text in told]


def test_a_leak_is_called_from_low_oil_to_its_end_and_is_over_when_it_is_mended(
    ship: Crewed,
) -> None:
    ballast = ship.comes("ballast")
    ship.order("casualty oil-leak-header")
    ship.fly(46)

    words = [text.partition(" [")[0] for _, text in called(ballast)]
    assert words == [
        *("OIL LOW: main below 16 MPa", "MAIN OIL LOST: what is in normal stands still"),
    ]
    assert {"oil low:main", "main oil lost"} <= ship.session.holding()
    ship.order("clear oil-leak-header")
    ship.fly(300)
    assert not {"oil low:main", "main oil lost"} & ship.session.holding()
    assert "oil tank half:main" in ship.session.holding()  # what ran out is gone


def test_an_overload_is_called_before_its_breaker_opens(ship: Crewed) -> None:
    ballast = ship.comes("ballast")
    for order in ("casualty bus-port-lost", "compressor on", "bus tie shut"):
        ship.order(order)
    ship.fly(60)

    seconds, words = zip(*called(ballast), strict=True)
    assert [text.partition(" [")[0] for text in words] == [
        *("OVERLOAD: a breaker opens in 20 s", "BUS LOST: port", "BUS LOST: starboard"),
    ]
    assert seconds[1] - seconds[0] == pytest.approx(20.0, abs=0.6)


def test_smoke_is_called_where_it_is_seen_and_nothing_while_the_plant_is_well(
    ship: Crewed,
) -> None:
    helm = ship.comes("helm")
    ship.fly(20)
    assert not called(helm)
    ship.order("casualty fire-aft")
    ship.fly(200)

    first, *others = called(helm)
    assert first[1].startswith("FIRE: smoke aft")
    assert ship.boat.state.smoke[2] > 0.05
    assert [text.partition(" [")[0] for _, text in others[:1]] in ([], ["FIRE: smoke control"])


def test_flown_at_once_it_is_called_at_the_same_ticks() -> None:
    boat = start_bb2()
    for order in ("casualty oil-leak-stern", "casualty fire-aft", "casualty bus-port-lost"):
        told = parse(order)
        assert isinstance(told, Order)
        assert isinstance(obey_order(boat, told), str)
    watch, at_once = PlantMonitor.over(boat), PlantMonitor.over(boat)
    rows, ticks = [], []
    for _ in range(600):
        assert boat.tick() == 0
        rows.append(boat.records.state["whole"][0].copy())
        ticks += [boat.ticks] * bool(watch.look(boat))
    flown = FlownTicks(np.array(rows), boat.method.step)

    quiet = at_once.quiet_ticks(boat, flown)

    assert len(ticks) > 4
    assert quiet + 1 == ticks[0]
    assert PlantMonitor.over(make_boat("remus100")).quiet_ticks(boat, flown) == 600


# The battery, which nobody has touched


def with_charge(boat: Boat, charge: float) -> Boat:
    """Have the battery hold a share of its charge."""
    boat.state.battery_spent = (1.0 - charge) * boat.vessel.battery_full
    return boat


def calls_in(watch: PlantMonitor, boat: Boat, ticks: int) -> list[tuple[str, float]]:
    """Return the key and the charge at each call within so many ticks."""
    calls = []
    for _ in range(ticks):
        assert boat.tick() == 0
        charge = 1.0 - float(boat.state.battery_spent / boat.vessel.battery_full)
        calls += [(call.key, charge) for call in watch.look(boat)]
    return calls


def test_a_battery_that_drains_untouched_is_called_low_and_then_nearly_flat() -> None:
    boat = with_charge(start_bb2(), 0.4002)
    watch = PlantMonitor.over(boat)

    low = calls_in(watch, boat, 100)
    watch.reset_to(with_charge(boat, 0.2002))
    flat = calls_in(watch, boat, 100)

    assert boat.state.plant_touched == 0.0
    (low_key, low_charge), (flat_key, flat_charge) = *low, *flat
    assert (low_key, flat_key) == ("battery low", "battery nearly flat")
    assert 0.3995 < low_charge < 0.4
    assert 0.1995 < flat_charge < 0.2


@pytest.mark.parametrize("charge", [0.249, 0.251, 0.449, 0.451])
def test_an_alert_of_the_battery_is_over_well_above_where_it_begins(charge: float) -> None:
    boat = with_charge(start_bb2(), 0.1)
    watch = PlantMonitor.over(boat)
    assert watch.holding == {"battery low", "battery nearly flat"}

    watch.reset_to(with_charge(boat, charge))

    over = {"battery nearly flat"} if charge >= 0.25 else set()
    over |= {"battery low"} if charge >= 0.45 else set()
    assert watch.holding == {"battery low", "battery nearly flat"} - over


def test_full_speed_for_a_minute_calls_the_battery_by_its_minutes() -> None:
    """At 20 kn a whole charge lasts 76 min: 60 are left at 79 %, 20 at 26 %."""
    boat = with_charge(start_boat(20.0 * KNOT), 0.795)
    watch = PlantMonitor.over(boat)

    low = calls_in(watch, boat, 200)
    watch.reset_to(with_charge(boat, 0.27))
    flat = calls_in(watch, boat, 200)

    assert [key for key, _ in low + flat] == ["battery low", "battery nearly flat"]
    assert low[0][1] == pytest.approx(60.0 / 76.1, abs=5e-3)
    assert flat[0][1] == pytest.approx(20.0 / 76.1, abs=5e-3)


def test_half_a_minute_of_full_speed_is_no_draw_of_the_last_minute() -> None:
    boat = with_charge(start_bb2(), 0.5)
    watch = PlantMonitor.over(boat)
    boat.restore(with_charge(start_boat(20.0 * KNOT), 0.5).snapshot())

    assert not calls_in(watch, boat, 40)
    assert PlantMonitor.over(boat).holding == {"battery low"}  # 38 min at this moment's draw
    assert [key for key, _ in calls_in(watch, boat, 100)] == ["battery low"]


def test_cells_that_are_lost_are_no_draw() -> None:
    boat = start_bb2()
    watch = PlantMonitor.over(boat)
    calls_in(watch, boat, 40)
    assert isinstance(obey_order(boat, cast("Order", parse("casualty cells-lost"))), str)

    assert not calls_in(watch, boat, 300)
    assert 0.4 < 1.0 - boat.state.battery_spent / boat.vessel.battery_full < 0.9


def test_flown_at_once_the_battery_is_called_at_the_same_tick() -> None:
    boat = with_charge(start_boat(18.0 * KNOT), 0.6)
    watch, at_once = PlantMonitor.over(boat), PlantMonitor.over(boat)
    rows, ticks = [], []
    for _ in range(1200):
        assert boat.tick() == 0
        rows.append(boat.records.state["whole"][0].copy())
        ticks += [boat.ticks] * bool(watch.look(boat))

    quiet = at_once.quiet_ticks(boat, FlownTicks(np.array(rows[:20]), boat.method.step))
    at_once.pass_over(boat, FlownTicks(np.array(rows[:20]), boat.method.step))
    further = at_once.quiet_ticks(boat, FlownTicks(np.array(rows[20:]), boat.method.step))

    assert quiet == 20
    assert 20 + further + 1 == ticks[0] > 100
