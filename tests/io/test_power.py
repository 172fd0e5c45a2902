"""What was ordered outlives lost power: the disk is asked for it, and nobody waits for that."""

import contextlib
import errno
import json
import os
import random
import shutil
import signal
import sqlite3
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path

import pytest
from helpers.altered import is_whole
from helpers.crewed import Crewed
from helpers.givers import HELM
from helpers.installation import run_program
from helpers.waiting import PATIENCE, eventually

from trainer.io.recording import durability
from trainer.io.recording import recording as recording_module
from trainer.io.recording.recording import Moment, Recording
from trainer.session.stations.event_log import SAFE_TEXT, UNSAFE_TEXT

LAYER = Path(__file__).parents[1] / "helpers" / "synced_alone.c"
COMPILER = shutil.which("cc") or shutil.which("gcc")
CUTS = 8  # of the power
CUTS_OF_ONE = 20  # of one machine, whose recording grows meanwhile
SECTOR = 512  # [bytes] that a disk writes whole
STATE = b"state ".ljust(1944, b".")

# Orders, marks, snapshots and branches at random, each printed once it was answered: what the
# recording then says of the disk stands beside it.
FLOWN = """
import json, random, sys, time
from pathlib import Path
from trainer.io.recording import checkpoint
from trainer.io.recording.format_1 import giver_of
from trainer.io.recording.recording import Moment, Recording
from trainer.session.stations.event_log import SAFE_TEXT, UNSAFE_TEXT

HELM = giver_of("helm")
checkpoint.MIN_CHECKPOINT_BYTES = 1_500_000  # [bytes]: the log is brought home now and then
dice = random.Random(int(sys.argv[2]))
recording = Recording.create(Path(sys.argv[1]), {"vessel": "x" * 50_000}, b"begun")
tick = after = 0
for number in range(10**6):
    tick += 1
    recording.state(tick, f"state {tick} ".encode().ljust(1944, b"."))
    recording.timing(tick, 1, 2)
    act = dice.choices(["fly", "order", "mark", "keep", "fork"], [60, 30, 5, 5, 1])[0]
    name = f"{act} {number}"
    if act == "order":
        after = recording.order(tick, HELM, name)
        recording.answered(after, name, True)
    elif act == "mark":
        recording.event(tick, "mark", "helm", name)
        recording.flush()
    elif act == "keep":
        recording.snapshot(name, Moment(recording.branch, tick, b"kept", after, 0))
    elif act == "fork":
        recording.fork(Moment(recording.branch, tick, b"forked", after, 0), name)
    promised = "fly" if recording.trouble else name  # else it was answered: not recorded
    print(json.dumps([time.monotonic(), promised, recording.behind]), flush=True)
    time.sleep(0.01)
"""


@dataclass(frozen=True)
class Answer:
    """Something that was answered, and what was known of the disk at that time."""

    at: float  # [s]
    name: str
    behind: str


def begin(path: Path) -> Recording:
    return Recording.create(path, {"vessel": "text"}, STATE)


# The disk that has only what it was asked to keep


class Machine:
    """A process that records, whose power can be cut: what was not synced is then gone."""

    def __init__(self, folder: Path, layer: Path, seed: int) -> None:
        self.live, self.disk = folder / "live", folder / "disk"
        self.live.mkdir()
        self.disk.mkdir()
        self.path = self.live / "watch.trainer"
        self._printed = folder / "printed"
        with self._printed.open("w") as printed:
            self.process = subprocess.Popen(
                [sys.executable, "-c", FLOWN, str(self.path), str(seed)],
                stdout=printed,
                env=os.environ
                | {"LD_PRELOAD": str(layer), "SYNCED_OF": str(self.live)}
                | {"SYNCED_TO": str(self.disk), "PYTHONPATH": os.pathsep.join(sys.path)},
            )

    def end(self) -> None:
        """Kill it."""
        self.process.send_signal(signal.SIGCONT)
        self.process.kill()
        self.process.wait()

    def answers(self) -> list[Answer]:
        """Return all that was answered so far."""
        lines = self._printed.read_text().splitlines(keepends=True)
        return [Answer(*json.loads(line)) for line in lines if line.endswith("\n")]

    @contextlib.contextmanager
    def stopped(self) -> Iterator[None]:
        """Let it stand still: so it is when the power goes."""
        assert self.process.poll() is None
        self.process.send_signal(signal.SIGSTOP)
        os.waitid(os.P_PID, self.process.pid, os.WSTOPPED)
        yield
        self.process.send_signal(signal.SIGCONT)

    def synced(self) -> dict[str, bytes]:
        """Return the files of the disk by their names, with what they hold."""
        folder = self.disk / key_of(self.live)
        names = (line.split(maxsplit=1) for line in folder.read_text().splitlines())
        kept = {name: self.disk / key for key, name in names}
        return {name: file.read_bytes() if file.exists() else b"" for name, file in kept.items()}

    def cached(self) -> dict[str, bytes]:
        """Return the files as programs see them while there is power."""
        return {file.name: file.read_bytes() for file in self.live.iterdir() if file.is_file()}


def key_of(path: Path) -> str:
    """Return the name under which the layer keeps a file or folder."""
    said = run_program(["stat", "-c", "%i %W %w", path]).stdout.split()
    return f"{said[0]}-{said[1]}.{int(said[3].partition('.')[2])}"


@pytest.fixture(scope="module")
def layer(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Compile the layer."""
    if COMPILER is None or sys.platform != "linux":
        pytest.skip("a C compiler, and Linux")
    made = tmp_path_factory.mktemp("layer") / "synced_alone.so"
    subprocess.run([COMPILER, "-shared", "-fPIC", "-O1", "-o", made, LAYER], check=True)
    return made


# What a disk may have of what was written since it was last asked


def dropped(synced: bytes, _cached: bytes, _dice: random.Random) -> bytes:
    """Return what was synced."""
    return synced


def cut(synced: bytes, cached: bytes, dice: random.Random) -> bytes:
    """Return what was synced, and of what was appended since a part."""
    if not cached.startswith(synced):  # the log was begun anew
        return mixed(synced, cached, dice)
    return cached[: dice.randint(len(synced), len(cached))]


def mixed(synced: bytes, cached: bytes, dice: random.Random) -> bytes:
    """Return what was synced with some of the sectors written since; some are noise."""
    length = dice.choice((len(synced), len(cached)))
    made = bytearray(length)
    for at in range(0, length, SECTOR):
        old, new = synced[at : at + SECTOR], cached[at : at + SECTOR]
        some = dice.choice((old, new, dice.randbytes(SECTOR))) if old != new else old
        made[at : at + SECTOR] = some.ljust(SECTOR, b"\0")[: min(SECTOR, length - at)]
    return bytes(made)


def unnoisy(synced: bytes, cached: bytes, dice: random.Random) -> bytes:
    """Return what was synced with some of the sectors written since."""
    length = max(len(synced), len(cached))
    made = bytearray(synced.ljust(length, b"\0"))
    for at in range(0, len(cached), SECTOR):
        if dice.random() < 0.5:
            made[at : at + SECTOR] = cached[at : at + SECTOR]
    return bytes(made)


SPOILT = {"dropped": dropped, "cut": cut, "garbled": mixed}


def restore(
    folder: Path, synced: dict[str, bytes], cached: dict[str, bytes], way: str, seed: int
) -> Path:
    """Make the folder as it is found once there is power again; return the recording."""
    folder.mkdir()
    dice = random.Random(seed)  # noqa: S311
    for name, kept in synced.items():
        spoil = (
            dropped if way == "dropped" else unnoisy if name.endswith(".trainer") else SPOILT[way]
        )
        if not name.endswith("-shm"):  # made anew by who opens it first
            (folder / name).write_bytes(spoil(kept, cached.get(name, b""), dice))
    return folder / "watch.trainer"


def check_kept(path: Path, answers: list[Answer]) -> None:
    """Check that a restored recording is whole, and lacks nothing that is older than a second."""
    known = names_in(path)
    every = [each.name for each in answers if not each.name.startswith("fly")]
    now = answers[-1]
    due = {each.name for each in answers if each.at < now.at - recording_module.SAFE_WITHIN_S}
    lacking = [name for name in every if name in due and name not in known]
    assert not lacking or now.behind, (lacking, len(every))


def names_in(path: Path) -> set[str]:
    """Return what a recording has of what was answered; what is there follows without a gap."""
    with contextlib.closing(Recording.reopen(path)) as again:
        branches = again.branches()
        orders = [each for branch in branches for each in again.orders(branch.id, branch.after)]
        marks = [each.text for each in again.events()]
        kept = [name for name, _ in again.snapshots()]
        list(again.flown(again.branch))
        again.latest()
    numbers = [each.id for each in orders]
    assert sorted(set(numbers)) == list(range(1, max(numbers, default=0) + 1))
    assert is_whole(path)
    return {*(each.text for each in orders), *marks, *kept, *(each.why for each in branches)}


def cut_often(folder: Path, layer: Path, cuts: int, seed: int) -> None:
    """Cut the power of a machine at random moments, and look at what its disk has."""
    dice = random.Random(seed)  # noqa: S311
    machine = Machine(folder, layer, seed)
    try:
        assert eventually(lambda: len(machine.answers()) > 1)
        for number in range(cuts):
            time.sleep(dice.uniform(0.2, 0.7) if number else 1.5)  # any instant
            with machine.stopped():
                answers, synced, cached = machine.answers(), machine.synced(), machine.cached()
            for way in SPOILT:
                found = restore(folder / f"{number}-{way}", synced, cached, way, number)
                check_kept(found, answers)
                shutil.rmtree(found.parent)
    finally:
        machine.end()


@pytest.mark.process
def test_lost_power_takes_nothing_that_is_older_than_a_second(tmp_path: Path, layer: Path) -> None:
    cut_often(tmp_path, layer, CUTS, seed=1)


@pytest.mark.process
def test_a_recording_that_is_begun_is_on_the_disk_with_its_header(
    tmp_path: Path, layer: Path
) -> None:
    machine = Machine(tmp_path, layer, seed=3)
    try:
        assert eventually(lambda: machine.path.exists() and machine.answers())
        with machine.stopped():
            found = restore(tmp_path / "again", machine.synced(), machine.cached(), "dropped", 0)
    finally:
        machine.end()
    with contextlib.closing(Recording.look(found)) as recording:
        assert recording.header()["vessel"] == "x" * 50_000


@pytest.mark.process
@pytest.mark.slow
def test_power_lost_many_times_takes_nothing_that_is_older_than_a_second(
    tmp_path: Path, layer: Path
) -> None:
    for seed in range(int(os.environ.get("TRAINER_CUTS", "200")) // CUTS_OF_ONE):
        folder = tmp_path / str(seed)
        folder.mkdir()
        cut_often(folder, layer, CUTS_OF_ONE, seed)


# A disk that is slow, and one that refuses


class Disk:
    """What the thread that syncs meets: a disk that answers once it is let."""

    def __init__(self) -> None:
        self.free = threading.Event()
        self.free.set()
        self.refusal: OSError | None = None
        self.asked = 0

    def fsync(self, _descriptor: int) -> None:
        self.asked += 1
        assert self.free.wait(PATIENCE)
        if self.refusal:
            raise self.refusal


@pytest.fixture
def disk(monkeypatch: pytest.MonkeyPatch) -> Disk:
    disk = Disk()
    monkeypatch.setattr(os, "fsync", disk.fsync)
    monkeypatch.setattr(durability, "QUIET_S", 1.0)
    return disk


def test_a_disk_that_does_not_answer_holds_no_order_up_and_is_behind(
    tmp_path: Path, disk: Disk
) -> None:
    with contextlib.closing(begin(tmp_path / "watch.trainer")) as recording:
        disk.free.clear()
        for tick in range(1, 20):
            recording.state(tick, STATE)
            recording.order(tick, HELM, f"order {tick}")
        assert eventually(lambda: recording.behind)
        assert recording.behind == "it is slow"
        recording.order(20, HELM, "as ever")  # though the disk is still at it
        assert not recording.trouble
        disk.free.set()
        assert eventually(lambda: not recording.behind)


def test_a_process_that_was_stopped_says_nothing_of_the_disk(
    tmp_path: Path, disk: Disk, monkeypatch: pytest.MonkeyPatch
) -> None:
    assert disk.free.is_set()
    clock = Clock()
    monkeypatch.setattr(durability, "time", clock)
    with contextlib.closing(begin(tmp_path / "watch.trainer")) as recording:
        recording.order(1, HELM, "depth 80")
        asked = disk.asked
        clock.stopped = 60.0  # [s] before the thread that asks the disk had its turn
        assert not recording.behind
        assert eventually(lambda: disk.asked > asked)
        assert not recording.behind


class Clock:
    """The clock of a process that was stopped for a while."""

    stopped = 0.0

    def monotonic(self) -> float:
        return time.monotonic() + self.stopped


def mark(recording: Recording) -> None:
    """Mark a moment, as a session does."""
    recording.event(1, "mark", "helm", "here")
    recording.flush()


HERE = Moment(1, 1, STATE, 0, 0)
PROMISES: dict[str, Callable[[Recording], object]] = {
    "order": lambda recording: recording.order(1, HELM, "dive"),
    "mark": mark,
    "snapshot": lambda recording: recording.snapshot("here", HERE),
    "branch": lambda recording: recording.fork(HERE, "backtrack"),
}


@pytest.mark.parametrize("promise", PROMISES.values(), ids=PROMISES)
def test_the_disk_is_asked_for_what_was_answered_and_not_at_once_for_ticks(
    tmp_path: Path,
    disk: Disk,
    monkeypatch: pytest.MonkeyPatch,
    promise: Callable[[Recording], object],
) -> None:
    monkeypatch.setattr(recording_module, "FLOWN_WITHIN_S", 1e6)
    with contextlib.closing(begin(tmp_path / "watch.trainer")) as recording:
        asked = disk.asked
        recording.state(1, STATE)
        recording.event(1, "trouble", "", "something was late")
        recording.flush()
        time.sleep(10 * durability.SYNC_PERIOD_S)  # in which the disk would be asked
        assert disk.asked == asked
        promise(recording)
        assert eventually(lambda: disk.asked > asked)


def test_what_a_killed_program_left_unasked_is_brought_onto_the_disk_by_the_next(
    tmp_path: Path, disk: Disk
) -> None:
    killed, path = tmp_path / "killed.trainer", tmp_path / "watch.trainer"
    with contextlib.closing(begin(killed)) as recording:
        recording.order(1, HELM, "dive")
        for ending in ("", "-wal"):  # as a kill leaves them
            shutil.copy(f"{killed}{ending}", f"{path}{ending}")
    disk.asked = 0

    with contextlib.closing(Recording.reopen(path)) as again:
        assert [each.text for each in again.orders(1)] == ["dive"]
        assert eventually(lambda: disk.asked)
        assert not again.behind


def test_what_a_disk_refused_is_safe_only_once_it_was_brought_home(
    tmp_path: Path, disk: Disk
) -> None:
    path = tmp_path / "watch.trainer"
    refused = os.strerror(errno.EIO)
    with contextlib.closing(begin(path)) as recording:
        other = sqlite3.connect(path, isolation_level=None)
        other.execute("BEGIN")
        other.execute("SELECT count(*) FROM orders").fetchall()  # who looks back keeps it away
        disk.refusal = OSError(errno.EIO, refused)
        recording.order(1, HELM, "dive")
        assert eventually(lambda: recording.behind == refused)
        disk.refusal, asked = None, disk.asked
        recording.order(2, HELM, "dive again")
        assert eventually(lambda: disk.asked > asked)
        time.sleep(2 * durability.QUIET_S)
        assert recording.behind == refused  # what is granted now proves nothing
        other.close()
        assert eventually(lambda: not recording.behind)


def test_a_disk_that_is_behind_is_told_once_and_its_end_too_though_time_is_frozen(
    tmp_path: Path, disk: Disk
) -> None:
    ship = Crewed(tmp_path / "watch.trainer")

    def news() -> list[str]:
        """Return what was told of trouble; the session listens if it is woken, as its loop does."""
        if ship.wake.wait(0.01):
            ship.wake.clear()
            ship.session.attendance.listen()
        return ship.events(ship.instructor, "trouble")

    with contextlib.closing(ship.recording):
        ship.say(ship.instructor, "subscribe events")
        disk.free.clear()
        ship.order("depth 70")
        assert eventually(news)
        ship.order("depth 71")
        disk.free.set()
        assert eventually(lambda: len(news()) > 1)
        time.sleep(2 * durability.QUIET_S)  # there is no more of it
        assert news() == [
            f"THE DISK IS BEHIND: it is slow; {UNSAFE_TEXT}",
            f"the disk has caught up: {SAFE_TEXT}",
        ]


def test_without_descriptors_left_a_recording_is_written_and_safe(
    tmp_path: Path, disk: Disk
) -> None:
    resource = pytest.importorskip("resource")
    before = resource.getrlimit(resource.RLIMIT_NOFILE)
    recording = begin(tmp_path / "watch.trainer")
    with contextlib.closing(recording):
        assert recording.order(1, HELM, "the first") == 1
        assert eventually(lambda: disk.asked)
        asked = disk.asked
        resource.setrlimit(resource.RLIMIT_NOFILE, (3, before[1]))
        try:
            for tick in range(1, 50):
                recording.state(tick, STATE)
                recording.order(tick, HELM, f"order {tick}")
            recording.snapshot("here", Moment(1, 20, STATE, 21, 0))
            recording.fork(Moment(1, 20, STATE, 21, 0), "backtrack")
            assert eventually(lambda: disk.asked > asked)
            assert len(recording.orders(1)) == 50
            assert not recording.trouble
            assert eventually(lambda: not recording.behind)  # the file is open: nothing is refused
        finally:
            resource.setrlimit(resource.RLIMIT_NOFILE, before)


def test_a_recording_begun_without_descriptors_for_its_thread_is_behind_until_there_are_some(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def refuse(_path: Path) -> int:
        raise OSError(errno.EMFILE, os.strerror(errno.EMFILE))

    monkeypatch.setattr(durability, "QUIET_S", 0.0)
    opens = durability._open  # noqa: SLF001  where the system has its say
    monkeypatch.setattr(durability, "_open", refuse)
    with contextlib.closing(begin(tmp_path / "watch.trainer")) as recording:
        recording.order(1, HELM, "dive")
        assert recording.behind == os.strerror(errno.EMFILE)
        monkeypatch.setattr(durability, "_open", opens)
        assert eventually(lambda: not recording.behind)
