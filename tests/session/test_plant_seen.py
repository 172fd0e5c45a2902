"""What a crew sees of the plant, and who sees what; the cause is the instructor's."""

from helpers.boats import make_boat
from helpers.crewed import Crewed
from helpers.line import Line, fields_of
from helpers.sessions import frame_of, prompt_sender

from trainer.session.stations.channels import CHANNELS
from trainer.session.stations.display import panel
from trainer.session.stations.roles import ROLES, Access
from trainer.session.stations.station import Station

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
