"""Orders carried out on a boat and in a session, or refused and nothing changed."""

import math
import threading
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from typing import cast

import pytest
from hypothesis import given
from hypothesis import strategies as st

from trainer.boat import Boat
from trainer.clock import MonotonicClock, Pacer, Policy, Unpaced
from trainer.console import Console
from trainer.fitout import KNOT, Method
from trainer.helm import obey
from trainer.io.csv_file import COLUMNS
from trainer.io.lines import Overlong
from trainer.io.orders import LONGEST, Order, parse
from trainer.io.schedule import parse_schedule
from trainer.reply import Refused
from trainer.session import Session, Timekeeping
from trainer.vessel_file import load_vessel

DEGREE = math.pi / 180.0
VESSELS = ("bb2", "sdv-mk9", "remus100")
STARTED: dict[str, Boat] = {}


def under_way(vessel: str = "bb2") -> Boat:
    """Return a boat just started in trim, as its file says, on everything automatic."""
    file = load_vessel(vessel)
    boat = Boat(file, Method("modified", "lagged", "exact", "adams2", file.run.step_s))
    boat.start(file.run.start_speed_kn * KNOT, file.run.start_depth_m, 0.0)
    return boat


def without_autopilot() -> Boat:
    file = replace(load_vessel("bb2"), autopilot=None)
    boat = Boat(file, Method("modified", "lagged", "exact", "adams2", 0.5))
    boat.start(10.0 * KNOT, 60.0, 0.0)
    return boat


def order(line: str) -> Order:
    found = parse(line)
    assert isinstance(found, Order), line
    return found


def told(boat: Boat, *lines: str) -> list[str]:
    """Return what the boat answers to orders, all of which it obeys."""
    answers = [obey(boat, order(line)) for line in lines]
    assert all(isinstance(answer, str) for answer in answers), answers
    return [str(answer) for answer in answers]


def fly(boat: Boat, seconds: float) -> None:
    for _ in range(round(seconds / boat.method.step)):
        assert boat.tick() == 0


# What an order changes


@pytest.mark.parametrize(
    ("line", "reply", "changes"),
    [
        ("depth 80", "keeping depth 80 m", {"ordered_depth": 80.0}),
        ("depth 260 ft", "keeping depth 79.248 m", {"ordered_depth": 79.248}),
        ("depth auto", "keeping depth 60 m", {}),
        ("course 090", "keeping course 090", {"ordered_psi": 90.0 * DEGREE}),
        ("course 270", "keeping course 270", {"ordered_psi": -90.0 * DEGREE}),
        ("course auto", "keeping course 000", {}),
        ("course left 30", "keeping course 330", {"ordered_psi": -30.0 * DEGREE}),
        ("course right 270", "keeping course 270", {"ordered_psi": 270.0 * DEGREE}),
        ("speed 12", "keeping speed 12 kn", {"ordered_speed": 12.0 * KNOT}),
        ("speed 6 m/s", "keeping speed 11.6631 kn", {"ordered_speed": 6.0}),
        ("speed auto", "keeping speed 10 kn", {}),
        ("turns 12", "turns for 12 kn", {"ordered_u_c": 12.0 * KNOT, "speed_by_hand": 1.0}),
        # 80 revolutions a minute, 0.22937 revolutions a second for each m/s
        ("rpm 80", "turns for 11.3 kn", {"ordered_u_c": 80 / 60 / 0.22937, "speed_by_hand": 1.0}),
        ("rpm -30", "for -4.24 kn", {"ordered_u_c": -0.5 / 0.22937, "speed_by_hand": 1.0}),
        ("ahead flank", "turns for 20 kn", {"ordered_u_c": 20.0 * KNOT, "speed_by_hand": 1.0}),
        ("bell astern 2/3", "for -5 kn", {"ordered_u_c": -5.0 * KNOT, "speed_by_hand": 1.0}),
        ("bell stop", "turns for 0 kn", {"ordered_u_c": 0.0, "speed_by_hand": 1.0}),
        # BB2's rudder is positive to port, its stern planes dive, its bow planes rise
        ("rudder left 15", "by hand", {"ordered_r": 15.0 * DEGREE, "rudder_by_hand": 1.0}),
        ("rudder right full", "by hand", {"ordered_r": -30.0 * DEGREE, "rudder_by_hand": 1.0}),
        ("rudder amidships", "by hand", {"ordered_r": 0.0, "rudder_by_hand": 1.0}),
        ("rudder manual", "rudder by hand", {"ordered_r": 0.125, "rudder_by_hand": 1.0}),
        ("rudder auto", "rudder automatic", {}),
        ("stern dive 10", "by hand", {"ordered_s": 10.0 * DEGREE, "stern_by_hand": 1.0}),
        ("stern rise 10", "by hand", {"ordered_s": -10.0 * DEGREE, "stern_by_hand": 1.0}),
        ("stern zero", "by hand", {"ordered_s": 0.0, "stern_by_hand": 1.0}),
        ("stern manual", "stern planes by hand", {"ordered_s": 0.25, "stern_by_hand": 1.0}),
        ("stern auto", "stern planes automatic", {}),
        ("sail planes rise 30", "by hand", {"ordered_b": 30.0 * DEGREE, "bow_by_hand": 1.0}),
        ("bow dive 5", "by hand", {"ordered_b": -5.0 * DEGREE, "bow_by_hand": 1.0}),
        ("bow manual", "bow planes by hand", {"ordered_b": -0.125, "bow_by_hand": 1.0}),
        ("bow auto", "bow planes automatic", {}),
        (
            "planes manual",
            "planes by hand",
            {"ordered_s": 0.25, "ordered_b": -0.125, "stern_by_hand": 1.0, "bow_by_hand": 1.0},
        ),
        ("planes auto", "stern planes and bow planes automatic", {}),
        ("autopilot report", "the report's law", {"depth_law": 1.0}),
        ("autopilot literal", "as it is printed", {"depth_law": 2.0}),
        ("autopilot trainer", "this trainer's own law", {}),
        ("autopilot on", "everything automatic", {}),
        (
            "autopilot off",
            "everything by hand",
            {
                "ordered_r": 0.125,
                "ordered_s": 0.25,
                "ordered_b": -0.125,
                "ordered_u_c": 4.5,
                "rudder_by_hand": 1.0,
                "stern_by_hand": 1.0,
                "bow_by_hand": 1.0,
                "speed_by_hand": 1.0,
            },
        ),
    ],
)
def test_an_order_changes_what_it_says_and_nothing_else(
    line: str, reply: str, changes: dict[str, float]
) -> None:
    boat = under_way()
    s = boat.state
    s.delta_r, s.delta_s, s.delta_b, s.u_c = 0.125, 0.25, -0.125, 4.5
    s.ordered_r, s.ordered_s, s.ordered_b, s.ordered_u_c = 0.5, 0.5, 0.5, 1.0
    expected = boat.snapshot()
    for name, value in changes.items():
        expected[name] = value

    (answer,) = told(boat, line)

    assert reply in answer
    for name, value in changes.items():
        assert s[name] == pytest.approx(value, rel=1e-12)
        expected[name] = s[name]
    assert boat.records.state.tobytes() == expected.tobytes()


@pytest.mark.parametrize(
    ("hand", "automatic", "places"),
    [
        ("rudder left 15", "rudder auto", ["rudder_by_hand"]),
        ("stern rise 5", "stern auto", ["stern_by_hand"]),
        ("bow rise 5", "bow auto", ["bow_by_hand"]),
        ("planes manual", "planes auto", ["stern_by_hand", "bow_by_hand"]),
        ("planes manual", "depth auto", ["stern_by_hand", "bow_by_hand"]),
        ("planes manual", "depth 70", ["stern_by_hand", "bow_by_hand"]),
        ("rudder left 15", "course 010", ["rudder_by_hand"]),
        ("rudder left 15", "course right 10", ["rudder_by_hand"]),
        ("rudder left 15", "course auto", ["rudder_by_hand"]),
        ("bell stop", "speed 8", ["speed_by_hand"]),
        ("turns 4", "speed auto", ["speed_by_hand"]),
        ("autopilot off", "autopilot on", ["rudder_by_hand", "bow_by_hand", "speed_by_hand"]),
    ],
)
def test_what_was_taken_by_hand_is_given_back(hand: str, automatic: str, places: list[str]) -> None:
    boat = under_way()
    told(boat, hand)
    assert [boat.state[place] for place in places] == [1.0] * len(places)
    told(boat, automatic)
    assert [boat.state[place] for place in places] == [0.0] * len(places)


# Refusals


@pytest.mark.parametrize(
    ("make", "line", "reason"),
    [
        (under_way, "rudder left 30.1", "the limit of the rudder is 30 degrees, not 30.1"),
        (under_way, "stern dive 45", "the limit of the stern planes is 30 degrees, not 45"),
        (under_way, "bow rise 31", "the limit of the bow planes is 30 degrees, not 31"),
        (under_way, "speed 20.5", "this boat makes 20 kn, not 20.5"),
        (under_way, "turns 21", "turns are -8 to 20 kn, -57 to 142 rpm"),
        (under_way, "turns -9", "turns are -8 to 20 kn"),
        (under_way, "rpm 143", "-57 to 142 rpm"),
        (lambda: under_way("remus100"), "bow rise 5", "this boat has no bow planes"),
        (lambda: under_way("remus100"), "bow manual", "this boat has no bow planes"),
        (lambda: under_way("remus100"), "bow auto", "this boat has no bow planes"),
        *(
            (without_autopilot, line, "bb2.toml has no [autopilot] table: steer by hand")
            for line in (
                *("depth 80", "depth auto", "course 090", "course left 30", "course auto"),
                *("speed 8", "speed auto", "rudder auto", "stern auto", "planes auto"),
                *("autopilot on", "autopilot off", "autopilot report"),
            )
        ),
    ],
)
def test_an_order_that_cannot_be_obeyed_says_why_and_changes_nothing(
    make: Callable[[], Boat], line: str, reason: str
) -> None:
    boat = make()
    before = boat.records.state.tobytes()

    answer = obey(boat, order(line))

    assert isinstance(answer, Refused)
    assert reason in answer.reason
    assert boat.records.state.tobytes() == before


def test_a_depth_below_the_greatest_of_the_boat_is_refused() -> None:
    boat = under_way()
    boat.file = replace(boat.file, hull=replace(boat.file.hull, max_depth_m=300.0))
    before = boat.records.state.tobytes()

    assert obey(boat, order("depth 301")) == Refused(
        "this boat's greatest depth is 300 m, not 301 m"
    )
    assert boat.records.state.tobytes() == before
    told(boat, "depth 300")


def test_a_bell_the_telegraph_lacks_is_refused_with_those_it_has() -> None:
    boat = under_way()
    bells = {"ahead_one_third": 4.0, "astern_full": -8.0}
    boat.file = replace(boat.file, propulsion=replace(boat.file.propulsion, bells_kn=bells))
    before = boat.records.state.tobytes()

    assert obey(boat, order("ahead flank")) == Refused(
        "this boat's telegraph has ahead one third, astern full and stop"
    )
    assert boat.records.state.tobytes() == before
    told(boat, "astern full", "bell stop")


def test_a_boat_without_autopilot_is_steered_by_hand() -> None:
    boat = without_autopilot()
    told(boat, "rudder right 10", "stern dive 5", "bow rise 5", "turns 12", "planes manual")
    fly(boat, 20.0)
    assert boat.state.psi > 0.1


def test_orders_for_both_planes_pass_over_a_pair_the_boat_lacks() -> None:
    boat = under_way("remus100")
    assert boat.state.bow_by_hand == 1.0  # nothing there to be automatic
    assert told(boat, "planes manual", "planes auto") == [
        "planes by hand",
        "stern planes automatic",
    ]
    assert [boat.state.stern_by_hand, boat.state.bow_by_hand] == [0.0, 1.0]


# Which way


@pytest.mark.parametrize("vessel", VESSELS)
@pytest.mark.parametrize(("side", "sign"), [("right", 1.0), ("left", -1.0)])
def test_right_rudder_turns_right_and_left_rudder_left(vessel: str, side: str, sign: float) -> None:
    boat = under_way(vessel)
    told(boat, f"rudder {side} 10")
    fly(boat, 20.0 if vessel == "bb2" else 3.0)
    assert sign * boat.state.psi > 0.05
    assert sign * boat.state.r > 0.0
    assert sign * boat.state.delta_r * boat.toward["rudder"] == pytest.approx(10.0 * DEGREE)


@pytest.mark.parametrize("vessel", VESSELS)
@pytest.mark.parametrize(("way", "sign"), [("dive", 1.0), ("rise", -1.0)])
def test_stern_planes_to_dive_put_the_bow_down_and_take_the_boat_deeper(
    vessel: str, way: str, sign: float
) -> None:
    boat = under_way(vessel)
    start, level = float(boat.state.z), float(boat.state.theta)
    told(boat, "planes manual", f"stern planes {way} 12")  # REMUS 100 flies level at 8.7, rise
    fly(boat, 40.0 if vessel == "bb2" else 4.0)
    assert sign * (boat.state.theta - level) < -0.02
    assert sign * (boat.state.z - start) > 0.1


@pytest.mark.parametrize("vessel", ["bb2", "sdv-mk9"])
@pytest.mark.parametrize(("way", "sign"), [("dive", 1.0), ("rise", -1.0)])
def test_bow_planes_to_dive_take_the_boat_deeper(vessel: str, way: str, sign: float) -> None:
    boat = under_way(vessel)
    start = float(boat.state.z)
    told(boat, "planes manual", f"bow planes {way} 10")
    fly(boat, 60.0 if vessel == "bb2" else 10.0)
    assert sign * (boat.state.z - start) > 0.1


@pytest.mark.parametrize("vessel", VESSELS)
def test_the_autopilot_goes_where_it_is_told(vessel: str) -> None:
    boat = under_way(vessel)
    depth = float(boat.state.z) + 5.0
    told(boat, f"depth {depth}", "course 020")
    fly(boat, 400.0 if vessel == "bb2" else 120.0)
    assert boat.state.z == pytest.approx(depth, abs=0.5)
    assert boat.state.psi == pytest.approx(20.0 * DEGREE, abs=1.0 * DEGREE)


def test_turns_are_answered_with_more_speed_and_astern_bells_with_less() -> None:
    speeds = []
    for line in ("turns 15", "turns 10", "astern full"):
        boat = under_way()
        told(boat, line)
        fly(boat, 60.0)
        speeds.append(float(boat.state.u))
    assert speeds == sorted(speeds, reverse=True)
    assert speeds[0] > 11.0 * KNOT
    assert speeds[2] < 6.0 * KNOT


@given(st.floats(-60.0, 60.0), st.floats(0.0, 360.0), st.sampled_from(["course", "rudder"]))
def test_a_course_is_steered_the_short_way_however_often_the_boat_has_turned(
    heading: float, course: float, head: str
) -> None:
    boat = STARTED.setdefault("bb2", under_way())
    s = boat.state
    s.psi = heading
    if head == "course":
        told(boat, f"course {course:.6f}")
    else:  # turned by hand since the course was ordered
        s.ordered_psi = course * DEGREE
        told(boat, "rudder auto")

    assert abs(s.ordered_psi - heading) <= math.pi + 1e-9
    turns = (s.ordered_psi - course * DEGREE) / math.tau
    assert turns == pytest.approx(round(turns), abs=1e-7)


def test_a_change_of_course_is_steered_the_way_ordered_from_the_course_kept() -> None:
    boat = under_way()
    boat.state.psi, boat.state.ordered_psi = 20.0, 20.5
    told(boat, "course left 350")
    assert boat.state.ordered_psi == pytest.approx(20.5 - 350.0 * DEGREE)

    told(boat, "rudder right 5", "course right 10")  # by hand there is no course: from the heading
    assert boat.state.ordered_psi == pytest.approx(20.0 + 10.0 * DEGREE)


# A session


@dataclass
class Script:
    """A console that types one batch of lines each time it is asked, and keeps what it is told."""

    batches: list[list[str | Overlong]]
    wake: threading.Event = field(default_factory=threading.Event)
    heard: list[str] = field(default_factory=list)
    shown: list[tuple[int, bool]] = field(default_factory=list)  # tick, frozen

    @property
    def silent(self) -> bool:
        return not self.batches

    def typed(self) -> list[str | Overlong]:
        if len(self.batches) > 1:
            self.wake.set()  # as an inbox does when there is more to take
        return self.batches.pop(0) if self.batches else []

    def say(self, *lines: str) -> None:
        self.heard += lines

    def show(self, boat: Boat, *, frozen: bool) -> None:
        self.shown.append((int(boat.state.tick), frozen))


class Rows:
    """A recorder of ticks."""

    trouble = ""

    def __init__(self) -> None:
        self.kept: list[tuple[float, ...]] = []

    def row(self, values: Sequence[float]) -> None:
        self.kept.append(tuple(values))


def session_of(
    script: Script,
    ticks: float = 10,
    schedule: str = "",
    boat: Boat | None = None,
    recorder: Rows | None = None,
) -> Session:
    """Return a session whose console has something to say at once."""
    time = Timekeeping.at(MonotonicClock(), 0.5, math.inf, Policy.CATCH_UP)
    entries = parse_schedule(schedule, "orders.txt")
    assert isinstance(entries, list)
    script.wake.set()
    consoles = cast("list[Console]", [script])
    recorder = recorder or Rows()
    boat = boat or under_way()
    session = Session(boat, time, recorder, consoles, COLUMNS, entries, last_tick=ticks)
    session.wake = script.wake
    return session


def run(script: Script, ticks: float = 10, schedule: str = "") -> Session:
    session = session_of(script, ticks, schedule)
    session.run()
    return session


def test_a_session_runs_to_its_last_tick_and_records_each_and_the_start() -> None:
    script = Script([])
    session = run(script, 6)
    assert script.shown == [(tick, False) for tick in range(1, 7)]
    assert isinstance(session.recorder, Rows)
    assert [row[:2] for row in session.recorder.kept] == [(k, 0.5 * k) for k in range(7)]


def test_in_a_freeze_single_steps_go_on_and_are_shown_as_frozen() -> None:
    script = Script([["freeze"], ["step 3"], ["step"], ["quit"]])
    session = run(script)
    assert script.shown == [(1, True), (2, True), (3, True), (4, True)]
    assert script.heard == ["frozen", "3 ticks, then frozen", "1 tick, then frozen", "ending"]
    assert session.boat.state.tick == 4


def test_steps_are_taken_before_the_next_line_and_forgotten_by_run() -> None:
    script = Script([["freeze", "step 3", "quit"]])
    assert run(script).boat.state.tick == 3

    script = Script([["freeze"], ["run"]])
    session = session_of(script, 10, "2 step 100\n2 run\n4 freeze\n")
    session.run()
    assert session.boat.state.tick == 8
    assert session.deserted


def test_steps_end_with_the_last_tick() -> None:
    script = Script([["freeze", "step 1000"]])
    session = run(script, 6)
    assert session.boat.state.tick == 6
    assert not session.deserted


def test_run_lets_a_frozen_boat_go_on() -> None:
    script = Script([["freeze"], ["step 2", "run"]])
    session = run(script)
    assert session.boat.state.tick == 10
    assert script.heard == ["frozen", "2 ticks, then frozen", "running"]
    assert not session.deserted


def test_a_frozen_session_nobody_can_run_again_ends_and_says_so() -> None:
    script = Script([["freeze"]])
    session = run(script)
    assert session.boat.state.tick == 0
    assert session.deserted == "frozen at 0 s, and nobody is left to say run"
    assert script.heard[-1] == session.deserted


def test_frozen_and_resumed_gives_the_same_bits() -> None:
    schedule = "1 rudder right 15\n2 depth 70\n"
    straight = run(Script([]), 40, schedule)
    halting = run(Script([["freeze"], ["step 3"], ["step 7"], ["run"]]), 40, schedule)
    assert isinstance(halting.recorder, Rows)
    assert isinstance(straight.recorder, Rows)
    assert halting.recorder.kept == straight.recorder.kept
    assert halting.boat.records.state.tobytes() == straight.boat.records.state.tobytes()


def test_a_last_quit_in_a_freeze_is_no_desertion() -> None:
    class Gone(Script):
        silent = True  # the line is closed, and all it said waits to be read

    script = Gone([["freeze"], ["quit"]])
    session = run(script)
    assert script.heard == ["frozen", "ending"]
    assert not session.deserted


def test_quit_ends_the_session_with_what_was_typed_before_it_done() -> None:
    script = Script([["depth 75", "quit"]])
    session = run(script)
    assert session.boat.state.tick == 0
    assert session.boat.state.ordered_depth == 75.0
    assert script.heard == ["keeping depth 75 m", "ending"]


def test_time_is_paced_or_as_fast_as_it_goes_as_ordered() -> None:
    session = session_of(Script([["time 100"]]), 4)
    assert isinstance(session.time.pacer, Unpaced)
    session.run()
    assert isinstance(session.time.pacer, Pacer)
    assert session.time.ledger.summary().ticks == 4
    session.time.change(math.inf)
    assert isinstance(session.time.pacer, Unpaced)
    assert not session.time.pacer.frozen


def test_a_change_of_time_in_a_freeze_stays_frozen() -> None:
    script = Script([["freeze"], ["time x50"], ["time max"], ["step 2"], ["quit"]])
    assert run(script).boat.state.tick == 2
    assert script.heard[1:3] == ["time 50", "time as fast as it goes"]


def test_garbage_and_an_overlong_line_are_answered_and_change_nothing() -> None:
    script = Script([["depht 80", Overlong(LONGEST), "\x00\xff", "", "# a remark"]])
    session = run(script, 1)
    assert [line[0] for line in script.heard] == ["?"] * 3
    assert "did you mean depth" in script.heard[0]
    assert str(LONGEST) in script.heard[1]
    untouched = run(Script([]), 1)
    assert session.boat.records.state.tobytes() == untouched.boat.records.state.tobytes()


def test_help_and_status_fit_a_screen_of_79_columns() -> None:
    script = Script([["help", "help rudder", "status"]])
    run(script, 1)
    assert any("rudder left 15" in line for line in script.heard)
    assert any(line.startswith("depth") and "60.00 m" in line for line in script.heard)
    assert max(len(line) for line in script.heard) <= 79


def test_a_scheduled_order_acts_on_the_first_tick_not_before_its_time() -> None:
    script = Script([])
    session = session_of(script, 6, "1.2 rudder right 10\n2 rudder left 40\n")
    session.run()
    assert isinstance(session.recorder, Rows)
    rudder = [row[COLUMNS.index("delta_r")] for row in session.recorder.kept]
    # 1.2 s is within the third tick: the order acts at the start of the fourth
    assert rudder[:4] == [rudder[0]] * 4
    assert rudder[4] == pytest.approx(rudder[0] - 3.55 * DEGREE)
    assert script.heard == [
        "[1.2 s] rudder right 10: rudder right 10, by hand",
        "[2 s] rudder left 40: refused: the limit of the rudder is 30 degrees, not 40",
    ]


@pytest.mark.parametrize("order", ["freeze", "quit"])
def test_a_scheduled_end_of_time_is_on_its_tick(order: str) -> None:
    assert run(Script([]), 10, f"2 {order}\n").boat.state.tick == 4


def test_a_boat_whose_numbers_are_lost_freezes_and_will_not_run_again() -> None:
    boat = under_way()
    script = Script([["freeze"], ["step 1"], ["run"], ["step 5"], ["rudder left 5"]])
    session = session_of(script, 10, "", boat)
    boat.state.x = math.inf
    session.run()
    assert "x is out of all bounds after tick 0 (0 s)" in session.failure
    assert f"FROZEN: {session.failure}" in script.heard
    assert script.heard.count(f"? this boat cannot go on: {session.failure}") == 2
    assert boat.state.tick == 0
    assert isinstance(session.recorder, Rows)
    assert len(session.recorder.kept) == 1


def test_trouble_with_the_recording_is_told_at_once_and_only_once() -> None:
    class FullDisk(Rows):
        def row(self, values: Sequence[float]) -> None:
            super().row(values)
            self.trouble = "out.csv: full; 2 rows are whole" if len(self.kept) > 2 else ""

    script = Script([])
    session = session_of(script, 6, recorder=FullDisk())
    session.run()
    assert script.heard == ["NOT RECORDED: out.csv: full; 2 rows are whole"]
    assert session.boat.state.tick == 6


def test_a_console_shows_headings_now_and_then_and_whose_hands_are_on_what() -> None:
    sent: list[str] = []

    class Sender:
        dropped, trouble = 0, ""

        def send(self, line: str) -> None:
            sent.append(line)

        def close(self, patience: float) -> None:
            del patience

    console, boat = Console(None, Sender()), under_way()
    for _ in range(21):
        console.show(boat, frozen=False)
    assert [line.startswith("time ") for line in sent].count(True) == 2
    assert ">60.0" in sent[1]
    told(boat, "planes manual")
    console.show(boat, frozen=True)
    assert ">60.0" not in sent[-1]
    assert sent[-1].startswith("00:00:00F")
    assert sent[-1].count("*") == 2
    assert console.silent
