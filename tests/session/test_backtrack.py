"""Time wound back: every way leads to the bits of a run that was never wound back."""

import contextlib
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
import pytest
from helpers.line import ScriptedLine
from helpers.sessions import NOISE_AND_FLOODING, TROUBLED_SEA, begin_run, free_session, start_plan
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from trainer.boat.casualties import active_casualties
from trainer.io.recording.absence import NoRecording
from trainer.io.recording.recording import Recording, RecordingError
from trainer.session.past.options import RunOptions
from trainer.session.replay import replay_anyway
from trainer.session.resume import bring_up
from trainer.session.stations.roles import Access
from trainer.session.stations.station import Station
from trainer.session.stations.view import Pace

STEP = 0.5  # [s]
LAST = 160  # tick
# A sea, a current, noisy gauges, a ramp, a flooding, a trigger, tanks at work, the autopilot.
EXERCISE = f"""{TROUBLED_SEA}
[current]
table = [[0, 90, 2], [100, 120, 1]]

[[orders]]
at_s = 7.2
order = "course right 60"

[[orders]]
at_s = 12.5
order = "pump trim forward 3 t"

[[orders]]
at_s = 50
order = "freeze"

[[orders]]
at_s = 61
order = "sea state 3"

{NOISE_AND_FLOODING}
[[casualties]]
when = "depth > 41"
name = "rudder-slow"
"""
# What the instructor orders besides, and at which ticks.
GIVEN = {
    0: ["depth 60"],
    30: ["flood auxiliary 2 t", "casualty gyro-noisy 2 ramp 9"],
    44: ["hover on", "freeze tanks", "release tanks", "current set 045 drift 3"],
    110: ["drain aft", "clear flooding-aft", "speed 40"],
    130: ["rudder left 10", "hover off"],
}

Lines = Iterator[str]


class Bridge(ScriptedLine):
    """The instructor's line: what is typed comes from the test, each line once the last is done."""

    ended = False

    def __init__(self) -> None:
        super().__init__()
        self.typed: Lines = iter(())
        self.shown: Callable[[int, bytes, Pace], None] = lambda _tick, _state, _pace: None
        self.stepping: Callable[[], object] = lambda: False

    def take(self, _most: int) -> list[str]:
        self.wake.set()
        return [] if self.stepping() else [next(self.typed, "quit")]

    def offer(self, tick: int, state: bytes, pace: Pace) -> None:
        self.shown(tick, state, pace)


class Ship:
    """A session of the exercise, recorded, frozen at its start."""

    def __init__(self, exercise: Path, unrecorded: NoRecording | None = None) -> None:
        options = RunOptions(
            exercise=str(exercise), equations="full", given=frozenset(("equations",))
        )
        self.plan, self.boat, header = begin_run(options)
        self.recording = Recording.create(None, header, self.state)
        self.bridge = Bridge()
        self.session = free_session(
            *(self.boat, unrecorded or self.recording, self.bridge),
            schedule=self.plan.schedule,
            wake=self.bridge.wake,
        )
        self.history = self.session.history
        self.bridge.stepping = lambda: self.session.control.steps  # a busy machine is heard between
        self.session.event_log.stations.append(
            Station(self.bridge, Access("instructor"), self.bridge, self.session.event_log.log)  # type: ignore[arg-type]
        )

    def sail(self, typed: Lines) -> None:
        """Run the session, frozen at first, on what is typed; then quit."""
        self.bridge.typed = typed
        self.bridge.wake.set()
        with np.errstate(all="ignore"):
            self.session.run(frozen=True)

    @property
    def state(self) -> bytes:
        return self.boat.records.state.tobytes()

    @property
    def tick(self) -> int:
        return int(self.boat.state.tick)

    @property
    def frozen(self) -> bool:
        return self.session.time.frozen

    def flown(self) -> list[bytes]:
        """Return the states at the ends of all ticks that led to the present."""
        every = list(self.recording.flown(self.recording.branch))
        assert [each.tick for each in every] == list(range(len(every)))
        return [each.state for each in every]

    def said(self, words: str) -> str:
        """Return the last line that was said with these words."""
        return next(line for line in reversed(self.bridge.heard) if words in line)


@pytest.fixture(scope="module")
def exercise(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("wound") / "all.toml"
    path.write_text(EXERCISE)
    return path


@pytest.fixture
def ship(exercise: Path) -> Iterator[Ship]:
    made = Ship(exercise)
    with contextlib.closing(made.recording):
        yield made


def onward(ship: Ship, until: int) -> Lines:
    """Yield what brings the ship on to a tick, with the orders of the ticks on the way."""
    while ship.tick < until:
        yield from GIVEN.get(ship.tick, [])
        following = min([tick for tick in GIVEN if tick > ship.tick] + [until])
        yield f"step {min(following, until) - ship.tick}"


def wait(happened: Callable[[], object]) -> Lines:
    """Yield blank lines, a tick after each while time runs, until it has happened."""
    while not happened():
        yield ""


@pytest.fixture(scope="module")
def plain(exercise: Path) -> list[bytes]:
    """Return the states of the run that is never wound back."""
    ship = Ship(exercise)
    with contextlib.closing(ship.recording):
        ship.sail(onward(ship, LAST))
        s = ship.boat.state
        assert s.flood_aft > 100.0
        assert s.casualty_amount.any()
        assert "rudder-slow" in [each.kind for each in active_casualties(ship.boat)]
        assert s.sea_height > 1.0
        assert not s.stern_by_hand
        assert s.shear_north != 0.0  # the current of the file has not gone yet
        assert s.water_north > 0.5  # and the one that was ordered has come
        return ship.flown()


def test_without_a_recording_the_current_that_was_ordered_comes_back_too(
    exercise: Path, plain: list[bytes]
) -> None:
    ship = Ship(exercise, NoRecording())

    def back() -> Lines:
        yield from onward(ship, 120)
        yield "backtrack 20 s"
        assert ship.tick == 80
        assert ship.state == plain[80]
        yield from onward(ship, LAST)

    with contextlib.closing(ship.recording):
        ship.sail(back())
        assert ship.state == plain[LAST]


@pytest.mark.parametrize(
    ("broken", "jumps", "told"),
    [
        ("moment", ["backtrack 10 s"], "locked by another program"),
        ("fork", ["restore here", "branch 1"], "a disk that does not answer"),
    ],
    ids=["a past that cannot be read", "a branch that cannot begin"],
)
def test_what_the_recording_refuses_leaves_the_boat_where_she_is(
    ship: Ship, monkeypatch: pytest.MonkeyPatch, broken: str, jumps: list[str], told: str
) -> None:
    def refuse(*_: object) -> None:
        raise RecordingError(told)

    def back() -> Lines:
        yield from onward(ship, 60)
        yield "snapshot here"
        yield from onward(ship, 100)
        for words in jumps:
            with monkeypatch.context() as patch:
                patch.setattr(ship.recording, broken, refuse)
                before = ship.state, ship.history.after, ship.history.entry
                yield words
                assert (ship.state, ship.history.after, ship.history.entry) == before
        yield from onward(ship, LAST)

    ship.sail(back())
    assert told in ship.said(told)
    assert len(ship.flown()) == LAST + 1


def test_orders_that_cannot_be_read_back_keep_no_boat_from_a_moment_of_this_run(
    ship: Ship, monkeypatch: pytest.MonkeyPatch
) -> None:
    def unreadable(*_: object) -> None:
        raise RecordingError("locked by another program")

    def back() -> Lines:
        yield from onward(ship, 60)
        yield "snapshot here"
        before = ship.state
        yield from onward(ship, 100)
        with monkeypatch.context() as broken:
            broken.setattr(ship.recording, "orders", unreadable)
            yield "restore here"
            assert ship.state == before
        yield from onward(ship, LAST)

    ship.sail(back())


# What is kept of it


def test_a_run_wound_back_keeps_every_branch_as_it_was(ship: Ship, plain: list[bytes]) -> None:
    def typed() -> Lines:
        yield from onward(ship, 120)
        yield from ("snapshot late", "backtrack 30 s", "rudder right 20", "step 9")
        yield from ("restore late", "step 3", "replay 5 s", "freeze", "take over", "reset")

    ship.sail(typed())

    first, *later = ship.recording.branches()
    assert [state for _, state in ship.recording.states(first.id)] == plain[:121]
    assert [(each.parent, each.why.partition(",")[0]) for each in later] == [
        (1, "backtrack 30 s"),
        (1, "restore late"),
        (1, "take over"),  # before the branch point
        (1, "reset"),
    ]
    assert [each.tick for each in later] == [60, 120, pytest.approx(113, abs=1), 0]
    assert [len(list(ship.recording.states(each.id))) - 1 for each in later] == [9, 3, 0, 0]
    assert all(flight.same for flight in replay_anyway(ship.recording))
    kinds = {each.kind for each in ship.recording.events()}
    assert {"moment", "exercise", "time"} <= kinds


def test_the_end_of_a_branch_is_flown_to_where_its_states_are_lost(
    ship: Ship, plain: list[bytes], monkeypatch: pytest.MonkeyPatch
) -> None:
    def typed() -> Lines:
        yield from onward(ship, 60)
        with monkeypatch.context() as gap:
            gap.setattr(ship.recording, "state", lambda _tick, _state: None)
            yield from onward(ship, 120)
        yield from ("reset", "branch 1")
        assert ship.tick == 110  # of the last orders
        yield "step 10"
        assert ship.state == plain[120]

    ship.sail(typed())

    first, *later = replay_anyway(ship.recording)
    assert first.compared == 61
    assert all(flight.same for flight in (first, *later))


def test_a_moment_has_the_orders_given_in_its_freeze_before_it_and_no_later_ones(
    ship: Ship,
) -> None:
    def typed() -> Lines:
        yield from ("step 20", "rudder left 7", "snapshot here", "rudder right 9", "step 5")
        yield "restore here"
        assert ship.boat.state.ordered_r * ship.boat.toward["rudder"] < 0.0
        yield from ("step 5", "backtrack 2.5 s")  # to where the branch begins, orders and all
        assert ship.boat.state.ordered_r * ship.boat.toward["rudder"] < 0.0
        yield "backtrack 0.5 s"
        assert not ship.boat.state.rudder_by_hand
        yield from ("reset", "depth 90", "snapshot deep", "step 5", "restore deep", "step 2")
        yield "reset"  # to how the exercise begins
        assert ship.boat.state.ordered_depth == 40.0

    ship.sail(typed())

    assert all(flight.same for flight in replay_anyway(ship.recording))


def test_a_replay_over_orders_given_in_a_freeze_is_the_same_to_the_bit(ship: Ship) -> None:
    def typed() -> Lines:
        yield from ("step 20", "rudder left 7", "snapshot here", "step 5", "restore here")
        yield from ("step 5", "replay 10 s")
        yield from wait(lambda: not ship.history.flown.replaying)

    ship.sail(typed())

    assert ship.said("replay over").endswith("the same to the last bit; run goes on from here")


def test_nothing_is_ordered_in_a_replay_and_no_tick_of_it_is_kept_twice(ship: Ship) -> None:
    def typed() -> Lines:
        yield from onward(ship, 60)
        yield from ("backtrack 10 s", "step 20", "replay 20 s", "rudder right 5")
        assert "a replay is running: take over first" in ship.bridge.heard[-1]
        yield from wait(lambda: not ship.history.flown.replaying)

    ship.sail(typed())

    assert "take over first" in ship.said("? a replay")
    branch = ship.recording.branch
    kept = [tick for tick, _ in ship.recording.states(branch)]
    assert kept == list(range(40, 61))
    assert [tick for tick, _, _ in ship.recording.ledger(branch)] == kept[1:]


# Anything at all

FREE = (
    "depth 55",
    "course left 40",
    "speed 12",
    "rudder left 10",
    "autopilot on",
    "stern planes rise 5",
    "casualty stern-slow 0.5 ramp 6",
    "casualty depth-gauge-noisy 2",
    "casualty flooding-centre 0.1 ramp 3",
    "clear all",
    "sea state 6",
    "sea calm",
    "flood auxiliary 3 t",
    "hover on",
    "blow forward",
    "vent all open",
    "compressor on",
    "freeze depth",
    "freeze tanks",
    "release all",
    "speed 50",
)
TYPED = st.one_of(
    st.integers(1, 40).map(lambda count: f"step {count}"),
    st.sampled_from(FREE),
    st.sampled_from(("snapshot", "snapshot", "restore s1", "restore s2", "restore s3")),
    st.integers(1, 80).map(lambda halves: f"backtrack {0.5 * halves:g}"),
    st.integers(1, 80).map(lambda halves: f"replay {0.5 * halves:g}"),
    st.sampled_from(("freeze", "run", "reset", "take over", "", "", "")),
)


class Witness:
    """What has been seen of the states, by one who knows nothing of branches and recordings."""

    def __init__(self, ship: Ship) -> None:
        self.ship = ship
        self.first = {0: ship.state}
        self.past = dict(self.first)  # at the end of each tick of the present run
        self.mixed: set[int] = set()  # where that may include orders of the tick itself
        self.kept: dict[str, dict[int, bytes]] = {}
        self.left = b""  # where a replay has to arrive
        self.shown = 0  # tick
        ship.bridge.shown = self.see

    def see(self, tick: int, state: bytes, pace: Pace) -> None:
        """Take the state at the end of a new tick, or check it in a replay."""
        if not pace.replaying and tick == max(self.past) + 1:
            self.past[tick] = state
        elif pace.replaying and tick != self.shown and tick not in self.mixed:
            assert state == self.past[tick]
        self.shown = tick

    def typed(self, lines: list[str]) -> Lines:
        """Yield the lines, and check after each what it has done."""
        for line in lines:
            tick, state, said = self.ship.tick, self.ship.state, len(self.ship.bridge.heard)
            replaying = self.ship.history.flown.replaying
            if line == "take over" and replaying:
                self.past, self.left = self.upto(tick) | {tick: state}, b""
                self.mixed.add(tick)
            yield f"snapshot s{len(self.kept) + 1}" if line == "snapshot" else line
            if not any(each.startswith("? ") for each in self.ship.bridge.heard[said:]):
                self.done(line, tick, state, again=replaying)
            self.replayed()

    def replayed(self) -> None:
        """Check that a replay shows what has been, and arrives where it was begun."""
        if not self.ship.history.flown.replaying and self.left:
            assert self.ship.state == self.left
            assert self.ship.frozen
            self.left = b""

    def done(self, line: str, tick: int, state: bytes, *, again: bool) -> None:
        """Check what an order about moments has done, and do it to what was seen."""
        word, _, rest = line.partition(" ")
        if word == "snapshot":
            self.kept[f"s{len(self.kept) + 1}"] = self.upto(tick) | {tick: state}
            self.mixed.add(tick)
        elif word == "restore":
            self.back(dict(self.kept[rest]))
        elif word == "backtrack":
            self.back(self.upto(max(tick - round(float(rest) / STEP), 0)))
        elif word == "reset":
            self.back(dict(self.first))
        elif word == "replay" and not again:
            self.left = state

    def upto(self, tick: int) -> dict[int, bytes]:
        return {each: state for each, state in self.past.items() if each <= tick}

    def back(self, past: dict[int, bytes]) -> None:
        """Check that the ship has gone back to the end of a past, and take it for the present."""
        assert self.ship.tick == max(past)
        assert self.ship.state == past[max(past)]
        self.past, self.left = past, b""


@pytest.mark.long
@settings(max_examples=20, suppress_health_check=[HealthCheck.too_slow])
@given(st.lists(TYPED, max_size=40))
def test_whatever_an_instructor_does_is_recorded_so_that_it_can_be_flown_again(
    exercise: Path, lines: list[str]
) -> None:
    ship = Ship(exercise)
    with contextlib.closing(ship.recording):
        ship.sail(Witness(ship).typed(lines))

        flights = replay_anyway(ship.recording)
        assert [each for each in flights if not each.same] == []
        assert not [line for line in ship.bridge.heard if "left its recording" in line]
        places = [each.entry for each in ship.recording.orders(ship.recording.branch)]
        assert sorted(set(places) - {None}) == [each for each in places if each is not None]  # type: ignore[type-var]
        end = ship.history.flown.end().state if ship.history.flown.replaying else ship.state
        boat = start_plan(ship.plan)
        history = bring_up(ship.recording, ship.plan, boat)
        assert boat.records.state.tobytes() == end
        assert (history.after, history.entry) >= (0, 0)
