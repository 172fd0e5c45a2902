"""A session: a boat, a clock, a recording and stations, in the thread that ticks."""

import contextlib
import math
import sqlite3
from collections.abc import Iterator, Sequence
from pathlib import Path

import pytest
from helpers.boats import start_bb2
from helpers.line import ScriptedLine
from helpers.sessions import free_session

from trainer.boat.boat import Boat
from trainer.io.lines import OverlongLine
from trainer.io.orders.schedule import parse_schedule
from trainer.io.recording.recording import Recording
from trainer.io.tables import MOTION_COLUMNS
from trainer.session.attendance import Introduction
from trainer.session.session import Session
from trainer.session.stations.roles import Access
from trainer.session.stations.station import Station
from trainer.session.stations.view import Pace
from trainer.session.time.pacer import FreePacer, Pacer

DEGREE = math.pi / 180.0
GONE = "this boat cannot go on: {}; backtrack or reset"


class Script(ScriptedLine):
    """A line that types one batch each time it is asked, and keeps what it is sent."""

    def __init__(self, batches: list[list[str | OverlongLine]]) -> None:
        super().__init__()
        self.batches = batches
        self.shown: list[tuple[int, bool]] = []  # tick, frozen

    @property
    def ended(self) -> bool:
        return not self.batches

    def take(self, most: int) -> list[str | OverlongLine]:
        assert most > 10
        if len(self.batches) > 1:
            self.wake.set()  # as an inbox does when there is more to take
        return self.batches.pop(0) if self.batches else []

    def offer(self, tick: int, state: bytes, pace: Pace) -> None:
        assert len(state) > 1000
        if tick > max([0, *(shown[0] for shown in self.shown)]):
            self.shown.append((tick, pace.frozen))


class Rows:
    """A recorder of ticks."""

    trouble = ""

    def __init__(self) -> None:
        self.kept: list[tuple[float, ...]] = []

    def row(self, values: Sequence[float]) -> None:
        self.kept.append(tuple(values))


OPENED: list[Recording] = []


@pytest.fixture(autouse=True)
def closed() -> Iterator[None]:
    """Close the recordings that a test has begun."""
    yield
    while OPENED:
        OPENED.pop().close()


def session_of(
    script: Script,
    ticks: float = 10,
    schedule: str = "",
    boat: Boat | None = None,
    recorder: Rows | None = None,
) -> Session:
    """Return a session whose console has something to say at once."""
    entries = parse_schedule(schedule, "orders.txt")
    assert isinstance(entries, list)
    script.wake.set()
    boat = boat or start_bb2("modified")
    recording = Recording.create(None, {}, boat.records.state.tobytes())
    OPENED.append(recording)
    rows = recorder or Rows(), MOTION_COLUMNS
    session = free_session(
        *(boat, recording, script), rows=rows, schedule=entries, wake=script.wake
    )
    session.event_log.stations.append(
        Station(script, Access("instructor"), script, session.event_log.log)
    )
    session.last_tick = ticks
    return session


def run(script: Script, ticks: float = 10, schedule: str = "") -> Session:
    session = session_of(script, ticks, schedule)
    session.run()
    return session


def test_in_a_freeze_single_steps_go_on_and_are_shown_as_frozen() -> None:
    script = Script([["freeze"], ["step 2"], ["step"], ["quit"]])
    session = run(script)
    assert script.shown == [(1, True), (2, True), (3, True)]
    assert script.heard == ["frozen", "2 ticks, then frozen", "1 tick, then frozen", "ending"]
    assert session.boat.state.tick == 3


def test_steps_are_taken_before_the_next_line_and_forgotten_by_run() -> None:
    script = Script([["freeze", "step 3", "quit"]])
    assert run(script).boat.state.tick == 3

    script = Script([["freeze"], ["run"]])
    session = session_of(script, 10, "2 step 100\n2 run\n4 freeze\n")
    session.run()
    assert session.boat.state.tick == 8
    assert session.control.deserted


def test_a_frozen_session_nobody_can_run_again_ends_and_says_so() -> None:
    script = Script([["freeze"]])
    session = run(script)
    assert session.boat.state.tick == 0
    assert session.control.deserted == "frozen at 0 s, and nobody is left to say run"
    assert script.heard[-1] == session.control.deserted


def test_time_is_paced_or_as_fast_as_it_goes_as_ordered() -> None:
    session = session_of(Script([["time 100"]]), 4)
    assert isinstance(session.time.pacer, FreePacer)
    session.run()
    assert isinstance(session.time.pacer, Pacer)
    assert session.time.ledger.summary().ticks == 4
    session.time.change(math.inf)
    assert isinstance(session.time.pacer, FreePacer)
    assert not session.time.pacer.frozen


def test_a_change_of_time_in_a_freeze_stays_frozen() -> None:
    script = Script([["freeze"], ["time x50"], ["time max"]])
    assert run(script).boat.state.tick == 0
    assert script.heard[1:3] == ["time x50", "time runs as fast as it can"]


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
    assert isinstance(session.rows.recorder, Rows)
    rudder = [row[MOTION_COLUMNS.index("delta_r")] for row in session.rows.recorder.kept]
    # 1.2 s is within the third tick: the order acts at the start of the fourth
    assert rudder[:4] == pytest.approx([rudder[0]] * 4, abs=1e-12)
    assert rudder[4] == pytest.approx(rudder[0] - 3.55 * DEGREE)
    assert script.heard == [
        "1.2 s: rudder right 10, by hand",
        "2 s: rudder left 40: refused: the limit of the rudder is 30 degrees, not 40",
    ]


def test_a_boat_whose_numbers_are_lost_freezes_and_will_not_run_again() -> None:
    boat = start_bb2("modified")
    script = Script([["freeze"], ["step 1"], ["run"], ["step 5"], ["rudder left 5"]])
    session = session_of(script, 10, "", boat)
    boat.state.x = math.inf
    session.run()
    assert "x is out of all bounds after tick 0 (0 s)" in session.control.failure
    assert f"FROZEN: {session.control.failure}" in script.heard
    assert script.heard.count(f"? {GONE.format(session.control.failure)}") == 2
    assert boat.state.tick == 0
    assert isinstance(session.rows.recorder, Rows)
    assert len(session.rows.recorder.kept) == 1


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


def test_trouble_that_an_order_meets_is_told_too() -> None:
    script = Script([["rudder left 5", "rudder left 6"]])
    session = session_of(script, 4)
    recording = session.history.recording
    assert isinstance(recording, Recording)
    recording.order = lambda *_: setattr(recording, "trouble", "disk full") or 1  # type: ignore[method-assign,func-returns-value]
    session.run()
    assert script.heard.count("NOT RECORDED: disk full") == 1


class OutOfReach:
    """A session whose recording is locked by another program."""

    def __init__(self, tmp_path: Path, batches: list[list[str]]) -> None:
        self.script = Script(batches)  # type: ignore[arg-type]
        self.session = session_of(self.script, 4)
        path = tmp_path / "run.trainer"
        state = self.session.boat.records.state.tobytes()
        self.session.history.recording = Recording.create(path, {}, state)
        OPENED.append(self.session.history.recording)
        self.other = sqlite3.connect(path, isolation_level=None)
        self.other.execute("BEGIN EXCLUSIVE")

    def run(self) -> list[str]:
        with contextlib.closing(self.other):
            self.session.run()
        return self.script.heard


def test_while_the_recording_is_out_of_reach_every_answer_says_so(tmp_path: Path) -> None:
    heard = OutOfReach(tmp_path, [["depth 75", "mark here", "snapshot a", "dpeth 80"]]).run()
    assert heard[0] == "keeping depth 75 m (not recorded)"
    assert heard[1].startswith("NOT RECORDED: ")
    assert heard[2] == "marked at 0 s (not recorded)"
    assert heard[3].startswith("? not kept: ")
    assert "not recorded" not in heard[4]  # it is no order


def test_a_mark_is_in_the_file_before_it_is_answered(tmp_path: Path) -> None:
    class Looking(Script):
        marks: list[str] = []  # noqa: RUF012

        def send(self, line: str) -> None:
            super().send(line)
            if line.startswith("marked"):
                with contextlib.closing(Recording.look(path)) as reader:
                    self.marks += [each.text for each in reader.events() if each.kind == "mark"]

    path = tmp_path / "run.trainer"
    script = Looking([["freeze", "mark here", "mark there"]])
    session = session_of(script, 1)
    state = session.boat.records.state.tobytes()
    session.history.recording = Recording.create(path, {}, state)
    OPENED.append(session.history.recording)
    session.run()
    assert script.marks == ["here", "here", "there"]


class Coming:
    """A reception with one newcomer."""

    awaited = False

    def __init__(self, *stations: Station) -> None:
        self.stations = list(stations)

    def newcomers(self) -> list[Station]:
        come, self.stations = self.stations, []
        return come


def test_nothing_of_the_exercise_is_told_before_the_token_nor_what_breaks_to_the_crew() -> None:
    stranger = Script([["briefing", "status", "role helm WORD", "briefing"], ["detach"]])
    alone = Script([["quit"]])
    session = session_of(alone)
    told = "Stern planes jam", "At 30 s the stern planes stick.", "BB2"
    session.attendance.introduction = Introduction(told, ("BB2",))
    access = Access(tokens={"": "WORD"})
    station = Station(stranger, access, stranger, session.event_log.log)
    session.attendance.reception = Coming(station)
    session.attendance.listen()
    heard = "\n".join(stranger.heard)
    before, _, after = heard.partition("you have the helm")
    assert "BB2" not in before
    assert "say who you are first: role NAME TOKEN" in before
    assert "BB2" in after
    assert "stern planes" not in heard.casefold()
