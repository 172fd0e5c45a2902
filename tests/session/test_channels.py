"""What the channels show: the gauges to the stations, the truth to the instructor."""

import math

import pytest
from helpers.boats import start_boat, take_ticks
from helpers.crewed import Crewed
from helpers.orders import obey_all
from helpers.sessions import frame_of, state_reader
from hypothesis import given
from hypothesis import strategies as st

from trainer.boat import casualties
from trainer.boat.boat import STATE_OFFSETS, Boat
from trainer.boat.crew_orders import CREW_AXES
from trainer.core.sea.free_surface import sail_height
from trainer.core.state import STATE
from trainer.io.orders.sentences import parse_sentence
from trainer.session.stations.channels import CHANNELS, TELETYPE_CHANNEL
from trainer.session.stations.display import (
    Display,
    SentenceDisplay,
    TeletypeDisplay,
    WordDisplay,
    panel,
)
from trainer.session.stations.panels import Channel, word
from trainer.session.stations.roles import PANEL_NAMES, ROLES
from trainer.session.stations.status import status_lines
from trainer.session.stations.subscriptions import display
from trainer.session.stations.view import Frame, Pace, Picture, StateReader
from trainer.session.time.ledger import Ledger, Summary

KNOT = 1852.0 / 3600.0
DEGREE = math.pi / 180.0
SEEING_TRUTH = ("instructor", "class")  # the class lets nobody in but by the instructor's word
STATIONS = sorted({c for r in ROLES.values() if r.name not in SEEING_TRUTH for c in r.channels})
OBSERVER = ROLES["observer"]

# What a station may see of the state beside the three gauges. Nothing else of it may show.
SHOWN = (
    *("tick", "phi", "theta", "r", "delta_r", "delta_s", "delta_b", "u_c"),
    *("ordered_depth", "ordered_psi", "ordered_speed", "ordered_u_c"),
    *("ordered", "command", "command_u_c", "by_hand", "speed_by_hand"),
    *("water", "bank", "vent", "blow", "negative_flood", "to_move", "drained"),
    *("compressor", "hover", "held", "trim_by_hand"),
    *("crew_order", "crew_order_tick", "crew_course_side", "crew_depth_unit"),
    # of the plant all but fires, and what has broken
    *("oil_spent", "tank_gain", "hydraulic_pump", "isolated", "mode", "mode_ordered", "mode_ticks"),
    *("bus_dead", "breaker_open", "bus_tie", "overload", "loads_shed", "battery_spent"),
    *("unpowered", "smoke", "ventilation", "fighting", "fight_ticks"),
    *("trim_flood", "trim_forward"),  # whose pumps are loads
)
# Those that decide what the gauges read are held still here: they are what the gauges test is for.
GAUGES = ("casualty", "casualty_amount")


@pytest.fixture
def boat() -> Boat:
    """Return a BB2 at 10 knots, 60 m and course 090, a minute on its way and turning."""
    boat = start_boat(10.0 * KNOT, 60.0, math.pi / 2.0)
    boat.state.ordered_psi = 2.0
    take_ticks(boat, 120)
    return boat


def values(frame: Frame, channel: str) -> dict[str, str]:
    shown = CHANNELS[channel]
    names = [field.name for field in shown.fields]
    return dict(zip(names, shown.values(frame), strict=True))


def everything_stations_get(frame: Frame) -> list[str]:
    """Return the lines of every channel of every role but those that see the truth."""
    displays: list[Display] = [display(TELETYPE_CHANNEL, OBSERVER, machine=False)]
    for channel in STATIONS:
        displays += [display(channel, OBSERVER, machine=machine) for machine in (False, True)]
    lines = [line for each in displays for line in each.lines(frame)]
    return [
        *lines,
        *(
            line
            for role in ROLES.values()
            if role.name not in SEEING_TRUTH
            for line in panel(role.channels, frame)
        ),
    ]


def seen(look: StateReader, boat: Boat) -> list[str]:
    """Return what stations get of a boat from one reader, which flies ahead by one boat."""
    return everything_stations_get(
        look.frame(Picture(boat.ticks, boat.records.state.tobytes(), Pace()))
    )


def stick_gauges(boat: Boat) -> None:
    for gauge in ("depth-gauge", "gyro", "log"):
        assert isinstance(casualties.insert_casualty(boat, f"{gauge}-stuck"), str)
    assert boat.tick() == 0


@pytest.mark.parametrize("fault", ["stuck", "noisy", "biased"])
@pytest.mark.parametrize(
    ("gauge", "field"), [("depth-gauge", "depth"), ("gyro", "heading"), ("log", "speed")]
)
def test_a_casualty_of_a_gauge_shows_in_every_channel_that_has_it(
    boat: Boat, gauge: str, field: str, fault: str
) -> None:
    # changed under the gauge, so that a stuck one differs too
    severity = 1.0 if fault == "stuck" else 10.0
    assert isinstance(casualties.insert_casualty(boat, f"{gauge}-{fault}", severity, 0.0), str)
    assert boat.tick() == 0
    boat.state.z += 7.0
    boat.state.psi += 0.3
    boat.state.u += 1.5
    reading = casualties.instrument_readings(boat)
    expected = {
        "depth": reading.depth,
        "heading": math.degrees(reading.heading) % 360.0,
        "speed": reading.speed / KNOT,
    }[field]

    frame = frame_of(boat)

    others = {"time", "orders", "ghost", "predictor"}  # where the names stand for something else
    showing = [
        c for c in STATIONS if c in CHANNELS and field in values(frame, c) and c not in others
    ]
    assert len(showing) >= 2
    for channel in showing:
        assert float(values(frame, channel)[field]) == pytest.approx(expected, abs=0.051)
    truth = values(frame, "motion")[field]
    assert abs(float(truth) - expected) > 0.2


def test_the_teletype_of_a_station_shows_the_gauges_and_the_instructors_the_truth(
    boat: Boat,
) -> None:
    stick_gauges(boat)
    boat.state.z = 123.4
    frame = frame_of(boat)

    station = display(TELETYPE_CHANNEL, ROLES["helm"], machine=False).lines(frame)[-1]
    instructor = display(TELETYPE_CHANNEL, ROLES["instructor"], machine=False).lines(frame)[-1]

    assert f"{casualties.instrument_readings(boat).depth:.1f}>" in station
    assert "123.4" not in station
    assert "123.4>" in instructor


@pytest.mark.long
def test_no_place_of_the_state_but_those_of_instruments_shows_at_a_station(boat: Boat) -> None:
    stick_gauges(boat)
    look = state_reader(boat)
    before = seen(look, boat)
    whole = boat.records.state["whole"][0]
    untouched = whole.copy()
    spared = {i for name in (*SHOWN, *GAUGES) for i in places(boat, name)}
    hidden = sorted(set(STATE.names or ()) - {"whole"})
    showing = []

    for place in hidden:
        first = STATE_OFFSETS[place]
        for i in range(first, first + boat.records.state[place].size):
            if i not in spared:
                whole[i] += 0.77
        if seen(look, boat) != before:
            showing.append(place)
        whole[:] = untouched

    assert hidden
    assert not showing


def places(boat: Boat, name: str) -> range:
    return range(STATE_OFFSETS[name], STATE_OFFSETS[name] + boat.records.state[name].size)


@pytest.fixture(scope="module")
def stuck() -> tuple[Boat, StateReader, list[str]]:
    """Return a BB2 of which all gauges are stuck, its reader, and what stations get of it."""
    boat = start_boat(10.0 * KNOT, 60.0, 1.0)
    stick_gauges(boat)
    look = state_reader(boat)
    return boat, look, seen(look, boat)


@given(st.floats(-50.0, 50.0), st.floats(-3.0, 3.0), st.floats(-4.0, 4.0), st.floats(-1e3, 1e3))
def test_two_states_with_the_same_readings_give_a_station_the_same_lines(
    stuck: tuple[Boat, StateReader, list[str]],
    deeper: float,
    round_: float,
    faster: float,
    elsewhere: float,
) -> None:
    boat, look, before = stuck
    untouched, s = boat.records.state.copy(), boat.state

    s.z, s.psi, s.u = s.z + deeper, s.psi + round_, s.u + faster
    s.zdot, s.psidot, s.udot = deeper / 10.0, round_ / 10.0, faster / 10.0
    s.x, s.y, s.weight = elsewhere, -elsewhere, s.weight + 100.0 * elsewhere

    after = seen(look, boat)
    boat.records.state[:] = untouched
    assert after == before


def test_a_biased_gauge_hides_the_depth_that_it_makes_up_for(boat: Boat) -> None:
    assert isinstance(casualties.insert_casualty(boat, "depth-gauge-biased", 1.0), str)
    assert boat.tick() == 0
    before = everything_stations_get(frame_of(boat))

    boat.state.z -= 4.0
    boat.state.casualty_amount[0] += 4.0

    assert everything_stations_get(frame_of(boat)) == before


def test_a_frame_is_made_without_touching_the_boat(boat: Boat) -> None:
    state, scratch = boat.records.state.copy(), boat.records.scratch.copy()
    look = state_reader(boat)
    picture = Picture(int(boat.state.tick), boat.records.state.tobytes(), Pace())

    for _ in range(3):
        everything_stations_get(look.frame(picture))

    assert boat.records.state.tobytes() == state.tobytes()
    assert boat.records.scratch.tobytes() == scratch.tobytes()


def test_a_state_of_another_layout_is_told_from_this_cores(boat: Boat) -> None:
    with pytest.raises(ValueError, match="a state of 16 bytes"):
        state_reader(boat).frame(Picture(0, b"\0" * 16, Pace()))


def test_the_panels_show_what_is_ordered_who_steers_and_what_is_done(boat: Boat) -> None:
    s = boat.state
    s.rudder_by_hand, s.ordered_r = 1.0, boat.toward["rudder"] * -0.2
    s.delta_r = boat.toward["rudder"] * -0.1
    s.delta_s = boat.toward["stern"] * 0.15
    s.speed_by_hand, s.ordered_u_c, s.u_c = 1.0, 15.0 * KNOT, 10.0 * KNOT
    turns = boat.file.propulsion.rps_per_mps * 60.0 * KNOT  # [1/min] of a knot
    frame = frame_of(boat)

    steering, engine, diving = (values(frame, name) for name in ("steering", "engine", "diving"))

    assert steering["ordered_course"] == ""
    assert steering["rudder"] == f"{-0.1 / DEGREE:.1f}"  # left
    assert steering["ordered_rudder"] == f"{-0.2 / DEGREE:.1f}"
    assert steering["rudder_mode"] == "hand"
    assert engine["bell"] == "ahead-full"
    assert engine["rpm"] == f"{10.0 * turns:.1f}"
    assert engine["ordered_rpm"] == f"{15.0 * turns:.1f}"
    assert engine["ordered_speed"] == ""
    assert diving["ordered_depth"] == "60.0"
    assert diving["stern"] == f"{0.15 / DEGREE:.1f}"  # rise
    assert diving["stern_mode"] == "auto"


@pytest.mark.parametrize(
    ("ordered", "bell"), [(0.0, "stop"), (-3.0 * KNOT, "astern-one-third"), (1.234, "")]
)
def test_the_bell_shown_is_the_one_whose_turns_are_ordered(
    boat: Boat, ordered: float, bell: str
) -> None:
    boat.state.speed_by_hand, boat.state.ordered_u_c = 1.0, ordered

    assert values(frame_of(boat), "engine")["bell"] == bell


def test_tanks_air_and_valves_show_as_the_ballast_panel_has_them(boat: Boat) -> None:
    s, c = boat.state, boat.vessel
    s.water[4] = 0.25 * c.capacity[4]
    s.water[8] = 12_345.0
    s.bank[0] = 0.5 * c.bank_full[0]
    s.vent_mid, s.blow_aft, s.negative_flood, s.drained, s.hover = 1.0, 2.0, 1.0, 3.0, 1.0
    s.move_trim = -2000.0
    frame = frame_of(boat)

    tanks, air, valves = (values(frame, name) for name in ("tanks", "air", "valves"))

    assert tanks["trim_forward_full"] == "25.0"
    assert tanks["flood_forward"] == "12.3"
    assert tanks["moving_trim"] == "-2.0"
    assert (tanks["trim_mode"], air["compressor"]) == ("auto", "off")
    assert (tanks["draining"], tanks["hover"]) == ("aft", "on")
    assert air["main_full"] == "50.0"
    assert air["main"] == f"{0.5 * c.bank_full[0] * c.gas / c.bank_volume[0] / 1e6:.1f}"
    assert (valves["vent_mid"], valves["vent_aft"]) == ("open", "shut")
    assert (valves["blow_aft"], valves["negative_flood"]) == ("emergency", "open")


def test_a_boat_without_tanks_planes_or_air_shows_nothing_for_them() -> None:
    boat = start_boat(3.0 * KNOT, 10.0, vessel="remus100", step=0.1)
    frame = frame_of(boat)

    assert values(frame, "tanks")["forward"] == ""
    assert values(frame, "tanks")["trim_mode"] == ""
    assert values(frame, "air")["main"] == values(frame, "air")["compressor"] == ""
    assert not any("forward" in line for line in panel(("tanks",), frame))


def test_the_instructor_sees_motion_with_the_rates_that_move_it_on(boat: Boat) -> None:
    s = boat.state
    motion = values(frame_of(boat), "motion")

    assert motion["depth"] == f"{s.z:.2f}"
    assert motion["north"] == f"{s.x:.1f}"
    boat.tick()  # the rates that the next tick begins with are those of the motion told
    assert float(motion["turn_rate"]) == pytest.approx(math.degrees(s.psidot), abs=6e-4)
    assert float(motion["east_rate"]) == pytest.approx(s.ydot, abs=6e-3)
    assert abs(float(motion["turn_rate"])) > 0.01


def test_what_is_held_still_has_no_rate(boat: Boat) -> None:
    boat.state.held_depth = boat.state.held_position = 1.0
    frame = frame_of(boat)

    motion = values(frame, "motion")

    assert [motion[f"{name}_rate"] for name in ("depth", "north", "east")] == [
        "0.000",
        "0.00",
        "0.00",
    ]
    assert values(frame, "time")["held"] == "depth+position"


def test_the_instructor_sees_each_casualty_and_how_far_it_is(boat: Boat) -> None:
    assert isinstance(casualties.insert_casualty(boat, "rudder-slow", 0.5, 10.0), str)
    assert isinstance(casualties.insert_casualty(boat, "depth-gauge-stuck"), str)
    take_ticks(boat, 10)
    shown = values(frame_of(boat), "casualties")

    assert shown["casualty_1"] == "rudder-slow"
    assert float(shown["casualty_1_amount"]) == pytest.approx(0.25)
    assert (shown["casualty_1_target"], shown["casualty_1_left"]) == ("0.50000", "5.0")
    assert shown["casualty_1_says"] == "25 % of the rate lost"
    assert shown["casualty_2"] == "depth-gauge-stuck"
    assert shown["casualty_3"] == shown["casualty_3_left"] == ""


@pytest.mark.parametrize(
    ("name", "severity", "says"),
    [
        ("stern-hard-over", -0.2, "6 deg dive"),
        ("rudder-hard-over", 0.5, "15 deg right"),
        ("bow-hard-over", 1.0, "30 deg rise"),
        ("stern-slow", 0.75, "75 % of the rate lost"),
        ("bow-free", 0.1, "10 % of its rate"),
        ("propulsion-lost", 0.6, "60 % of the turns lost"),
        ("flooding-aft", 1.5, "hole 75 cm2"),
        ("leak-auxiliary", 1.0, "hole 5 cm2"),
        ("depth-gauge-biased", 0.9, "reads 9 m too much"),
        ("gyro-biased", -0.5, "reads 5 deg too little"),
        ("log-noisy", 2.0, "1 kn of noise"),
        ("bank-main-failed", 1.0, "100 % of the air bank lost"),
        ("vent-forward-open", 0.5, "50 % open"),
        ("vent-forward-shut", 0.5, "50 % of the vent lost"),
        ("autopilot-failed", None, ""),
    ],
)
def test_a_casualty_is_told_with_its_unit_and_side(
    boat: Boat, name: str, severity: float | None, says: str
) -> None:
    told = casualties.insert_casualty(boat, name, severity, None if severity is None else 0.0)
    assert told == f"casualty {name}{f', {says}' if says else ''}"
    assert boat.tick() == 0
    assert values(frame_of(boat), "casualties")["casualty_1_says"] == says
    assert any(says in line for line in status_lines(boat, Ledger(0.5).summary()))


def test_a_stuck_surface_and_a_stuck_gauge_are_told_where_they_stand(boat: Boat) -> None:
    for name in ("rudder-stuck", "depth-gauge-stuck"):
        casualties.insert_casualty(boat, name)
    boat.tick()
    shown_depth = casualties.instrument_readings(boat).depth
    shown = values(frame_of(boat), "casualties")
    angle = math.degrees(float(boat.state.delta_r)) * boat.toward["rudder"]
    assert shown["casualty_1_says"] == f"{abs(angle):.1f} deg {'right' if angle > 0 else 'left'}"
    assert shown["casualty_2_says"] == f"at {shown_depth:.1f} m"


def test_water_over_the_sail_is_the_boat_s_own(boat: Boat) -> None:
    for depth, pitch in ((17.5, 0.0), (20.0, 0.1), (5.0, -0.2)):
        boat.state.z, boat.state.theta = depth, pitch
        above = sail_height(boat.records.vessel, boat.records.state)
        assert float(values(frame_of(boat), "sea")["over_sail"]) == pytest.approx(-above, abs=0.051)


def test_the_sea_is_shown_where_it_comes_from(boat: Boat) -> None:
    s = boat.state
    assert values(frame_of(boat), "sea")["from"] == ""
    s.sea_height, s.sea_omega, s.sea_direction = 2.5, math.tau / 8.0, math.pi / 4.0

    shown = values(frame_of(boat), "sea")

    assert (shown["height"], shown["period"], shown["from"]) == ("2.50", "8.0", "225")


@pytest.mark.parametrize(
    ("pace", "expected"),
    [
        (Pace(), ("running", "1.0", "1", "no")),
        (
            Pace(frozen=True, speed=math.inf, branch=3, replaying=True),
            ("frozen", "max", "3", "yes"),
        ),
    ],
)
def test_time_is_shown_as_it_runs(boat: Boat, pace: Pace, expected: tuple[str, ...]) -> None:
    shown = values(frame_of(boat, pace), "time")

    assert tuple(shown[name] for name in ("time", "speed", "branch", "replay")) == expected


def test_the_ledger_is_asked_for_once_and_only_when_shown(boat: Boat) -> None:
    asked = []
    ledger = Ledger(0.5)
    ledger.record(0, 1000, 5000)

    def summary() -> Summary:
        asked.append(1)
        return ledger.summary()

    picture = Picture(0, boat.records.state.tobytes(), Pace())
    frame = StateReader(boat, summary).frame(picture)
    everything_stations_get(frame)
    assert not asked

    shown = values(frame, "ledger")

    assert len(asked) == 1
    assert shown["ticks"] == "1"
    assert shown["work_most"] == "5.0"


def test_a_course_just_short_of_north_is_shown_as_north(boat: Boat) -> None:
    boat.state.psi = math.radians(359.97)

    assert values(frame_of(boat), "gauges")["heading"] == "0.0"


def test_a_program_gets_names_and_units_once_and_then_values_in_their_order(boat: Boat) -> None:
    shown = SentenceDisplay(CHANNELS["steering"])
    frame = frame_of(boat)

    first, second = shown.lines(frame), shown.lines(frame)

    kinds = [sentence.kind for line in (*first, *second) if (sentence := parse_sentence(line))]
    assert kinds == ["TRN", "TRS", "TRS"]
    names, state = parse_sentence(first[0]), parse_sentence(first[1])
    assert names
    assert state
    assert names.fields[0] == state.fields[0] == "steering"
    named = [name.partition(":")[0] for name in names.fields[1:]]
    assert dict(zip(named, state.fields[3:], strict=True)) == values(frame, "steering")
    assert state.fields[1:3] == ("120", "60.000")


def test_a_channel_is_read_once_for_all_programs_that_look_at_a_frame(boat: Boat) -> None:
    read = list[Frame]()
    fields = (word("looks", lambda frame: read.append(frame) or "seen"),)  # type: ignore[func-returns-value]
    channel = Channel("looks", "how often it was read", fields)
    first, later = frame_of(boat), frame_of(boat)

    shown = [SentenceDisplay(channel).lines(frame)[-1] for frame in (first,) * 30 + (later,)]

    assert read == [first, later]
    assert len(set(shown)) == 1


@pytest.mark.parametrize("channel", sorted(CHANNELS))
def test_words_for_a_reader_fit_79_columns_and_keep_value_and_unit_together(
    boat: Boat, channel: str
) -> None:
    frame = frame_of(boat)
    told = [
        f"{field.name} {value.lstrip('-' * bool(field.sides))} {field.unit.strip('-')}".strip()
        for field, value in zip(
            CHANNELS[channel].fields, values(frame, channel).values(), strict=True
        )
        if value and not field.packed
    ]

    lines = WordDisplay(CHANNELS[channel]).lines(frame)

    assert all(any(each in line for line in lines) for each in told)
    assert lines[0].startswith(f"{channel}, 60 s: ")
    assert all(len(line) <= 79 for line in lines)
    assert all(line.isascii() for line in lines)


def test_a_reader_is_told_the_side_of_an_angle_and_not_its_sign(boat: Boat) -> None:
    boat.state.delta_s = boat.toward["stern"] * math.radians(-6.0)
    boat.state.delta_r = boat.toward["rudder"] * math.radians(10.04)
    boat.state.theta = math.radians(-0.04)  # is written as zero

    told = " ".join(panel(("diving", "steering"), frame_of(boat)))

    assert "stern 6.0 deg dive," in told
    assert "rudder 10.0 deg right," in told
    assert "pitch 0.0 deg," in told


def test_the_teletype_has_its_headings_every_twenty_lines(boat: Boat) -> None:
    frame = frame_of(boat)
    shown = TeletypeDisplay(lambda frame: frame.readings)

    lengths = [len(shown.lines(frame)) for _ in range(45)]

    assert [i for i, length in enumerate(lengths) if length == 2] == [0, 20, 40]


def test_a_stations_status_is_its_own_instruments(boat: Boat) -> None:
    lines = panel(ROLES["ballast"].channels, frame_of(boat))

    opened = [line.partition(",")[0] for line in lines if not line.startswith(" ")]
    assert opened == ["gauges", "orders", "tanks", "air", "valves", "plant", "time"]


def ordered(boat: Boat, *lines: str) -> dict[str, str]:
    """Give orders to the crew, fly on for 2 s; return what its panel shows."""
    obey_all(boat, *lines)
    boat.state.tick += 4.0
    return values(frame_of(boat), "orders")


def test_the_orders_to_the_crew_show_what_is_to_go_with_its_sign(boat: Boat) -> None:
    s = boat.state
    s.psi, s.z, s.u, s.theta = math.radians(100.0), 60.0, 10.0 * KNOT, math.radians(-2.0)

    shown = ordered(
        boat, "order course 090", "order depth 200 ft", "order speed 8", "order pitch 5 up"
    )

    assert (shown["course"], shown["course_side"], shown["course_error"]) == ("90.0", "", "-10.0")
    assert (shown["depth"], shown["depth_unit"], shown["depth_error"]) == ("61.0", "ft", "1.0")
    assert (shown["speed"], shown["speed_error"]) == ("8.0", "-2.0")
    assert (shown["pitch"], shown["pitch_error"]) == ("5.0", "7.0")
    assert {shown[f"{axis}_since"] for axis in CREW_AXES} == {"2"}


@pytest.mark.parametrize(
    ("heading", "line", "turned", "to_go"),
    [
        (0.0, "order course 090", 0.0, 90.0),
        (0.0, "order course left 090", 0.0, -270.0),
        (0.0, "order course left 090", -200.0, -70.0),
        (0.0, "order course right 180", 195.0, -15.0),  # beyond it: back to the left
        (0.0, "order course left 090", 90.0, 0.0),  # there, but the other way round
        (350.0, "order course 360", 0.0, 10.0),
        (350.0, "order course right 340", 0.0, 350.0),
        (45.0, "order course steady", 3.0, -3.0),
    ],
)
def test_what_is_to_go_of_a_course_has_the_side_ordered(
    boat: Boat, heading: float, line: str, turned: float, to_go: float
) -> None:
    boat.state.psi = math.radians(heading + 720.0)
    assert ordered(boat, line)["course"]

    boat.state.psi += math.radians(turned)

    assert float(values(frame_of(boat), "orders")["course_error"]) == pytest.approx(to_go, abs=0.05)


def test_an_order_to_the_crew_moves_nothing_and_hand_steering_does_not_wipe_it(boat: Boat) -> None:
    shown = ordered(boat, "order course 045", "rudder left 5", "bell stop", "stern planes dive 3")
    assert shown["course"] == "45.0"
    assert boat.state.rudder_by_hand
    assert not shown["depth"] + shown["depth_unit"] + shown["depth_error"] + shown["depth_since"]

    assert not any(ordered(boat, "order clear all").values())


def test_names_of_fields_are_plain_words_and_each_is_there_once() -> None:
    for channel in CHANNELS.values():
        names = [field.name for field in channel.fields]
        assert len(set(names)) == len(names)
        assert all(name.replace("_", "").isalnum() and name.islower() for name in names)


def test_the_panels_cover_what_the_observer_sees() -> None:
    assert set(PANEL_NAMES) <= set(OBSERVER.channels)
    assert set(PANEL_NAMES) <= set(CHANNELS)


def test_status_of_one_channel_is_what_it_shows(ship: Crewed) -> None:
    planes = ship.comes("planes")
    assert ship.say(planes, "status safe")[0] == "ok"
    told = " ".join(planes.sent)
    assert "safe, 0 s: jam 80 m, flooding 61 m, test 250 m" in told
    assert "gauges, 0 s" not in told
    ship.order("status plant")
    assert "main_pressure" in " ".join(ship.instructor.sent)


@pytest.mark.parametrize(
    ("words", "why"),
    [
        ("status plan", "no channel plan; there is teletype, gauges"),
        ("status motion", "motion is not shown here: you have the planes"),
        ("status events", "events are no state: `log` tells the last of them"),
    ],
)
def test_a_status_that_a_station_does_not_see_is_refused(
    ship: Crewed, words: str, why: str
) -> None:
    assert why in ship.refused(words, ship.comes("planes"))
