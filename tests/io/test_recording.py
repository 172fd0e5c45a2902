"""The record of a run: what is in it is true, and nothing that happens to its program loses it."""

import contextlib
import csv
import functools
import os
import random
import re
import shutil
import sqlite3
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import closing
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import pytest
from helpers.altered import alter, locked
from helpers.givers import HELM, giver_at
from helpers.lanes import sample_cases
from helpers.waiting import await_that, eventually
from hypothesis import given, settings
from hypothesis import strategies as st

from trainer.io.recording import checkpoint, queries
from trainer.io.recording import file as file_module
from trainer.io.recording import recording as recording_module
from trainer.io.recording.facts import BranchCause
from trainer.io.recording.recording import (
    FILE_FORMAT,
    Branch,
    Moment,
    RecordedOrder,
    Recording,
    RecordingError,
)
from trainer.io.tables import Layout, export_csv, export_parquet

posix = pytest.mark.skipif(os.name != "posix", reason="signals and limits of POSIX")
HEADER = {"vessel": "[vessel]\nname = 'Ünique'\n", "seed": "7"}


def state_of(tick: int) -> bytes:
    """Return a state that cannot be another's; of the size of a real one."""
    return f"state {tick} ".encode().ljust(1944, b".")


def begin(path: Path | None) -> Recording:
    return Recording.create(path, HEADER, state_of(0))


@pytest.fixture
def path(tmp_path: Path) -> Path:
    return tmp_path / "watch #1?.recording"  # a name that has to be quoted in an address


def files(path: Path) -> set[str]:
    """Return the names in the folder of a recording, as endings of its own."""
    return {each.name.removeprefix(path.name) for each in path.parent.iterdir()}


# What is written is read back


def fill(recording: Recording) -> None:
    """Record a short run with something of each kind."""
    first = recording.order(0, HELM, "rudder left 15")
    recording.answered(first, "rudder left 15", accepted=True)
    for tick in (1, 2, 3):
        recording.state(tick, state_of(tick))
        recording.timing(tick, 100 * tick, 1000 * tick)
    second = recording.order(2, giver_at("ballast"), "blow all", entry=4)
    recording.snapshot("off Bute", Moment(1, 3, b"as it stood", second, 5))
    recording.answered(second, "no air", accepted=False)
    recording.event(3, "attached", "planes", "a line, «quoted»")


def check_filled(recording: Recording) -> None:
    assert recording.header() == HEADER
    assert recording.branches() == [
        Branch(1, None, 0, 0, 0, "the start", state_of(0), BranchCause.START)
    ]
    assert recording.orders(1) == [
        RecordedOrder(
            1, 1, 0, HELM, "rudder left 15", None, accepted=True, answer="rudder left 15"
        ),
        RecordedOrder(2, 1, 2, giver_at("ballast"), "blow all", 4, accepted=False, answer="no air"),
    ]
    assert list(recording.states(1)) == [(tick, state_of(tick)) for tick in range(4)]
    assert list(recording.ledger(1)) == [(1, 100, 1000), (2, 200, 2000), (3, 300, 3000)]
    assert recording.snapshots() == [("off Bute", Moment(1, 3, b"as it stood", 2, 5))]
    assert recording.latest() == Moment(1, 3, state_of(3), 2, 5)
    (noted,) = recording.events()
    assert (noted.branch, noted.tick, noted.kind, noted.who) == (1, 3, "attached", "planes")
    assert noted.text == "a line, «quoted»"
    assert re.fullmatch(r"20\d\d-\d\d-\d\dT\d\d:\d\d:\d\d\.\d{3}\+00:00", noted.wall)


@pytest.mark.parametrize("temporary", [False, True])
def test_all_that_was_recorded_is_read_back(path: Path, temporary: object) -> None:
    with closing(begin(None if temporary else path)) as recording:
        fill(recording)
        check_filled(recording)  # what still waits is read as well
    assert files(path) == (set() if temporary else {""})  # one file, nothing beside it


@pytest.mark.parametrize("open_it", [Recording.look, Recording.reopen])
def test_a_closed_recording_is_read_back(path: Path, open_it: Callable[[Path], Recording]) -> None:
    with closing(begin(path)) as recording:
        fill(recording)
    with closing(open_it(path)) as recording:
        check_filled(recording)
    assert files(path) == {""}


def test_a_look_changes_nothing(path: Path) -> None:
    with closing(begin(path)) as recording:
        fill(recording)
    before = path.read_bytes()

    with closing(Recording.look(path)) as recording:
        recording.order(3, giver_at("nobody"), "dive")

        assert "readonly" in recording.trouble
    assert path.read_bytes() == before


def test_a_tick_flown_again_on_its_branch_does_not_replace_the_first(path: Path) -> None:
    with closing(begin(path)) as recording:
        for state in (b"first", b"second"):
            recording.state(1, state)
            recording.timing(1, len(state), 0)

        assert recording.state_at(1, 1) == b"first"
        assert list(recording.ledger(1)) == [(1, 5, 0)]


def test_rows_are_gathered_and_go_out_together(path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(recording_module, "BATCH_ROWS", 10)
    monkeypatch.setattr(checkpoint, "LOOK_PERIOD_S", 1000.0)
    with closing(begin(path)) as recording, closing(Recording.look(path)) as reader:
        for tick in range(1, 15):
            recording.state(tick, state_of(tick))
        assert reader.latest().tick == 10


def test_what_waits_is_written_before_long_though_nothing_follows(path: Path) -> None:
    with closing(begin(path)) as recording, closing(Recording.look(path)) as reader:
        recording.state(1, state_of(1))
        recording.timing(1, 300, 80_000)
        recording.event(1, "time", "", "frozen")
        assert eventually(lambda: reader.latest().tick == 1)  # a second is promised
        assert [found for found, _, _ in reader.ledger(1)] == [1]
        assert [each.text for each in reader.events()] == ["frozen"]


def test_an_order_is_on_disk_before_it_acts_and_all_before_it_too(path: Path) -> None:
    with closing(begin(path)) as recording, closing(Recording.look(path)) as reader:
        recording.state(1, state_of(1))
        recording.order(1, HELM, "ahead full")

        assert [each.text for each in reader.orders(1)] == ["ahead full"]
        assert reader.orders(1)[0].accepted is None
        assert reader.latest().tick == 1


# Branches


@dataclass
class Track:
    """A branch as a child would keep it: everything copied, nothing looked up."""

    begun: Moment
    moments: dict[int, Moment]  # by tick, of its past too
    orders: list[int]
    kept: list[tuple[str, Moment]]  # snapshots


@dataclass
class Model:
    """A recording as lists and dictionaries."""

    tracks: list[Track] = field(default_factory=list)
    given: int = 0
    snapshots: list[tuple[str, Moment]] = field(default_factory=list)
    now: Moment = field(default_factory=lambda: Moment(1, 0, b"0", 0, 0))

    def __post_init__(self) -> None:
        self.tracks.append(Track(self.now, {0: self.now}, [], []))

    @property
    def track(self) -> Track:
        return self.tracks[-1]

    def order(self, place: int | None) -> None:
        self.given += 1
        self.track.orders.append(self.given)
        here = self.now.entry if place is None else place + 1
        state = b"%s+%d" % (self.now.state, self.given)
        self.now = replace(self.now, state=state, after=self.given, entry=here)

    def tick(self) -> None:
        tick = self.now.tick + 1
        self.now = replace(self.now, tick=tick, state=b"%d.%d" % (len(self.tracks), tick))
        self.track.moments[tick] = self.now

    def keep(self, name: str) -> None:
        self.snapshots.append((name, self.now))
        self.track.kept.append((name, self.now))

    def fork(self, moment: Moment) -> None:
        past = self.tracks[moment.branch - 1]
        self.now = replace(moment, branch=len(self.tracks) + 1)
        begun = (moment.tick, moment.after)
        self.tracks.append(
            Track(
                moment,
                {tick: each for tick, each in past.moments.items() if tick < moment.tick}
                | {moment.tick: self.now},
                [order for order in past.orders if order <= moment.after],
                [each for each in past.kept if (each[1].tick, each[1].after) <= begun],
            )
        )

    def listed(self) -> dict[str, Moment]:
        """Return the snapshots: those of the past first, then the latest elsewhere."""
        return dict(self.snapshots) | dict(self.track.kept)


STEPS = st.one_of(
    st.tuples(st.just("tick")),
    st.tuples(st.just("tick")),
    st.tuples(st.just("order"), st.booleans()),
    st.tuples(st.just("keep"), st.sampled_from("ab")),
    st.tuples(st.just("restore"), st.integers(0, 99)),
    st.tuples(st.just("backtrack"), st.integers(0, 99), st.integers(0, 99)),
)


def take(step: tuple[object, ...], model: Model, recording: Recording) -> None:
    """Do the same to the model and to the recording."""
    match step:
        case ("tick",):
            model.tick()
            recording.state(model.now.tick, model.now.state)
        case ("order", bool(scheduled)):
            place = model.now.entry if scheduled else None
            model.order(place)
            assert recording.order(model.now.tick, giver_at("a"), "b", place) == model.given
        case ("keep", str(name)):
            model.keep(name)
            recording.snapshot(name, model.now)
        case ("restore", int(pick)) if model.snapshots:
            moment = model.snapshots[pick % len(model.snapshots)][1]
            model.fork(moment)
            assert recording.fork(moment, "restore") == len(model.tracks)
        case ("backtrack", int(pick), int(tick)):
            moments = model.tracks[pick % len(model.tracks)].moments
            moment = list(moments.values())[tick % len(moments)]
            model.fork(moment)
            assert recording.fork(moment, "backtrack") == len(model.tracks)


@settings(max_examples=100)
@given(st.lists(STEPS, max_size=40))
def test_every_branch_has_the_past_that_led_to_it(steps: list[tuple[object, ...]]) -> None:
    model = Model()
    with closing(Recording.create(None, {}, b"0")) as recording:
        for step in steps:
            take(step, model, recording)

        assert recording.branch == len(model.tracks)
        assert dict(recording.snapshots()) == model.listed()
        assert recording.latest() == model.track.moments[max(model.track.moments)]
        branches = recording.branches()
        for number, track in enumerate(model.tracks, start=1):
            begun = branches[number - 1]
            assert (begun.tick, begun.after, begun.entry, begun.state) == (
                *(track.begun.tick, track.begun.after),
                *(track.begun.entry, track.begun.state),
            )
            assert [recording.moment(number, tick) for tick in range(-1, 45)] == [
                track.moments.get(tick) for tick in range(-1, 45)
            ]
            for after in {0, track.begun.after, model.given // 2}:
                assert [order.id for order in recording.orders(number, after)] == [
                    order for order in track.orders if order > after
                ]
            assert [(each.tick, each.state) for each in recording.flown(number)] == [
                (tick, moment.state) for tick, moment in track.moments.items()
            ]


def test_a_branch_taken_over_in_a_replay_of_its_forebear_begins_there() -> None:
    with closing(Recording.create(None, {}, b"0")) as recording:
        for tick in (1, 2, 3):
            recording.order(tick - 1, HELM, f"order of {tick - 1}")
            recording.state(tick, b"%d" % tick)
        moment = recording.moment(1, 2)
        assert moment
        recording.fork(moment, "backtrack")
        recording.order(2, HELM, "another")
        recording.state(3, b"another 3")

        # a replay of branch 2 that began before branch 2 did
        recording.fork(Moment(2, 1, b"1", 1, 0), "take over")

        assert recording.branches()[-1].parent == 1
        assert [order.text for order in recording.orders(3)] == ["order of 0"]
        assert [recording.state_at(3, tick) for tick in (0, 1, 2)] == [b"0", b"1", None]


# What a killed program leaves


def test_a_branch_taken_over_while_nothing_can_be_read_has_no_later_order() -> None:
    with closing(begin(None)) as recording:
        recording.order(1, HELM, "depth 70")
        for tick in (2, 3):
            recording.state(tick, state_of(tick))
        recording.order(3, HELM, "depth 80")
        recording.fork(Moment(1, 3, state_of(3), 2, 0), "backtrack")
        recording.trouble = "locked"  # then the owner of a moment is not known
        recording.fork(Moment(2, 2, state_of(2), 1, 0), "take over")
        recording.trouble = ""
        recording.flush()

        assert [each.text for each in recording.orders(3)] == ["depth 70"]


def left_behind(path: Path) -> None:
    """Leave what a killed program leaves: the file, and beside it what was written ahead."""
    with closing(begin(path)) as recording:
        fill(recording)
        recording.flush()
        copies = [path.with_name(path.name + ending) for ending in ("", "-wal")]
        held = [each.read_bytes() for each in copies]
    for each, content in zip(copies, held, strict=True):
        each.write_bytes(content)


# Several programs at one file


def test_a_reader_sees_what_is_committed_and_holds_nobody_up(path: Path) -> None:
    with closing(begin(path)) as recording, closing(Recording.look(path)) as reader:
        for tick in range(1, 100):
            recording.state(tick, state_of(tick))
        recording.flush()
        reading = reader.states(1)  # in the midst of it while writing goes on
        assert [next(reading)[0], next(reading)[0]] == [0, 1]
        for tick in range(100, 2000):
            recording.state(tick, state_of(tick))
        recording.order(1999, HELM, "ahead full")

        assert recording.trouble == ""
        assert sum(1 for _ in reading) == 98  # as it was when the reading began
        assert reader.latest().tick == 1999


READS_WHILE_IT_WRITES = """
import sys, time
from pathlib import Path
from trainer.io.recording import checkpoint, file
from trainer.io.recording.recording import Recording

checkpoint.LOOK_PERIOD_S = 0.0002
connect = file.connect

def heard_all_the_time(path, options):
    connection = connect(path, options)
    connection.set_progress_handler(lambda: None, 1)  # SQLite asks Python at every step
    return connection

file.connect = heard_all_the_time
recording = Recording.create(Path(sys.argv[1]), {}, b"start")
end, tick = time.monotonic() + 1.0, 0
while time.monotonic() < end:
    tick += 1
    recording.state(tick, b"state")
    recording.moment(1, max(tick - 5, 0))
recording.close()
"""


@pytest.mark.process
def test_what_reads_back_never_waits_for_the_thread_that_writes(path: Path) -> None:
    words = [sys.executable, "-c", READS_WHILE_IT_WRITES, str(path)]

    subprocess.run(words, check=True, timeout=60)

    with closing(Recording.look(path)) as recording:
        assert recording.latest().tick > 10


@pytest.mark.process
def test_one_program_alone_may_go_on_with_a_recording(tmp_path: Path) -> None:
    paths = [tmp_path / f"watch #1? {name}" for name in ("begun", "gone on with", "looked at")]
    begin(paths[1]).close()
    begin(paths[2]).close()
    again = (
        "import sys; from pathlib import Path\n"
        "from trainer.io.recording import file as recording_file\n"
        "from trainer.io.recording.recording import Recording, RecordingError\n"
        "recording_file.BUSY_TIMEOUT_S = 0.1\n"
        "for path in sys.argv[1:]:\n"
        "    try: Recording.reopen(Path(path))\n"
        "    except RecordingError as error: print(error)\n"
    )
    with closing(begin(paths[0])), closing(Recording.reopen(paths[1])):
        with closing(Recording.look(paths[2])):
            said = subprocess.check_output([sys.executable, "-c", again, *paths], text=True)
        assert said.count("is in use: a session is writing it or a program reading it") == 3
        for path in paths:
            with closing(Recording.look(path)) as reader:
                assert reader.latest().tick == 0
    for path in paths:
        with closing(Recording.reopen(path)) as recording:
            assert recording.branch == 1


def test_what_is_written_ahead_is_brought_home_while_writing_goes_on(
    path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(checkpoint, "MIN_CHECKPOINT_BYTES", 100_000)
    monkeypatch.setattr(checkpoint, "LOOK_PERIOD_S", 0.002)
    ahead = path.with_name(path.name + "-wal")
    with closing(begin(path)) as recording:
        for tick in range(1, 500):
            recording.state(tick, state_of(tick))
        recording.flush()
        await_that(lambda: ahead.stat().st_size < 100_000)
        assert path.stat().st_size > 499 * 1944
    assert files(path) == {""}


def test_what_is_written_without_a_pause_is_not_written_ahead_without_end(
    path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(checkpoint, "MAX_AHEAD_BYTES", 2_000_000)
    ahead, most = path.with_name(path.name + "-wal"), 0
    with closing(begin(path)) as recording:
        for tick in range(1, 8_000):
            recording.state(tick, state_of(tick))
            most = max(most, ahead.stat().st_size)
        recording.flush()
        home = path.stat().st_size

    assert most < 2 * 2_000_000
    assert home > 10_000_000


class Bringing(sqlite3.Connection):
    """A connection that notes when two bring home at a time; the checkpoints' own is slow at it."""

    at_it = 0
    together = 0
    slow_begun = threading.Event()
    written = threading.Event()

    def execute(self, sql: str, /, *values: Any) -> sqlite3.Cursor:
        if sql != checkpoint.CHECKPOINT_STATEMENT:
            return super().execute(sql, *values)
        Bringing.at_it += 1
        Bringing.together += Bringing.at_it > 1
        try:
            if threading.current_thread().name == "checkpoints":
                Bringing.slow_begun.set()
                Bringing.written.wait(0.3)  # longer than all takes that is written meanwhile
            return super().execute(sql, *values)
        finally:
            Bringing.at_it -= 1


def test_a_writer_far_ahead_waits_for_what_is_being_brought_home(
    path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(checkpoint, "MIN_CHECKPOINT_BYTES", 100_000)
    monkeypatch.setattr(checkpoint, "LOOK_PERIOD_S", 0.002)
    monkeypatch.setattr(checkpoint, "MAX_AHEAD_BYTES", 1_000_000)
    monkeypatch.setattr(sqlite3, "connect", functools.partial(sqlite3.connect, factory=Bringing))
    ahead = path.with_name(path.name + "-wal")
    with closing(begin(path)) as recording:
        for tick in range(1, 200):
            recording.state(tick, state_of(tick))
        recording.flush()
        assert Bringing.slow_begun.wait(60.0)
        for tick in range(200, 3_000):
            recording.state(tick, state_of(tick))
        recording.flush()
        Bringing.written.set()

        assert Bringing.together == 0
        assert ahead.stat().st_size < 3_000_000


class Slow(sqlite3.Connection):
    """A connection that the run's own thread brings home with, on a slow disk."""

    begun = 0

    def execute(self, sql: str, /, *values: Any) -> sqlite3.Cursor:
        if (
            sql == checkpoint.CHECKPOINT_STATEMENT
            and threading.current_thread().name != "checkpoints"
        ):
            Slow.begun += 1
            time.sleep(0.3)  # as a slow disk
        return super().execute(sql, *values)


def test_a_slow_disk_that_the_run_waits_for_is_not_out_of_reach(
    path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(checkpoint, "LOOK_PERIOD_S", 0.002)  # the thread looks while the run waits
    monkeypatch.setattr(checkpoint, "MAX_AHEAD_BYTES", 1_000_000)
    monkeypatch.setattr(sqlite3, "connect", functools.partial(sqlite3.connect, factory=Slow))
    with closing(begin(path)) as recording:
        for tick in range(1, 6_000):
            recording.state(tick, state_of(tick))
        assert Slow.begun
        assert not recording.trouble
        assert recording.absences == 0
        recording.flush()
        assert recording.latest().tick == tick


class Held(sqlite3.Connection):
    """A connection that the recording's thread commits with, on a disk that does not answer."""

    reached, answers = threading.Event(), threading.Event()

    def execute(self, sql: str, /, *values: Any) -> sqlite3.Cursor:
        if sql == "COMMIT" and threading.current_thread().name == "checkpoints":
            Held.reached.set()
            assert Held.answers.wait(60.0)
        return super().execute(sql, *values)


def test_a_disk_that_answers_again_is_written_to_at_once(
    path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(checkpoint, "LOOK_PERIOD_S", 0.002)
    monkeypatch.setattr(recording_module, "RETRY_PERIOD_S", 1000.0)
    monkeypatch.setattr(sqlite3, "connect", functools.partial(sqlite3.connect, factory=Held))
    with closing(begin(path)) as recording:
        recording.state(1, state_of(1))
        assert Held.reached.wait(60.0)
        recording.order(1, HELM, "depth 50")
        assert "does not answer" in recording.trouble
        Held.answers.set()
        assert eventually(lambda: not recording.trouble)
        assert (recording.missing, recording.absences) == ("", 1)
        assert [each.text for each in recording.orders(1)] == ["depth 50"]


def test_a_reader_who_stays_in_the_past_is_waited_for_once_in_a_while_only(
    path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(checkpoint, "MAX_AHEAD_BYTES", 1_000_000)
    monkeypatch.setattr(recording_module, "BATCH_ROWS", 20)
    monkeypatch.setattr(
        recording_module, "WRITE_TIMEOUT_S", 60.0
    )  # a session goes on sooner, without
    asked: list[str] = []
    connect = file_module.connect

    def watched(path: Path, options: str) -> sqlite3.Connection:
        connection = connect(path, options)
        connection.set_trace_callback(asked.append)
        return connection

    monkeypatch.setattr(file_module, "connect", watched)
    with closing(begin(path)) as recording, closing(sqlite3.connect(path)) as reader:
        reader.execute("BEGIN")
        reader.execute("SELECT count(*) FROM states").fetchone()
        for tick in range(1, 4_000):
            recording.state(tick, state_of(tick))
        checkpoints = sum("wal_checkpoint" in each for each in asked)
        reader.execute("COMMIT")
        for tick in range(4_000, 8_000):
            recording.state(tick, state_of(tick))
        left = path.with_name(path.name + "-wal").stat().st_size
        recording.flush(60.0)
        assert recording.latest().tick == tick

    assert 5 < checkpoints < 25  # of two hundred commits
    assert left < 2_500_000  # once the reader has gone


# Trouble with the disk


@contextlib.contextmanager
def small_disk() -> Iterator[None]:
    """Let no file grow beyond a million bytes."""
    resource = pytest.importorskip("resource")
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (1_000_000, before[1]))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)


@pytest.fixture
def impatient(monkeypatch: pytest.MonkeyPatch) -> None:
    """Let a recording out of reach be tried again at once."""
    monkeypatch.setattr(recording_module, "RETRY_PERIOD_S", 0.01)
    monkeypatch.setattr(recording_module, "WRITE_TIMEOUT_S", 0.1)
    monkeypatch.setattr(checkpoint, "LOOK_PERIOD_S", 0.01)


def fly(recording: Recording, first: int, last: int) -> None:
    """Record so many ticks, with an order at every fifth."""
    for tick in range(first, last + 1):
        recording.state(tick, state_of(tick))
        recording.timing(tick, 1, 2)
        if tick % 5 == 0:
            recording.answered(recording.order(tick, HELM, f"order at {tick}"), "yes", True)  # noqa: FBT003


def check_whole(path: Path, last: int) -> None:
    """Check that a recording has all that `fly` records to a tick."""
    with closing(Recording.look(path)) as again:
        assert [tick for tick, _ in again.states(1)] == list(range(last + 1))
        orders = again.orders(1)
        assert [each.text for each in orders] == [f"order at {k}" for k in range(5, last + 1, 5)]
        assert all(each.answer == "yes" for each in orders[:-1])  # the last may have waited
        assert len(again.branches()) == 1


@posix
@pytest.mark.usefixtures("impatient")
def test_a_full_disk_is_told_and_all_is_there_once_there_is_room_again(path: Path) -> None:
    with closing(begin(path)) as recording:
        with small_disk():
            fly(recording, 1, 400)
            told = rf"{re.escape(str(path))}: .+; all up to tick \d+ of branch 1 is kept"
            assert re.fullmatch(told, recording.trouble)
            assert recording.moment(1, 400) is None
        assert eventually(lambda: not recording.trouble)
        fly(recording, 401, 410)
        assert (recording.missing, recording.absences) == ("", 1)
    check_whole(path, 410)


@posix
@pytest.mark.usefixtures("impatient")
def test_a_recording_that_ends_on_a_full_disk_is_whole_as_far_as_it_goes(path: Path) -> None:
    with small_disk():
        recording = begin(path)
        fly(recording, 1, 400)
        recording.close()
    found = re.search(r"all up to tick (\d+)", recording.trouble)
    assert found
    kept = int(found[1])
    assert re.fullmatch(r"\d+ ticks, \d+ orders", recording.missing)
    assert int(recording.missing.split()[0]) == 400 - kept
    check_whole(path, kept - kept % 5)


@pytest.mark.usefixtures("impatient")
def test_another_program_s_lock_holds_nobody_up_and_loses_nothing(path: Path) -> None:
    with closing(begin(path)) as recording:
        fly(recording, 1, 10)
        with locked(path):
            began = time.monotonic()
            fly(recording, 11, 100)
            recording.event(100, "mark", "helm", "here")
            assert time.monotonic() - began < 10 * recording_module.CALLER_WAIT_S
            assert "locked" in recording.trouble
        assert eventually(lambda: not recording.trouble)
        assert recording.missing == ""
        assert [each.text for each in recording.events()] == ["here"]
    check_whole(path, 100)


@pytest.mark.usefixtures("impatient")
def test_a_moment_that_could_not_be_kept_at_once_is_not_kept_later(path: Path) -> None:
    with closing(begin(path)) as recording:
        recording.snapshot("a", Moment(1, 0, state_of(0), 0, 0))
        with locked(path):
            recording.snapshot("b", Moment(1, 0, state_of(0), 0, 0))
            assert "locked" in recording.trouble
        recording.event(1, "mark", "helm", "here")
        assert eventually(lambda: not recording.trouble)
        assert [each.text for each in recording.events()] == ["here"]
        assert [name for name, _ in recording.snapshots()] == ["a"]


@pytest.fixture
def narrow(monkeypatch: pytest.MonkeyPatch) -> None:
    """Have room for about twenty ticks while a recording is out of reach."""
    monkeypatch.setattr(recording_module, "MAX_WAITING_BYTES", 50_000)


def unreadable(*_: object) -> None:
    raise RecordingError("a disk that does not answer")


@pytest.mark.usefixtures("impatient", "narrow")
def test_what_there_is_no_room_for_is_a_gap_that_the_file_tells(
    path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    with closing(begin(path)) as recording:
        fly(recording, 1, 10)
        with locked(path):
            fly(recording, 11, 60)
            assert recording.fork(Moment(1, 20, state_of(20), 4, 0), "backtrack") == 2
            fly(recording, 21, 40)
        assert eventually(lambda: recording.reachable)
        with monkeypatch.context() as unread:
            unread.setattr(recording, "last_tick", unreadable)
            assert not recording.go_on(Moment(2, 40, state_of(40), 16, 0))
        assert recording.trouble
        assert eventually(lambda: recording.reachable)
        assert recording.go_on(Moment(2, 40, state_of(40), 16, 0))
        assert recording.trouble == ""
        recording.state(41, state_of(41))
        assert recording.order(41, HELM, "after it") == 17

    assert recording.missing == "70 ticks"
    with closing(Recording.look(path)) as again:
        _, back, after = again.branches()
        assert (back.parent, back.tick, back.after, back.why) == (1, 20, 4, "backtrack")
        assert (after.parent, after.tick, after.state) == (back.id, 40, state_of(40))
        assert after.why == "not recorded after tick 20: 70 ticks lost"
        past = [(each.id, each.branch, each.tick, each.answer) for each in again.orders(after.id)]
        given = [(1, 1, 5), (2, 1, 10), (3, 1, 15), (4, 1, 20)]
        given += [(13, 2, 25), (14, 2, 30), (15, 2, 35), (16, 2, 40)]
        assert past == [*((*each, "yes") for each in given), (17, 3, 41, "")]
        assert [tick for tick, _ in again.states(after.id)] == [40, 41]
        assert [each.text for each in again.orders(after.id, after.after)] == ["after it"]
        assert [each.tick for each in again.flown(after.id)] == [*range(11), 20, 40, 41]
        assert again.latest().tick == 41


@pytest.mark.usefixtures("impatient", "narrow")
def test_orders_of_a_gap_are_written_at_the_end_too(path: Path) -> None:
    with closing(begin(path)) as recording:
        fly(recording, 1, 10)
        with locked(path):
            fly(recording, 11, 60)
            assert recording.trouble
    assert recording.missing == "50 ticks"
    with closing(Recording.look(path)) as again:
        assert [(each.tick, each.accepted) for each in again.orders(1)][2:] == [
            (tick, True) for tick in range(15, 61, 5)
        ]
        assert again.latest().tick == 10


@pytest.mark.usefixtures("impatient", "narrow")
def test_no_order_is_written_where_a_reader_would_take_it_for_damage(
    path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    for module in (recording_module, queries):
        monkeypatch.setattr(module, "ORDER_LEEWAY_TICKS", 100)
    with closing(begin(path)) as recording:
        fly(recording, 1, 10)
        with locked(path):
            fly(recording, 11, 130)
            recording.fork(Moment(1, 70, state_of(70), 14, 0), "backtrack")
            fly(recording, 71, 180)
        assert eventually(lambda: recording.reachable)
        assert recording.go_on(Moment(2, 180, state_of(180), 48, 0))
    assert recording.missing == "230 ticks, 6 orders"
    with closing(Recording.look(path)) as again:
        given = [each.tick for each in again.orders(3)]
        assert given == [*range(5, 71, 5), *range(75, 171, 5)]


@pytest.mark.usefixtures("impatient")
def test_orders_and_forks_that_have_no_room_in_a_gap_are_counted_and_refused(
    path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(recording_module, "MAX_WAITING_BYTES", 20_000)
    back = Moment(1, 10, state_of(10), 2, 0)
    with closing(begin(path)) as recording:
        fly(recording, 1, 10)
        with locked(path):
            fly(recording, 11, 30)
            with pytest.raises(RecordingError, match=r"no room for one more branch: .*locked"):
                list(map(recording.fork, [back] * 20, ["backtrack"] * 20))
            last = recording.branch
            assert last > 5
            fly(recording, 11, 30)
        assert eventually(lambda: recording.reachable)
        assert recording.go_on(Moment(last, 30, state_of(30), 10, 0))
    assert recording.missing == "40 ticks, 4 orders"
    with closing(Recording.look(path)) as again:
        assert [each.parent for each in again.branches()] == [None, *[1] * (last - 1), last]


@pytest.mark.usefixtures("impatient", "narrow")
def test_an_order_after_a_gap_and_a_new_start_is_no_number_of_those_lost(path: Path) -> None:
    with closing(begin(path)) as recording:
        fly(recording, 1, 10)
        with locked(path):
            fly(recording, 11, 60)
            fly(recording, 61, 80)
        assert eventually(lambda: recording.reachable)
        assert recording.go_on(Moment(1, 80, state_of(80), 16, 0))
    with closing(Recording.reopen(path)) as again:
        assert again.order(81, HELM, "after it") == 17
        branch = again.branch
        assert [each.text for each in again.orders(branch, 16)] == ["after it"]


@posix
@pytest.mark.parametrize("remove", [Path.unlink, lambda path: path.rename(path.parent / "other")])
def test_a_recording_that_is_not_there_any_more_is_told(
    path: Path, remove: Callable[[Path], object]
) -> None:
    with closing(begin(path)) as recording:
        recording.order(1, HELM, "before")
        assert not recording.trouble
        remove(path)
        recording.order(2, HELM, "after")
        assert "is not there any more" in recording.trouble
        assert "all up to tick 2 of branch 1 is kept" in recording.trouble


@posix
def test_a_recording_for_which_there_is_no_room_is_not_begun(path: Path) -> None:
    with (
        small_disk(),
        pytest.raises(RecordingError, match=r"cannot be made: .*(disk I/O error|full)"),
    ):
        Recording.create(path, {"vessel": "v" * 2_000_000}, b"")
    assert files(path) == set()


# Files that are no recordings


def foreign(path: Path) -> None:
    alter(path, "CREATE TABLE accounts (name)")


def newer(path: Path) -> None:
    begin(path).close()
    alter(path, f"PRAGMA user_version = {FILE_FORMAT + 1}")


def truncated(path: Path) -> None:
    with closing(begin(path)) as recording:
        fill(recording)
    path.write_bytes(path.read_bytes()[:20_000])


def in_capitals(path: Path) -> None:
    begin(path).close()
    data = path.read_bytes()
    assert data.count(b" after ") > 1
    path.write_bytes(data.replace(b" after ", b" After "))


STRANGERS: dict[str, tuple[Callable[[Path], object], str]] = {
    "missing": (lambda path: path, "cannot be opened: No such file"),
    "folder": (Path.mkdir, "is a folder"),
    "empty": (Path.touch, "is not a recording: it is empty"),
    "text": (lambda path: path.write_text("depth 80\n" * 500), "is not a recording: file is not a"),
    "database": (foreign, "is not a recording: it is another program's database"),
    "newer": (
        newer,
        rf"of format {FILE_FORMAT + 1}, and this trainer knows format {FILE_FORMAT}; use",
    ),
    "capitals": (in_capitals, "its table .* is not as in a recording"),
    "truncated": (truncated, r"is damaged: .*malformed.*\.recover"),
}


@pytest.mark.parametrize("open_it", [Recording.look, Recording.reopen])
@pytest.mark.parametrize("stranger", STRANGERS)
def test_what_is_no_recording_is_refused_by_name(
    path: Path, open_it: Callable[[Path], Recording], stranger: str
) -> None:
    make, reason = STRANGERS[stranger]
    make(path)
    with pytest.raises(RecordingError, match=f"{re.escape(str(path))} .*{reason}"):
        open_it(path)


@pytest.mark.parametrize("kind", ["file", "link"])
def test_no_file_is_overwritten(path: Path, kind: str) -> None:
    if kind == "file":
        path.write_text("mine")
    else:
        path.symlink_to("nowhere")
    with pytest.raises(RecordingError, match=r"exists already; name another file, or remove it"):
        begin(path)
    assert path.is_symlink() or path.read_text() == "mine"
    assert files(path) == {""}


def test_a_recording_cannot_be_made_in_a_folder_that_is_missing(path: Path) -> None:
    with pytest.raises(RecordingError, match="cannot be made: No such file"):
        begin(path / "sub" / "folder")


def test_a_file_system_without_links_can_hold_a_recording(
    path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def refuse(*_: object) -> None:
        raise PermissionError

    monkeypatch.setattr(os, "link", refuse)
    with closing(begin(path)) as recording:
        assert recording.latest().tick == 0
    assert files(path) == {""}


@pytest.fixture
def read_only() -> Iterator[Path]:
    """Give a folder, and afterwards no right to write to it, not even to the superuser."""
    folder = Path(tempfile.mkdtemp())
    user = os.geteuid()
    yield folder
    os.seteuid(user)
    folder.chmod(0o755)
    shutil.rmtree(folder)


@posix
@pytest.mark.parametrize("make", [left_behind, None])
def test_a_recording_is_read_where_nothing_can_be_written(
    read_only: Path, make: Callable[[Path], None] | None
) -> None:
    path = read_only / "watch.recording"
    if make:
        make(path)
    else:
        with closing(begin(path)) as recording:
            fill(recording)
    held = files(path)
    for each in read_only.iterdir():
        each.chmod(0o444)
    read_only.chmod(0o555)
    if os.geteuid() == 0:
        os.seteuid(65534)

    with closing(Recording.look(path)) as recording:
        check_filled(recording)
    with pytest.raises(RecordingError, match="cannot be written"):
        Recording.reopen(path)
    assert files(path) == held


def test_a_recording_in_which_a_text_is_none_is_told_as_damaged_by_who_goes_on(
    tmp_path: Path,
) -> None:
    path = tmp_path / "watch.recording"
    with closing(begin(path)) as recording:
        fill(recording)
    with closing(sqlite3.connect(path)) as connection:
        connection.execute("PRAGMA writable_schema = ON")
        comment = "CAST(CAST(sql AS BLOB) || x'2d2dff' AS TEXT)"  # of a byte that is no letter
        connection.execute(f"UPDATE sqlite_schema SET sql = {comment} WHERE type = 'table'")
        connection.commit()
    for open_it in (Recording.look, Recording.reopen):
        with pytest.raises(RecordingError, match="is damaged: a text in it is none"):
            open_it(path).close()


@pytest.fixture
def tiny_disk(tmp_path: Path) -> Iterator[Path]:
    """Give the folder of a disk of 800 kB, where this user may mount one."""
    mount = shutil.which("mount")
    words = ["-t", "tmpfs", "-o", "size=800k", "tmpfs", str(tmp_path)]
    if os.name != "posix" or os.geteuid() or not mount or subprocess.call([mount, *words]):
        pytest.skip("no right to mount here")
    yield tmp_path
    subprocess.check_call(["umount", str(tmp_path)])


@pytest.mark.process
@pytest.mark.parametrize("make", [left_behind, None])
def test_a_recording_on_a_full_disk_is_read_whole(
    tiny_disk: Path, make: Callable[[Path], None] | None
) -> None:
    """It was a disk I/O error, though the file was whole."""
    path = tiny_disk / "watch.recording"
    if make:
        make(path)
        Path(f"{path}-shm").unlink(missing_ok=True)  # the machine was started anew
    else:
        with closing(begin(path)) as recording:
            fill(recording)
    log = Path(f"{path}-wal")
    held = path.read_bytes(), log.read_bytes() if log.exists() else b""
    with (tiny_disk / "rest").open("wb", 0) as rest, contextlib.suppress(OSError):
        while rest.write(bytes(4096)):
            pass

    with closing(Recording.look(path)) as recording:
        check_filled(recording)
    with pytest.raises(RecordingError, match="cannot be written: its disk is full"):
        Recording.reopen(path)
    assert (path.read_bytes(), log.read_bytes() if log.exists() else b"") == held


@posix
@pytest.mark.usefixtures("impatient")
def test_a_recording_goes_on_in_a_folder_that_has_become_read_only(read_only: Path) -> None:
    path = read_only / "watch.recording"
    with closing(begin(path)) as recording:
        fly(recording, 1, 10)
        read_only.chmod(0o555)
        if os.geteuid() == 0:
            os.seteuid(65534)
        fly(recording, 11, 400)
        recording.fork(Moment(1, 20, state_of(20), 4, 0), "backtrack")
        assert not recording.trouble
        assert not recording.behind
    assert not recording.trouble
    with closing(Recording.look(path)) as again:
        assert again.latest().branch == 2
        assert [tick for tick, _ in again.states(1)] == list(range(401))


# Size


def test_memory_stays_flat_over_a_long_run(path: Path) -> None:
    pages = Path("/proc/self/statm")
    if not pages.exists():
        pytest.skip("no /proc here")

    def resident() -> int:
        return int(pages.read_text().split()[1]) * 4096

    state = bytes(range(200))
    with closing(begin(path)) as recording:
        for tick in range(1, 10_001):
            recording.state(tick, state)
            recording.timing(tick, 1, 2)
        before = resident()
        for tick in range(10_001, 110_001):
            recording.state(tick, state)
            recording.timing(tick, 1, 2)
        grown = resident() - before

        recording.flush(60.0)
        assert recording.latest().tick == 110_000
    assert grown < 5_000_000  # the states alone are 20,000,000 bytes


# Export


def numbers(state: bytes) -> list[float]:
    """Return two numbers of a state of these tests."""
    return [float(state.split()[1]), 1.0 / 3.0]


LAYOUT = Layout(("depth", "third"), numbers, 0.5)


def branched(path: Path) -> None:
    """Record three ticks, then another course from tick 1 on."""
    with closing(begin(path)) as recording:
        fill(recording)
        recording.fork(Moment(1, 1, state_of(10), 1, 0), "backtrack")
        recording.state(2, state_of(20))
        recording.order(2, HELM, 'port 5, "easy"')


def read_csv(path: Path) -> list[dict[str, str]]:
    with path.open(newline="", encoding="utf-8") as file:
        return list(csv.DictReader(file))


def test_a_branch_is_exported_with_the_past_that_led_to_it(path: Path, tmp_path: Path) -> None:
    branched(path)
    with closing(Recording.look(path)) as recording:
        written = export_csv(recording, LAYOUT, tmp_path / "out.csv")
        assert [each.name for each in written] == ["out.csv", "out.orders.csv", "out.events.csv"]
        states, orders, events = map(read_csv, written)
        export_csv(recording, LAYOUT, tmp_path / "first.csv", branch=1)

    assert [tuple(row.values()) for row in states] == [
        ("1", "0", "0.0", "0.0", "0.3333333333333333", "", ""),
        ("2", "1", "0.5", "10.0", "0.3333333333333333", "", ""),
        ("2", "2", "1.0", "20.0", "0.3333333333333333", "", ""),
    ]
    assert list(states[0]) == [
        *("branch", "tick", "t", "depth", "third", "lateness_ns", "work_ns"),
    ]
    assert [(row["branch"], row["text"]) for row in orders] == [
        ("1", "rudder left 15"),
        ("2", 'port 5, "easy"'),
    ]
    assert [row["accepted"] for row in orders] == ["True", ""]
    assert [(row["t"], row["text"]) for row in events] == [("1.5", "a line, «quoted»")]
    first = read_csv(tmp_path / "first.csv")
    assert [row["work_ns"] for row in first] == ["", "1000", "2000", "3000"]


def test_parquet_has_the_same_rows_with_their_types(
    path: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    parquet = pytest.importorskip("pyarrow.parquet")
    monkeypatch.setattr("trainer.io.tables.BATCH_ROWS", 2)
    branched(path)
    with closing(Recording.look(path)) as recording:
        written = export_parquet(recording, LAYOUT, tmp_path / "out.parquet", branch=1)
    states, orders, events = (parquet.read_table(each).to_pylist() for each in written)

    third = 1.0 / 3.0
    first = {"branch": 1, "tick": 0, "t": 0.0, "depth": 0.0, "third": third}
    last = {"branch": 1, "tick": 3, "t": 1.5, "depth": 3.0, "third": third}
    assert states[0] == {**first, "lateness_ns": None, "work_ns": None}
    assert states[3] == {**last, "lateness_ns": 300, "work_ns": 3000}
    assert len(states) == 4
    assert [(each["place"], each["accepted"]) for each in orders] == [(None, True), (4, False)]
    assert events[0]["who"] == "planes"


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="no /dev/full here")
def test_an_export_to_a_full_disk_says_so(tmp_path: Path) -> None:
    (tmp_path / "out.csv").symlink_to("/dev/full")
    with (
        closing(begin(None)) as recording,
        pytest.raises(RecordingError, match=r"out.csv cannot be written whole: No space left"),
    ):
        export_csv(recording, LAYOUT, tmp_path / "out.csv")


@posix
def test_a_pipe_takes_the_states_alone(tmp_path: Path) -> None:
    heard, told = os.pipe()
    (tmp_path / "out.csv").symlink_to(f"/dev/fd/{told}")
    with closing(begin(None)) as recording:
        assert len(export_csv(recording, LAYOUT, tmp_path / "out.csv")) == 1
    os.close(told)
    with os.fdopen(heard) as lines:
        assert lines.read().startswith("branch,tick,t,depth")
    assert [each.name for each in tmp_path.iterdir()] == ["out.csv"]


def test_an_export_of_a_branch_that_is_not_there_says_which_are(tmp_path: Path) -> None:
    with (
        closing(begin(None)) as recording,
        pytest.raises(RecordingError, match="has no branch 9; the latest is 1"),
    ):
        export_csv(recording, LAYOUT, tmp_path / "out.csv", branch=9)
    with closing(begin(None)) as recording, pytest.raises(RecordingError, match="branch 9"):
        next(recording.flown(9))
    assert list(tmp_path.iterdir()) == []


def test_spoilt_files_are_refused_without_a_traceback(path: Path) -> None:
    dice = random.Random(1)  # noqa: S311
    begin(path).close()
    good = path.read_bytes()
    for _ in range(40):
        spoilt = bytearray(good)
        for _ in range(20):
            spoilt[dice.randrange(len(good))] = dice.randrange(256)
        path.write_bytes(spoilt)
        with contextlib.suppress(RecordingError), closing(Recording.look(path)) as recording:
            list(recording.flown(1))
            recording.header()


# Files of anybody's making


def changed(path: Path, *statements: str) -> None:
    """Change a filled recording by SQL."""
    with closing(begin(path)) as recording:
        fill(recording)
    with closing(sqlite3.connect(path, isolation_level=None)) as connection:
        connection.execute("PRAGMA writable_schema = ON")
        for statement in statements:
            connection.execute(statement)


SELECT = "WITH RECURSIVE n(i) AS (SELECT 1 UNION ALL SELECT i + 1 FROM n) SELECT i, i, i FROM n"
HARM = {
    "trigger": "CREATE TRIGGER t AFTER INSERT ON orders BEGIN DELETE FROM orders; END",
    "view": f"CREATE VIEW more AS {SELECT}",
    "table": "CREATE TABLE more (id)",
    "index": "CREATE INDEX more ON orders (abs(tick))",
    "column": "ALTER TABLE events ADD COLUMN more TEXT GENERATED ALWAYS AS (upper(text)) VIRTUAL",
    "missing": "DROP TABLE snapshots",
    "sql": "UPDATE sqlite_schema SET sql = replace(sql, 'NOT NULL', 'CHECK (1)')",
    "view for a table": (
        "UPDATE sqlite_schema SET type = 'view', rootpage = 0, "
        f"sql = 'CREATE VIEW header AS {SELECT}' WHERE name = 'header'"
    ),
}


@pytest.mark.parametrize("open_it", [Recording.look, Recording.reopen])
@pytest.mark.parametrize("harm", HARM)
def test_a_file_that_holds_more_or_less_than_a_recording_is_refused(
    path: Path, open_it: Callable[[Path], Recording], harm: str
) -> None:
    changed(path, HARM[harm])
    with pytest.raises(RecordingError, match=r"is damaged.*"):
        open_it(path)


HOSTILE = {
    "place before the first": "UPDATE orders SET place = -1",
    "place of no schedule": f"UPDATE orders SET place = {2**63 - 1}",
    "place of a branch": f"UPDATE branches SET place = {2**63 - 1}",
    "place of a snapshot": "UPDATE snapshots SET place = -1",
    "an order far ahead": f"UPDATE orders SET tick = {2**50} WHERE id = 2",
    "an order in the past": "UPDATE branches SET tick = 2",
    "a tick far ahead": f"UPDATE states SET tick = {2**50} WHERE tick = 3",
    "a tick missing": "DELETE FROM states WHERE tick = 2",
    "a negative tick": "UPDATE orders SET tick = -3",
    "a text without end": "UPDATE orders SET answer = printf('%.*c', 20000, 'x')",
    "an acceptance of two": "UPDATE orders SET accepted = 2",
    "no branch": "DELETE FROM branches",
    "a state of a megabyte": "UPDATE states SET state = zeroblob(1000000)",
    "a time of another kind": "UPDATE branches SET tick = 'x'",
    "a state of another kind": "UPDATE states SET state = 'text'",
    "a giver of another kind": "UPDATE orders SET who = x'00'",
    "a header of another kind": "UPDATE header SET value = x'00'",
    "a parent that comes later": "UPDATE branches SET parent = 1",
    "a time beyond all": "UPDATE ledger SET work_ns = -9223372036854775808",
}


@pytest.mark.parametrize("hostile", HOSTILE)
def test_a_value_that_nobody_wrote_is_told_as_damage(path: Path, hostile: str) -> None:
    changed(path, HOSTILE[hostile])
    with pytest.raises(RecordingError, match=r"is damaged|no branch"):
        read_whole(path)


def read_whole(path: Path) -> None:
    """Read all that a recording has."""
    with closing(Recording.look(path)) as looked:
        looked.header()
        for branch in looked.branches():
            looked.orders(branch.id)
            list(looked.flown(branch.id))
            list(looked.states(branch.id))
            list(looked.ledger(branch.id))
        looked.snapshots()
        list(looked.events())
        looked.latest()


def test_what_is_wholly_recorded_is_read_whole(path: Path) -> None:
    changed(path)
    read_whole(path)
    with closing(Recording.look(path)) as looked:
        check_filled(looked)
        assert [(each.tick, each.state, each.lateness, each.work) for each in looked.flown(1)] == [
            (0, state_of(0), None, None),
            *((tick, state_of(tick), 100 * tick, 1000 * tick) for tick in (1, 2, 3)),
        ]


LARGE = {
    "texts": (
        "INSERT INTO header SELECT 'key ' || value, printf('%.*c', 15000000, 'x') "
        "FROM generate_series"
    ),
    "branches": (
        "INSERT INTO branches SELECT 1 + value, 1, 3, 0, 0, 'why', zeroblob(60000), '', 'jump' "
        "FROM generate_series"
    ),
    "orders": (
        "INSERT INTO orders SELECT 2 + value, 1, 3, 'x', printf('%.*c', 9000, 'x'), NULL, 1, '', "
        "'', 'station', '', 0, '', '' FROM generate_series"
    ),
    "snapshots": (
        "INSERT INTO snapshots SELECT 1 + value, 'n' || value, 1, 3, zeroblob(60000), 0, 0, '' "
        "FROM generate_series"
    ),
}
COUNTS = {"texts": 8, "branches": 3000, "orders": 20_000, "snapshots": 3000}


@pytest.mark.long
@pytest.mark.parametrize("what", sample_cases(LARGE, "texts", "branches"))
def test_what_would_fill_the_memory_is_refused(path: Path, what: str) -> None:
    series = "(WITH RECURSIVE n(value) AS (SELECT 1 UNION ALL SELECT value + 1 FROM n LIMIT {}) "
    series = series.format(COUNTS[what]) + "SELECT value FROM n)"
    changed(path, LARGE[what].replace("generate_series", series))
    with pytest.raises(RecordingError, match="more is to be read at once than 100 MB"):
        read_whole(path)


def test_no_cell_of_a_table_is_a_formula(path: Path, tmp_path: Path) -> None:
    said = ["=cmd|' /C calc'!A0", "+1+1", "-2+3", "@SUM(A1)", "\tx", "-5", "+1e3", "depth = 80"]
    with closing(begin(path)) as recording:
        for text in said:
            recording.event(0, "mark", "helm", text)
        layout = Layout(("u",), lambda _: (1.0,), 0.5)
        export_csv(recording, layout, tmp_path / "out.csv")
    with (tmp_path / "out.events.csv").open(newline="") as file:
        cells = [row["text"] for row in csv.DictReader(file)]
    assert cells == [*(f"'{text}" for text in said[:5]), "-5", "+1e3", "depth = 80"]
