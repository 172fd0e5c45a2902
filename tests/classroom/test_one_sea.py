"""The boats of a class in one sea: each session is told of the others, and journals it."""

import math
import threading
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from types import SimpleNamespace
from typing import Any

import pytest
from helpers.classes import Class, class_at_sea, kill, listens
from helpers.crewed import Begin, Crewed
from helpers.line import Line
from helpers.nursery import run_trainer
from helpers.places import environment
from helpers.waiting import await_that
from soak.session_process import Caller

from trainer.boat.world.contacts import ContactState, contacts_in
from trainer.classroom.one_sea import LOST_AFTER_S, PARTED_M, OneSea, Place, boat_order
from trainer.config.exercise.class_file import DEPTH_ERROR_M, PLACE_ERROR_M
from trainer.io.orders.grammar import MAX_LINE_LETTERS, parse
from trainer.io.orders.sentences import order_sentence
from trainer.io.serial_line import LinkError
from trainer.session.jump import jump_to
from trainer.session.past.header import open_recording
from trainer.session.stations.roles import Access
from trainer.session.stations.station import Station
from trainer.units import KNOT

STEP = 0.5  # [s] of a tick


@dataclass
class ClassLine:
    """The class's line to a session of the test, which hears it at once."""

    ship: Crewed
    words: dict[str, str]
    line: Line = field(default_factory=lambda: Line("class"))
    trouble: str = ""
    taken: int = 0

    def __post_init__(self) -> None:
        log = self.ship.session.event_log
        log.stations.append(
            Station(self.line, Access(tokens=self.words), self.ship.sending, log.log)
        )

    @property
    def ended(self) -> bool:
        return self.line.ended

    def send(self, text: str) -> None:
        self.line.waiting.append(text)
        self.ship.session.attendance.listen()

    def take(self, _most: int) -> Sequence[str]:
        told, self.taken = self.line.sent[self.taken :], len(self.line.sent)
        return told

    def close(self, _patience: float) -> None:
        self.line.ended = True


class Sea:
    """A class in one sea, whose sessions are the test's, and the test's own time."""

    def __init__(
        self, crewed: Begin, patch: pytest.MonkeyPatch, boats: int, spacing: float
    ) -> None:
        self.now = 0.0
        self.ships = [crewed(seconds=None, clock=self.clock) for _ in range(boats)]
        self.lines: dict[int, ClassLine] = {}
        self.lost: set[int] = set()
        self.words: dict[str, str] = {}
        self.told: list[str] = []
        patch.setattr("trainer.io.client.dial", self.dial)
        for ship in self.ships:
            ship.order("time x1")
        rows: dict[int, Any] = {
            i: SimpleNamespace(address=i, title=f"boat {i}") for i in range(1, boats + 1)
        }
        self.sea = OneSea(rows, spacing, "chief", self.told.append, self.clock)
        self.settle()
        for ship in self.ships:
            ship.order("run")

    def clock(self) -> float:
        return self.now

    def dial(self, number: int, *_: object) -> ClassLine:
        if number in self.lost:
            raise LinkError("away")
        self.lines[number] = ClassLine(self.ships[number - 1], self.words)
        return self.lines[number]

    def lose(self, number: int) -> None:
        """End the class's line to a session, which it cannot reach from now on."""
        self.lost.add(number)
        self.lines[number].line.ended = True

    def settle(self) -> None:
        """Look until the class has a line to each session that can be reached."""
        self.now += 10.0
        await_that(self.all_heard)
        self.sea.look()

    def all_heard(self) -> bool:
        """Look, and return whether each line there may be is heard."""
        self.sea.look()
        open_lines = [line for line in self.lines.values() if not line.ended and line.taken]
        return len(open_lines) == len(self.ships) - len(self.lost)

    def pass_time(self, seconds: float, *flying: int, ticks: int = 1) -> None:
        """Let the time of these boats go on, others stand still."""
        for _ in range(round(seconds / STEP)):
            self.now += STEP
            for number in flying or range(1, len(self.ships) + 1):
                for _ in range(ticks if not self.ship(number).session.time.frozen else 0):
                    self.ship(number).session.tick()
            self.sea.look()

    def ship(self, number: int) -> Crewed:
        return self.ships[number - 1]

    def seen(self, by: int, number: int = 0) -> ContactState | None:
        """Return how a boat has another one, by its number; None where it has not."""
        contacts = contacts_in(self.ship(by).boat)
        assert contacts is not None
        name = f"boat-{number or 3 - by}"
        found = contacts.seen(self.ship(by).boat.ticks)
        return next((each for each in found if each.name == name), None)

    def orders(self, number: int) -> list[str]:
        """Return what a boat was told of the others, as its journal has it."""
        recording = self.ship(number).recording
        told = (each for each in recording.orders(recording.branch))
        return [each.text for each in told if each.giver.role == "class"]


@pytest.fixture
def sea(crewed: Begin, monkeypatch: pytest.MonkeyPatch) -> Callable[..., Sea]:
    return lambda boats=2, spacing=1000.0: Sea(crewed, monkeypatch, boats, spacing)


def error(sea: Sea, by: int, spacing: float) -> tuple[float, float]:
    """Return how far off [m] a boat has the other, over the ground and in depth."""
    seen, there = sea.seen(by), sea.ship(3 - by).boat.state
    assert seen is not None
    east = float(there.y) + (3 - by - by) * spacing
    keel = float(there.z) + 5.0  # of bb2, about
    return math.hypot(seen.north - there.x, seen.east - east), abs(seen.draught - keel)


def test_each_has_the_other_where_it_is_by_few_orders(sea: Callable[..., Sea]) -> None:
    two = sea()
    turns = ("course left 60", "depth 90", "course right 170", "speed 5", "depth 40")
    off, deep = [], []
    for turn in turns:
        two.ship(1).order(turn)
        for _ in range(60):
            two.pass_time(STEP)
            for by in (1, 2):
                place, depth = error(two, by, 1000.0)
                off.append(place)
                deep.append(depth)
    way = 8.0 * KNOT * STEP  # gone between two looks
    assert max(off) < PLACE_ERROR_M + way
    assert max(deep) < DEPTH_ERROR_M + 1.0
    assert len(two.orders(1)) <= 3  # the other goes straight on
    assert 10 < len(two.orders(2)) < 80
    told = two.ship(1).events(two.ship(1).instructor, "order")
    assert [each for each in told if "boat" in each] == []  # nobody else hears of it


def test_a_boat_that_stands_still_stays_where_it_is_and_is_told_again_when_it_goes_on(
    sea: Callable[..., Sea],
) -> None:
    two = sea()
    two.pass_time(20.0)
    two.ship(1).order("freeze")
    told = len(two.orders(1))
    two.pass_time(60.0, 2)
    seen = two.seen(2)
    assert seen is not None
    assert seen.speed == 0.0
    assert max(error(two, 2, 1000.0)) < PLACE_ERROR_M
    assert len(two.orders(1)) == told
    assert error(two, 1, 1000.0)[0] > 200.0
    two.ship(1).order("run")
    two.pass_time(1.0)
    assert error(two, 1, 1000.0)[0] < 2.0 * PLACE_ERROR_M


@pytest.mark.parametrize("faster", ["time x4", "time max"])
def test_a_boat_whose_time_runs_faster_is_taken_away_until_it_is_alike(
    sea: Callable[..., Sea], faster: str
) -> None:
    two = sea()
    two.pass_time(5.0)
    two.ship(1).order(faster)
    two.pass_time(5.0, 1, ticks=4)
    two.pass_time(1.0)
    assert two.seen(1) is None
    assert two.seen(2) is None
    two.ship(1).order("time x1")
    two.pass_time(2.0)
    assert max(error(two, 1, 1000.0)) < PLACE_ERROR_M
    assert max(error(two, 2, 1000.0)) < PLACE_ERROR_M


def test_boats_come_near_while_their_times_run_otherwise_and_are_shown_once_they_have_parted(
    sea: Callable[..., Sea],
) -> None:
    two = sea(spacing=400.0)
    one, other = two.ship(1), two.ship(2)

    def apart() -> float:
        east = float(other.boat.state.y) + 400.0 - float(one.boat.state.y)
        return math.hypot(float(other.boat.state.x) - float(one.boat.state.x), east)

    one.order("course 090")
    other.order("course 270")
    two.pass_time(5.0)
    assert two.seen(1) is not None
    one.order("time x4")
    while apart() > PARTED_M - 50.0:
        two.pass_time(STEP)
    one.order("time x1")
    while apart() < PARTED_M - 10.0:
        two.pass_time(STEP)
        assert two.seen(1) is two.seen(2) is None
    two.pass_time(10.0)
    assert max(error(two, 1, 400.0)) < PLACE_ERROR_M
    assert max(error(two, 2, 400.0)) < PLACE_ERROR_M


def test_a_jump_back_puts_nobody_into_anothers_hull(sea: Callable[..., Sea]) -> None:
    two = sea()
    two.pass_time(20.0)
    back, other = two.ship(1), two.ship(2)
    back.order("snapshot here")
    here = float(back.boat.state.x), float(back.boat.state.y) - 1000.0
    back.order("course 090")
    two.pass_time(200.0)
    other.boat.state.x, other.boat.state.y = here  # where the first was
    jump_to(other.session, other.session.history.now(), "there")
    other.order("run")
    two.pass_time(1.0)
    assert max(error(two, 1, 1000.0)) < PLACE_ERROR_M
    branch = other.recording.branch
    back.order("restore here")
    back.order("run")
    two.pass_time(2.0)
    assert two.seen(1) is two.seen(2) is None
    back.order("course 090")
    two.pass_time(150.0)
    for by, ship in ((1, back), (2, other)):
        assert max(error(two, by, 1000.0)) < PLACE_ERROR_M
        assert not [each for each in ship.events(ship.instructor, "watch") if "COLL" in each]
    assert other.recording.branch == branch
    assert two.orders(1).count("contact boats gone") == 1


def test_boats_told_before_the_first_tick_are_gone_once_a_line_was_lost_there(
    sea: Callable[..., Sea],
) -> None:
    two = sea()
    assert two.seen(1) is not None
    two.lose(1)
    two.ship(2).order("time x2")
    two.settle()
    two.lost.clear()
    two.settle()
    assert two.ship(1).boat.ticks == 0
    assert two.seen(1) is None


def test_boats_that_begin_at_one_place_are_shown_once_they_have_parted(
    sea: Callable[..., Sea],
) -> None:
    two = sea(spacing=0.0)
    two.ship(1).order("course 090")
    two.pass_time(60.0)
    assert two.seen(1) is two.seen(2) is None
    assert "collision" not in str(two.ship(1).instructor.sent)
    two.pass_time(180.0)
    apart = two.ship(1).boat.state
    there = two.ship(2).boat.state
    assert math.hypot(apart.x - there.x, apart.y - there.y) > PARTED_M
    assert max(error(two, 1, 0.0)) < PLACE_ERROR_M


def test_a_boat_that_is_lost_goes_on_for_a_while_then_is_taken_away(
    sea: Callable[..., Sea],
) -> None:
    two = sea()
    two.pass_time(10.0)
    two.lose(1)
    two.pass_time(0.5 * LOST_AFTER_S, 2)
    seen = two.seen(2)
    assert seen is not None
    assert seen.speed > 4.0
    two.pass_time(0.6 * LOST_AFTER_S, 2)
    assert two.seen(2) is None
    two.lost.clear()
    two.settle()
    two.pass_time(1.0)
    assert max(error(two, 2, 1000.0)) < PLACE_ERROR_M


def test_a_boat_whose_new_lines_end_before_they_say_anything_is_taken_away(
    sea: Callable[..., Sea], monkeypatch: pytest.MonkeyPatch
) -> None:
    two = sea()
    two.pass_time(10.0)
    dialled = threading.Semaphore(0)
    silent = SimpleNamespace(
        ended=True, trouble="", send=str, take=lambda _: (), close=lambda _: None
    )

    def dial(*_: object) -> SimpleNamespace:
        dialled.release()
        return silent

    monkeypatch.setattr("trainer.io.client.dial", dial)
    two.lines[1].line.ended = True
    for _ in range(11):
        two.pass_time(0.1 * LOST_AFTER_S, 2)
        assert dialled.acquire(timeout=5.0)
    assert two.seen(2) is None


def test_a_collision_is_told_at_both(sea: Callable[..., Sea]) -> None:
    two = sea(spacing=700.0)
    for number, heading in ((1, 0.5 * math.pi), (2, -0.5 * math.pi)):
        ship = two.ship(number)
        ship.boat.start(8.0 * KNOT, 60.0, heading)
        jump_to(ship.session, ship.session.history.now(), "towards the other")
        ship.order("run")
    two.pass_time(100.0)
    for number in (1, 2):
        ship = two.ship(number)
        told = " ".join(ship.events(ship.instructor, "watch"))
        assert f"COLLISION with boat-{3 - number}, a submarine" in told
        assert ship.session.time.frozen


def test_an_order_of_the_longest_words_fits_a_line_and_the_journal() -> None:
    far = Place(-99_999.0, -99_999.0, 1999.9, -20.0, -21.0, 0.0)
    words = boat_order(24, far)
    assert len(order_sentence(words)) <= MAX_LINE_LETTERS
    assert parse(parse(words).text) == parse(words)  # type: ignore[union-attr]
    still = boat_order(2, Place(1.0, 2.0, -0.5, 0.01, 0.0, -90.0))
    assert still == "contact boat 2 at 1 2 d 0.0 c 270.0 s 0.00"


def test_a_boat_that_replays_lies_where_it_is_and_is_told_when_it_goes_on(
    sea: Callable[..., Sea],
) -> None:
    two = sea()
    two.ship(2).order("snapshot start")
    two.pass_time(20.0)
    here = float(two.ship(1).boat.state.x)
    two.ship(1).order("replay 10 s")
    two.ship(1).order("run")
    two.ship(2).order("restore start")
    two.ship(2).order("run")
    two.pass_time(8.0)
    assert float(two.ship(1).boat.state.x) < here - 5.0  # it is in its past
    seen = two.seen(2)
    assert seen is not None
    assert (seen.speed, abs(seen.north - here) < PLACE_ERROR_M) == (0.0, True)
    two.pass_time(60.0)
    two.ship(1).order("run")
    two.pass_time(2.0)
    assert max(error(two, 1, 1000.0)) < PLACE_ERROR_M
    assert max(error(two, 2, 1000.0)) < PLACE_ERROR_M
    assert "contact boats gone" not in two.orders(1)  # no jump


def test_a_boat_that_is_lost_while_another_replays_is_taken_away_when_that_goes_on(
    sea: Callable[..., Sea],
) -> None:
    two = sea()
    two.pass_time(80.0)
    two.ship(1).order("replay 75 s")
    two.ship(1).order("run")
    two.lose(2)
    two.pass_time(LOST_AFTER_S + 5.0, 1)
    assert two.seen(1) is not None  # its past has it
    two.pass_time(20.0, 1)
    two.ship(1).order("run")
    two.pass_time(1.0, 1)
    assert two.seen(1) is None


def test_a_boat_whose_new_line_was_lost_in_a_replay_is_not_shown_where_it_was_before(
    sea: Callable[..., Sea],
) -> None:
    two = sea()
    two.pass_time(10.0)
    two.lose(1)
    two.pass_time(40.0)  # the boat goes on, and nobody hears it
    two.ship(1).order("course 090")
    two.pass_time(40.0)
    assert two.seen(2) is None  # lost for longer than a minute
    two.ship(1).order("replay 10 s")
    two.ship(1).order("run")
    two.lost.clear()
    two.settle()
    assert two.seen(2) is None  # of its place nothing was said
    two.lose(1)
    two.pass_time(20.0)
    assert two.seen(2) is None
    two.ship(1).order("run")  # after the replay
    two.lost.clear()
    two.settle()
    two.pass_time(1.0)
    assert max(error(two, 2, 1000.0)) < PLACE_ERROR_M


def test_a_boat_with_another_word_is_told_and_not_asked_again(sea: Callable[..., Sea]) -> None:
    two = sea()
    two.words = {"": "anchor", "instructor": "captain"}
    for line in two.lines.values():
        line.line.ended = True
    two.pass_time(10.0)

    def both_told() -> bool:
        two.sea.look()
        return len(two.told) == 2

    await_that(both_told)
    asked = [*two.lines.values()]
    two.pass_time(60.0)
    assert [*two.lines.values()] == asked
    whole = "is not in the sea of the others: wrong token"  # each by a thread of its own
    assert [text[: len(f"boat 1 {whole}")] for text in sorted(two.told)] == [
        f"boat {number} {whole}" for number in (1, 2)
    ]


def seen_by(boat: Caller) -> str:
    """Return the ship nearest to a boat, as its instructor has it."""
    boat.ask("who")
    values = boat.shown.get("contacts", ("",) * 4)
    return f"{values[3]} {values[4]}"


def told_in(lesson: Class, boat: int) -> list[str]:
    """Return what a boat's recording has of the others."""
    (path,) = lesson.folder.glob(f"boat-{boat}/*.trainer")
    with open_recording(path) as recording:
        branches = [each.id for each in recording.branches()]
        orders = [each for branch in branches for each in recording.orders(branch)]
        return [each.text for each in orders if each.giver.role == "class"]


@pytest.mark.process
def test_after_a_kill_both_have_each_other_again_and_each_recording_is_replayed_alone() -> None:
    words = ("--boats", "2", "--one-sea", "1000", "--token", "anchor-42")
    with class_at_sea("depth-changes", *words, "--token", "instructor=chief-17", boats=2) as lesson:
        first, second = (lesson.attach_with(each, "instructor", "chief-17") for each in (1, 2))
        for boat in (first, second):
            assert boat.ask("subscribe contacts")[0]
            assert boat.ask("run")[0]
        await_that(lambda: seen_by(first) == "boat-2 submarine")
        await_that(lambda: seen_by(second) == "boat-1 submarine")
        kill(lesson.process_of(1))
        await_that(lambda: "boat 1 has died (by signal 9)" in lesson.text(), lesson.text)
        await_that(lambda: listens(lesson.socket(1)))
        first = lesson.attach_with(1, "instructor", "chief-17")
        assert seen_by(second) == "boat-1 submarine"
        assert first.ask("subscribe contacts")[0]
        assert first.ask("run")[0]
        gone = "contact boats gone"  # what it had before it died
        await_that(lambda: gone in told_in(lesson, 1) and seen_by(first) == "boat-2 submarine")
        assert lesson.end() == 0
        assert "each 1000 m east of the one before" in lesson.text()
        for number in (1, 2):
            assert told_in(lesson, number)
            (path,) = lesson.folder.glob(f"boat-{number}/*.trainer")
            alone = run_trainer("replay", str(path), env=environment())
            assert alone.returncode == 0, alone.stdout + alone.stderr
        page = lesson.folder / "told.html"
        run_trainer("debrief", str(path), "--html", str(page), env=environment())
        assert "order course 045" not in page.read_text(encoding="utf-8")  # of the first
        assert "contact boat" not in page.read_text(encoding="utf-8")
