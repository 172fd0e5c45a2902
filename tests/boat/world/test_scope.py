"""The periscope: horizon and angles, the mast's way by orders alone, and what counts as shown."""

import contextlib
import math
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any, Final

import numpy as np
import pytest
from helpers.boats import make_boat, take_ticks
from helpers.orders import read_order
from helpers.passages import take_measure
from helpers.sessions import frame_of, start_exercise
from helpers.typed import type_command

from trainer.boat.boat import Boat
from trainer.boat.helm import obey_order
from trainer.boat.limits import LimitMonitor
from trainer.boat.world.bottom import TICK_OFFSET
from trainer.boat.world.contacts import contacts_in
from trainer.boat.world.scope import (
    ARC_MINUTE,
    HIGH_POWER,
    LOW_POWER,
    Eye,
    Mast,
    Periscope,
    Sight,
    elevation,
    eye_height,
    hidden_height,
    horizon_distance,
    look_at,
    periscope_of,
    stadimeter_range,
)
from trainer.cli.main import cli
from trainer.config.boat.vessel import parse_vessel
from trainer.config.exercise.exercise import ExerciseLimits, parse_exercise
from trainer.config.world.contacts import SHIP_TYPES
from trainer.debrief.page.data import gather_debrief
from trainer.debrief.passage.ships_met import shown_rows as shown_ticks
from trainer.debrief.passage.trajectory import PASSAGE_COLUMNS, Trajectory
from trainer.io.orders.grammar import Refused
from trainer.io.recording.facts import station
from trainer.io.recording.recording import RecordedEvent, RecordedOrder, Recording
from trainer.session.past.header import plan_of
from trainer.session.resume import bring_up
from trainer.session.stations.channels import CHANNELS

HEAD = 'schema = "exercise/1"\nname = "Look"\nbriefing = "Look."\nduration_s = 600\n'
START = "[initial]\nspeed_kn = {speed}\ndepth_m = {depth}\ncourse_deg = 0\n"
TANKER = '[[contact]]\nname = "big"\ntype = "tanker"\npoints = [[2000, 1000]]\ncourse_deg = 90\n'
UP = 16  # [ticks] of 0.5 s in which BB2's mast comes out


def at_sea(folder: Path, tables: str = "", depth: float = 17.5, speed: float = 5.0) -> Boat:
    """Return a boat under way north among the ships of an exercise."""
    path = folder / "look.toml"
    path.write_text(HEAD + START.format(speed=speed, depth=depth) + tables)
    return start_exercise(path)


def give(boat: Boat, text: str) -> str:
    """Return how a boat answers an order; refusals begin with one."""
    reply = obey_order(boat, read_order(text))
    return f"refused: {reply.reason}" if isinstance(reply, Refused) else reply


def scope_of(boat: Boat) -> Periscope:
    scope = periscope_of(boat)
    assert scope is not None
    return scope


def shown(boat: Boat, channel: str) -> dict[str, str]:
    """Return the fields of a channel that have a value."""
    frame = frame_of(boat)
    return {
        field.name: field.text(frame) for field in CHANNELS[channel].fields if field.text(frame)
    }


def ship(north: float, east: float, course: float = 0.0, kind: str = "tanker") -> Any:
    """Return a ship without lights."""
    found = SHIP_TYPES[kind]
    sizes = {"length": found.length, "beam": found.beam, "mast": found.mast}
    place = {"north": north, "east": east, "course": course, "heading": course}
    return SimpleNamespace(name="big", type=kind, lights=(), **place, **sizes)


def test_the_horizon_is_bowditch_s() -> None:
    assert horizon_distance(1.9) == pytest.approx(5408.0, abs=0.5)
    assert -elevation(0.0, horizon_distance(1.9), 1.9) / ARC_MINUTE == pytest.approx(
        2.42, abs=0.005
    )
    assert hidden_height(10_000.0, 1.9) == pytest.approx(1.37, abs=0.005)
    assert hidden_height(5000.0, 1.9) == 0.0


def test_a_ship_is_seen_by_its_angles_and_hidden_by_the_horizon() -> None:
    eye = Eye(0.0, 0.0, 1.9, math.radians(30.0))
    sight = look_at(ship(0.0, 3000.0, course=math.radians(180.0)), eye)
    assert sight is not None
    assert math.degrees(sight.train) == pytest.approx(60.0)
    assert math.degrees(sight.aspect) == pytest.approx(90.0)  # goes south: her starboard side
    assert sight.top == pytest.approx((40.0 - 1.9) / 3000.0 - 3000.0 / (2 * 7695e3), abs=1e-7)
    assert sight.bottom == pytest.approx(elevation(0.0, 3000.0, 1.9))
    far = look_at(ship(20_000.0, 0.0), eye)
    assert far is not None
    assert far.bottom == pytest.approx(elevation(0.0, horizon_distance(1.9), 1.9), rel=1e-3)
    assert look_at(ship(40_000.0, 0.0), eye) is None
    assert look_at(ship(3000.0, 0.0), eye._replace(height=-0.1)) is None


@pytest.mark.parametrize(
    ("course", "colours"),
    [(150, "green white white"), (210, "red white white"), (0, "white"), (60, "white")],
)
def test_lights_show_in_their_sectors(course: int, colours: str, tmp_path: Path) -> None:
    under_way = TANKER.replace("= 90", f'= {course}\nstatus = "under way"').replace("1000]", "0]")
    contacts = contacts_in(at_sea(tmp_path, under_way))
    assert contacts is not None
    (big,) = contacts.seen(0)
    near = look_at(big, Eye(0.0, 0.0, 1.9, 0.0))
    assert near is not None
    assert " ".join(sorted(each.colour for each in near.lamps)) == colours
    far = look_at(big, Eye(-13_000.0, 0.0, 12.0, 0.0))
    assert far is not None
    assert far.lamps == ()  # beyond six miles


def test_the_stadimeter_measures_in_steps() -> None:
    sight = look_at(ship(3000.0, 0.0), Eye(0.0, 0.0, 1.9, 0.0))
    assert isinstance(sight, Sight)
    exact = 40.0 / (sight.top - sight.bottom)
    assert stadimeter_range(40.0, sight, HIGH_POWER) == pytest.approx(exact, rel=0.25 / 45.0)
    apart = sight._replace(top=sight.bottom + 3.2 * ARC_MINUTE)
    assert stadimeter_range(40.0, apart, LOW_POWER) == pytest.approx(40.0 / (4.0 * ARC_MINUTE))
    assert stadimeter_range(40.0, apart, HIGH_POWER) == pytest.approx(40.0 / (3.0 * ARC_MINUTE))
    small = look_at(ship(12_000.0, 0.0, kind="fishing"), Eye(0.0, 0.0, 1.9, 0.0))
    assert small is not None
    assert (
        stadimeter_range(12.0, small._replace(top=small.bottom + 0.9 * ARC_MINUTE), LOW_POWER)
        is None
    )


def test_the_mast_comes_out_in_its_time_and_turns_back_on_its_way(tmp_path: Path) -> None:
    boat = at_sea(tmp_path)
    scope = scope_of(boat)
    assert give(boat, "scope raise") == "raising scope: up in 8 s"
    take_ticks(boat, 6)
    assert scope.at(boat.ticks).out == pytest.approx(3.0)
    assert give(boat, "scope lower") == "lowering scope: down in 3 s"
    take_ticks(boat, 4)
    assert scope.at(boat.ticks).out == pytest.approx(1.0)
    give(boat, "scope raise")
    take_ticks(boat, UP)
    assert scope.at(boat.ticks).out == 8.0
    assert scope.at(boat.ticks).raised == 2
    boat.state.z, boat.state.theta, boat.state.phi = 17.5, 0.0, 0.0
    assert eye_height(boat) == pytest.approx(1.9, abs=0.05)


def test_train_and_power_are_as_ordered(tmp_path: Path) -> None:
    boat = at_sea(tmp_path)
    give(boat, "scope train 045")
    give(boat, "scope power 6")
    assert scope_of(boat).at(boat.ticks)[3:5] == (math.radians(45.0), 6.0)
    boat.state.psi = math.radians(350.0)
    assert shown(boat, "scope")["bearing"] == "35.0"


def test_the_mast_follows_from_the_orders_alone(tmp_path: Path) -> None:
    boat = at_sea(tmp_path)
    given = [(0, "scope raise"), (9, "scope train 90"), (12, "scope lower"), (14, "scope power 6")]
    stood = []
    for tick in range(24):
        for at, text in given:
            if at == tick:
                give(boat, text)
        stood.append(scope_of(boat).at(boat.ticks))
        take_ticks(boat, 1)
    again = at_sea(tmp_path, speed=9.0)  # another state, in which an order would be doubted
    again.world.obey_anew([(tick, read_order(text)) for tick, text in given])
    assert [scope_of(again).at(tick) for tick in range(24)] == stood
    again.world.obey_anew([])
    assert scope_of(again).at(24) == Mast(tick=24)


def test_a_boat_without_a_periscope_says_so() -> None:
    boat = make_boat("remus100")
    assert periscope_of(boat) is None
    refused = Periscope(boat, {}).obey(read_order("scope raise"), 0)
    assert isinstance(refused, Refused)
    assert refused.reason == "remus100.toml has no periscope"
    assert math.isnan(eye_height(boat))


def test_the_vessel_file_says_what_the_mast_is(tmp_path: Path) -> None:
    file = at_sea(tmp_path).file
    text = file.text.replace("extension_m = 8.0", "extension_m = 4.0")
    scope = parse_vessel(text, file.path).scope
    assert scope is not None
    assert (scope.x_m, scope.extension_m, scope.raise_s, scope.speed_kn_max) == (6.0, 4.0, 8.0, 8.0)


def test_at_too_high_a_speed_the_mast_shakes_and_measures_nothing(tmp_path: Path) -> None:
    boat = at_sea(tmp_path, TANKER, speed=9.5)
    assert give(boat, "scope raise").endswith("9.5 kn is too fast for it, 8 at most")
    take_ticks(boat, UP)
    boat.state.z = 17.0
    give(boat, "scope train 26")
    assert shown(boat, "scope")["view"] == "shakes"
    assert give(boat, "scope range 40") == "refused: the mast shakes: nothing can be measured"


def test_a_mast_that_shakes_is_called_once_until_it_stood_still_for_long(tmp_path: Path) -> None:
    boat = at_sea(tmp_path, depth=60.0, speed=9.5)
    monitor = LimitMonitor.over(boat, ExerciseLimits())
    give(boat, "scope raise")
    told: dict[float, list[str]] = {}
    for tick in range(1, 200):
        if tick in {40, 60}:
            give(boat, "scope lower")
        if tick in {50, 150}:
            give(boat, "scope raise")
        take_ticks(boat, 1)
        if said := monitor.look(boat):
            told[boat.time] = [call.text for call in said]
    first, again = told
    assert (first, 75.0 <= again < 80.0) == (0.5, True)
    (call,) = told[first]
    assert call.startswith("tick 1 (0.5 s): MAST SHAKES: 9.5 kn is too fast for it, 8 at most")
    assert LimitMonitor.over(boat, ExerciseLimits()).look(boat) == []


def test_a_range_is_told_with_the_gyro_s_bearing(tmp_path: Path) -> None:
    boat = at_sea(tmp_path, TANKER)
    assert give(boat, "scope range 40") == "refused: nothing to measure: no ship in the view"
    give(boat, "scope raise")
    give(boat, "scope power 6")
    take_ticks(boat, UP)
    give(boat, "scope train 27")
    said = give(boat, "scope range 40")
    assert said.startswith("bearing 027: 40 m high, range ")
    distance = math.hypot(2000.0 - boat.state.x, 1000.0 - boat.state.y)
    assert float(said.split()[-2]) == pytest.approx(distance, rel=0.02)


def test_a_page_is_told_angles_alone_and_nothing_below_the_horizon(tmp_path: Path) -> None:
    far = TANKER.replace("big", "far").replace("[2000, 1000]", "[60000, 0]")
    boat = at_sea(tmp_path, TANKER + far)
    assert shown(boat, "scope")["view"] == "down"
    assert "ship_1" not in shown(boat, "scope")
    give(boat, "scope raise")
    take_ticks(boat, UP)
    told = shown(boat, "scope")
    assert told["ship_1"] == "tanker"
    assert "ship_2" not in told
    assert "sighted" not in told  # it is not in the view
    give(boat, "scope train 20")
    assert shown(boat, "scope")["sighted"] == "tanker 027"
    units = {field.unit for field in CHANNELS["scope"].fields if field.name.startswith("ship")}
    assert units == {"", "deg", "min"}
    assert float(shown(boat, "lookout")["nearest"]) == pytest.approx(2200.0, abs=60.0)


def test_the_frame_has_the_height_that_the_core_has(tmp_path: Path) -> None:
    boat = at_sea(tmp_path, "[sea]\nsea_state = 4\n")
    give(boat, "scope raise")
    take_ticks(boat, 40)
    boat.state.theta, boat.state.phi = 0.1, 0.2
    scope = scope_of(boat)
    mast = scope.at(boat.ticks)
    assert frame_of(boat).height(*scope.head(mast)) == pytest.approx(scope.height(mast), abs=1e-12)
    assert float(shown(boat, "lookout")["eye"]) == pytest.approx(eye_height(boat), abs=0.05)


def flown(boat: Boat, ticks: int, orders: dict[int, str], marks: dict[int, str]) -> Trajectory:
    """Return the passage of a boat to which orders are given and who is aboard marks."""
    rows = []
    for tick in range(ticks + 1):
        if tick in orders:
            give(boat, orders[tick])
        rows.append(boat.numbers(tuple(name for name in PASSAGE_COLUMNS if "[" not in name)))
        if tick < ticks:
            take_ticks(boat, 1)
    names = [name for name in PASSAGE_COLUMNS if "[" not in name]
    count = len(rows)
    columns = dict.fromkeys(PASSAGE_COLUMNS, np.zeros(count)) | dict(
        zip(names, np.array(rows).T, strict=True)
    )
    none = np.full(count, np.nan)
    noted = tuple(
        RecordedEvent(1, tick, "mark", "scope", text, "", "scope") for tick, text in marks.items()
    )
    return Trajectory(boat, ExerciseLimits(), (), np.arange(count), columns, none, none, noted)


def attained(passage: Trajectory, measure: str) -> tuple[float | None, str]:
    """Return what a measure makes of a passage, and why it has no value."""
    rule = f'[[scores]]\nname = "It"\nmeasure = "{measure}"\nfull = 0\nzero = 100\n'
    (only,) = parse_exercise(HEAD + rule, Path("drill.toml")).scores
    found = take_measure(passage, only)
    return found.value, found.why


def test_exposure_is_counted_in_all_and_by_the_raise(tmp_path: Path) -> None:
    boat = at_sea(tmp_path)
    orders = {0: "scope raise", 30: "scope lower", 50: "scope raise"}
    passage = flown(boat, 100, orders, {})
    heights = passage.series("eye")
    out = np.array([scope_of(boat).at(tick).out > 0.0 for tick in range(101)])
    wanted = 0.5 * float(np.sum((heights > 0.0) & out))
    assert attained(passage, "exposed") == (wanted, "")
    assert 10.0 < (attained(passage, "exposed-raise")[0] or 0.0) < wanted
    live = scope_of(boat).exposed(100, raised=False)
    assert live == pytest.approx(wanted, abs=0.5)  # the last tick is not written before it is over
    assert scope_of(boat).exposed(100, raised=True) < live


def test_a_mast_counts_the_same_when_ticks_are_flown_at_once(tmp_path: Path) -> None:
    singly, at_once = at_sea(tmp_path), at_sea(tmp_path)
    places, stood = np.array([0], np.int64), []
    for words, ticks in (("raise", 40), ("lower", 60), ("lower", 20), ("raise", 30)):
        for boat in (singly, at_once):
            give(boat, f"scope {words}")
        stood.append(scope_of(at_once).stands(at_once.ticks))
        take_ticks(singly, ticks)
        assert at_once.fly(places, np.empty((ticks, 1))) == 0
        assert at_once.plain.tobytes() == singly.plain.tobytes()
    counts = [scope_of(boat).exposed(150, raised=False) for boat in (singly, at_once)]

    assert stood == [False, False, True, False]
    assert counts[0] == counts[1] > 10.0


def test_a_resumed_run_goes_on_counting(tmp_path: Path) -> None:
    path, file = tmp_path / "look.toml", tmp_path / "r.trainer"
    path.write_text(HEAD + START.format(speed=5.0, depth=18.5) + "[sea]\nsea_state = 4\n")
    (tmp_path / "o.txt").write_text("3 scope raise\n40 scope lower\n60 scope raise\n")
    words = ["run", str(path), "--orders", str(tmp_path / "o.txt"), "--record", str(file)]
    more = ["--headless", "--speed", "max", "--duration", "90"]
    type_command(cli, *(words + more))
    with contextlib.closing(Recording.reopen(file)) as recording:
        rows, raises = shown_ticks(gather_debrief(recording, file, None).trajectory)
        plan = plan_of(recording.header())
        boat = Boat(plan.file, plan.method)
        bring_up(recording, plan, boat)
    scope, before = scope_of(boat), rows[:-1]
    assert (boat.ticks, rows.size) == (180, 181)
    assert 10.0 < scope.exposed(180, raised=False) == 0.5 * before.sum() < 60.0
    assert scope.exposed(180, raised=True) == 0.5 * (before & (raises[:-1] == 2.0)).sum()


def test_a_tick_that_is_flown_again_counts_once(tmp_path: Path) -> None:
    boat = at_sea(tmp_path)
    scope = scope_of(boat)
    flown(boat, 60, {0: "scope raise"}, {})
    wanted = scope.exposed(60, raised=False)
    begin = next(tick for tick in range(61) if scope.exposed(tick, raised=False))
    for tick in (begin + 5, begin + 6, begin):
        scope.write({TICK_OFFSET: tick})
    assert scope.exposed(60, raised=False) == 0.5
    for tick in range(begin + 1, 60):
        scope.write({TICK_OFFSET: tick})
    assert scope.exposed(60, raised=False) == wanted


LOOKS: Final = {0: "scope raise"}


def time_to_detect(
    folder: Path, marks: dict[int, str], orders: dict[int, str] = LOOKS, ticks: int = 60
) -> tuple[float | None, str]:
    """Return what is made of a look at a ship that bears 029, with marks by the lookout."""
    return attained(flown(at_sea(folder, TANKER), ticks, orders, marks), "time-to-detect")


def test_a_ship_counts_as_detected_from_a_mark_on_its_bearing(tmp_path: Path) -> None:
    passage = flown(at_sea(tmp_path, TANKER), 60, LOOKS, {50: "contact 029"})
    seen = int(np.flatnonzero(passage.series("eye") > 0.0)[0])
    assert attained(passage, "time-to-detect") == (0.5 * (50 - seen), "")
    assert time_to_detect(tmp_path, {40: "contact 040"}) == (None, "big was not marked")
    assert attained(flown(at_sea(tmp_path), 20, LOOKS, {}), "time-to-detect")[0] is None


def test_a_mark_of_no_ship_seen_costs_as_much_as_half_a_minute(tmp_path: Path) -> None:
    right = time_to_detect(tmp_path, {50: "contact 029"})[0]
    all_round = {40 + i: f"contact {6 * i + 90:03d}" for i in range(10)}
    assert right is not None
    assert time_to_detect(tmp_path, all_round | {50: "contact 029"})[0] == right + 300.0


def test_who_never_looks_has_detected_nothing(tmp_path: Path) -> None:
    blind = time_to_detect(tmp_path, {50: "contact 029"}, {}, 240)
    assert blind == (None, "nobody looked for big")
    deep = flown(at_sea(tmp_path, TANKER, depth=60.0), 240, {}, {})
    assert attained(deep, "time-to-detect") == (None, "no ship came in sight")


def test_a_remark_of_another_is_no_mark_of_the_lookout_s(tmp_path: Path) -> None:
    passage = flown(at_sea(tmp_path, TANKER), 60, LOOKS, {50: "contact 200"})
    remark = RecordedEvent(1, 45, "mark", "instructor 1", "contact 029", "", "instructor")
    told = replace(passage, marks=(*passage.marks, remark))
    assert attained(told, "time-to-detect") == (None, "big was not marked")
    alone = replace(passage, marks=(remark,))
    assert attained(alone, "time-to-detect")[0] is not None


def report_time(passage: Trajectory, *said: tuple[int, str, str]) -> tuple[float | None, str]:
    """Return what is made of reports, each with its tick and the role that gives it."""
    orders = tuple(
        RecordedOrder(
            i, 1, tick, station(role, "tester"), f"report {words}", None, accepted=True, answer=""
        )
        for i, (tick, role, words) in enumerate(said)
    )
    return attained(replace(passage, orders=orders), "time-to-report")


def test_contacts_are_reported_from_the_first_look_on(tmp_path: Path) -> None:
    passage = flown(at_sea(tmp_path, TANKER), 60, LOOKS, {})
    seen = int(np.flatnonzero(passage.series("eye") > 0.0)[0])
    none = "no close contacts"

    assert report_time(passage, (50, "scope", none)) == (0.5 * (50 - seen), "")
    assert report_time(passage, (50, "diving", none)) == (0.5 * (50 - seen), "")  # who speaks
    assert report_time(passage, (seen - 1, "scope", none)) == (None, "contacts were not reported")
    assert report_time(passage, (50, "scope", "at 60 metres")) == (
        None,
        "contacts were not reported",
    )
    both = (40, "instructor", none), (50, "scope", "Contact bearing 029")
    assert report_time(passage, *both) == (0.5 * (50 - seen), "")
    assert report_time(passage, both[0]) == (0.5 * (40 - seen), "")  # alone aboard
    deep = flown(at_sea(tmp_path, TANKER, depth=60.0), 60, {}, {})
    assert report_time(deep, (50, "scope", none)) == (None, "nobody looked")


def test_a_close_ship_is_to_be_named_and_who_names_one_is_right(tmp_path: Path) -> None:
    near = TANKER.replace("[2000, 1000]", "[330, 250]")
    passage = flown(at_sea(tmp_path, near), 60, LOOKS, {})
    seen = int(np.flatnonzero(passage.series("eye") > 0.0)[0])

    assert report_time(passage, (40, "scope", "no close contacts")) == (None, "a ship was close")
    for words in ("contact 040 close", "one close contact", "contact 040, no others"):
        late = (40, "scope", "no contacts"), (50, "scope", words)
        assert report_time(passage, *late) == (0.5 * (50 - seen), ""), words
