"""Faults of what is recorded to: full, gone, damaged in its last page."""

import contextlib
import os
import shutil
import sqlite3
import subprocess
from collections.abc import Iterator
from pathlib import Path
from typing import Final

from soak.audit import same_bits
from soak.session_process import Caller, GoneError

from faults.processes import drive_and_kill, remove
from faults.rig import Bench, Session, Tried, is_journalled, is_logged
from trainer.config.files import ConfigError
from trainer.io.recording.recording import Recording, RecordingError
from trainer.session.stations.roles import ROLES

ROOM: Final = 400_000, 3_000_000  # [bytes] until the disk is full
ORDERS: Final = 12
FULL: Final = ("depth-changes", "--speed", "max", "--duration", "10h")
HELM: Final = ROLES["helm"]  # who cannot lose the boat
PAGE: Final = 8192  # [bytes]
ENDS_A_SWING: Final = "rudder amidships"  # what follows "meet her" of itself


def full(bench: Bench, times: int) -> Tried:
    """Run a recording into the largest size that a file may have."""
    tried = Tried("disk full", "the boat goes on and says so; what was written is whole")
    for _ in range(times):
        path = bench.folder / "full.trainer"
        room = bench.dice.randrange(*ROOM)
        session = bench.serve(path, *FULL, RLIMIT_FSIZE=room)
        _fill_disk(bench, tried, session)
    return tried


def full_disk(bench: Bench, times: int) -> Tried:
    """Record to a small disk that becomes full; needs the right to mount."""
    tried = Tried("disk full, a small file system", "the same")
    for _ in range(times):
        with disk(bench.folder / "small", bench.dice.randrange(*ROOM)) as folder:
            if folder is None:
                tried.note("not tried: no right to mount here")
                return tried
            _fill_disk(bench, tried, bench.serve(folder / "full.trainer", *FULL))
    return tried


def _fill_disk(bench: Bench, tried: Tried, session: Session) -> None:
    """Run a session on a disk that is too small, and look at what is left."""
    tried.times += 1
    with contextlib.suppress(GoneError), session.instructed() as by:
        session.order_some(by, bench.dice, ORDERS, HELM)
        tried.must(is_logged(by, "NOT RECORDED"), "a station is not told")
        by.ask("quit")
    code, told = session.process.wait(), bench.told()
    if not session.path.exists():
        tried.must(code == 2 and "cannot be made" in told, told)
        tried.note("not begun, told why")
        return
    tried.must(code == 1 and "is kept" in told, f"exit code {code}: {told}")
    path = bench.folder / "copy.trainer"
    copy(session.path, path)  # where there is room to look at it
    with contextlib.closing(Recording.look(path)) as recording:
        tried.must(is_kept_to_the_end(recording, session), "not a beginning of what was answered")
        tried.must(same_bits(recording).kept, "not the same bits")
    tried.orders += len(session.answered)
    tried.note("went on unrecorded, told so")
    remove(path)
    remove(session.path)


def lock_recording(bench: Bench, times: int) -> Tried:
    """Lock a recording by another program, and release it."""
    tried = Tried(
        "recording locked by another program",
        "orders act and say that they are not recorded; all are there afterwards",
    )
    for _ in range(times):
        session = bench.serve(bench.folder / "held.trainer", "depth-changes", "--speed", "20")
        with session.instructed() as by:
            session.order_some(by, bench.dice, ORDERS, HELM)
            with contextlib.closing(sqlite3.connect(session.path, isolation_level=None)) as other:
                other.execute("BEGIN EXCLUSIVE")
                session.order_some(by, bench.dice, ORDERS, HELM)
                answer = session.order(by, "course 020")
                tried.must("(not recorded)" in answer, f"an answer does not tell: {answer}")
                other.execute("ROLLBACK")
            _come_back(bench, tried, session, by)
    return tried


def relieve_disk(bench: Bench, times: int) -> Tried:
    """Fill a small disk, and make room again; needs the right to mount."""
    tried = Tried("disk full, then room again", "the same")
    for _ in range(times):
        with disk(bench.folder / "small", 6_000_000) as folder:
            if folder is None:
                tried.note("not tried: no right to mount here")
                return tried
            session = bench.serve(folder / "held.trainer", "depth-changes", "--speed", "20")
            with session.instructed() as by:
                session.order_some(by, bench.dice, ORDERS, HELM)
                ballast = folder / "ballast"
                with contextlib.suppress(OSError), ballast.open("wb", buffering=0) as file:
                    while file.write(bytes(4096)):
                        pass
                tried.must(is_logged(by, "NOT RECORDED"), "a station is not told")
                session.order_some(by, bench.dice, ORDERS, HELM)
                ballast.unlink()
                _come_back(bench, tried, session, by)
    return tried


def _come_back(bench: Bench, tried: Tried, session: Session, by: Caller) -> None:
    """See that a recording that was out of reach is whole in the end."""
    tried.times += 1
    tried.must(is_logged(by, "recorded again"), "a station is not told that it is back")
    session.order_some(by, bench.dice, ORDERS, HELM)
    by.ask("quit")
    code, told = session.process.wait(), bench.told()
    tried.must(code == 0 and "and is whole" in told, f"exit code {code}: {told[-200:]}")
    with contextlib.closing(Recording.look(session.path)) as recording:
        tried.must(is_journalled(recording, session).kept, "an order is lost")
        tried.must(same_bits(recording).kept, "not the same bits")
    tried.orders += len(session.answered)
    tried.note("whole")
    remove(session.path)


def is_kept_to_the_end(recording: Recording, session: Session) -> bool:
    """Return whether the file has what was answered, until the disk was full."""
    orders = recording.orders(recording.branch)
    written = [order.text for order in orders if order.entry is None and order.accepted]
    wanted = [order.text for order in session.answered if not order.mark]
    rest = iter(wanted)
    return all(text in rest for text in written if text != ENDS_A_SWING)


def take_disk_away(bench: Bench, times: int) -> Tried:
    """Take the disk away under a recording; needs the right to mount."""
    tried = Tried(
        "recording on a vanished mount", "the boat goes on and says so; the disk is whole"
    )
    for _ in range(times):
        with disk(bench.folder / "mount", 50_000_000) as folder:
            if folder is None:
                tried.note("not tried: no right to mount here")
                return tried
            aside = bench.folder / "aside"
            aside.mkdir(exist_ok=True)
            _mount("--bind", str(folder), str(aside))
            try:
                _unmount_under(bench, tried, folder, aside)
            finally:
                _unmount(aside)
    return tried


def _unmount_under(bench: Bench, tried: Tried, folder: Path, aside: Path) -> None:
    """Unmount a folder while a session records there; what was written is looked at aside."""
    tried.times += 1
    session = bench.serve(folder / "gone.trainer", "depth-changes", "--speed", "20")
    with session.instructed() as by:
        session.order_some(by, bench.dice, ORDERS, HELM)
        answered = list(session.answered)
        _unmount(folder)
        tried.must(by.ask("course 020")[0], "an order is refused afterwards")
        tried.must(is_logged(by, "not there any more"), "a station is not told")
        by.ask("quit")
    tried.must(session.process.wait() == 1, "its end does not tell")
    tried.must("not there any more" in bench.told(), "its account does not tell")
    session.answered = answered
    tried.orders += len(answered)
    with contextlib.closing(Recording.look(aside / "gone.trainer")) as recording:
        tried.must(is_journalled(recording, session).kept, "an order is lost")
        tried.must(same_bits(recording).kept, "not the same bits")
    tried.note("went on, told so, disk whole")


def damage_last_page(bench: Bench, times: int) -> Tried:
    """Damage the last page of recordings of sessions that were killed."""
    tried = Tried("last page damaged", "nothing wrong is read as right")
    path, whole = bench.folder / "page.trainer", bench.folder / "whole.trainer"
    # of no exercise: what judges one outlives the kill, and brings home what is written ahead
    session = bench.serve(whole, "--speed", "20")
    drive_and_kill(bench, session)
    session.process.wait()
    copy(whole, path)  # to look at one brings home what is written ahead
    written = journal_of(path) or []
    tried.must(written, "the whole recording cannot be read")
    for number in range(times):
        tried.times += 1
        copy(whole, path)
        spoil(bench, path if number % 2 else path.with_name(f"{path.name}-wal"))
        _judge(tried, path, written)
        remove(path)
    tried.orders = len(written)
    remove(whole)
    return tried


def copy(whole: Path, path: Path) -> None:
    """Copy a recording and what lies beside it over another."""
    remove(path)
    for each in whole.parent.glob(f"{whole.name}*"):
        shutil.copyfile(each, path.with_name(each.name.replace(whole.name, path.name)))


def spoil(bench: Bench, path: Path) -> None:
    """Overwrite bytes of the last page, or cut it off."""
    data = bytearray(path.read_bytes())
    last = max(len(data) - PAGE, 0)
    if bench.dice.random() < 0.3:
        del data[bench.dice.randrange(last, len(data)) :]
    for _ in range(bench.dice.randrange(1, 40)):
        data[bench.dice.randrange(min(last, len(data) - 1), len(data))] = bench.dice.randrange(256)
    path.write_bytes(data)


def journal_of(path: Path) -> list[str] | None:
    """Return the orders of a recording, None if it says that it is damaged."""
    try:
        with contextlib.closing(Recording.look(path)) as recording:
            return [f"{order.tick} {order.text}" for order in recording.orders(1)]
    except RecordingError:
        return None


def _judge(tried: Tried, path: Path, written: list[str]) -> None:
    """Look at a damaged recording: told as damaged, whole, or found out by flying it again."""
    found = journal_of(path)
    if found is None:
        tried.note("told as damaged")
        return
    try:
        with contextlib.closing(Recording.look(path)) as recording:
            same = same_bits(recording).kept
    except (RecordingError, ConfigError):  # the file's own, or what its header says
        tried.note("told as damaged")
        return
    if found == written[: len(found)] and same:
        tried.note("whole, or without its last commits")
        return
    tried.must(not same, "a journal that was not written, and the same bits")
    tried.note("found out by flying it again")


@contextlib.contextmanager
def disk(folder: Path, size: int) -> Iterator[Path | None]:
    """Yield a file system of so many bytes at a folder. None: no right to mount."""
    folder.mkdir(exist_ok=True)
    if os.geteuid() or not _mount("-t", "tmpfs", "-o", f"size={size}", "tmpfs", str(folder)):
        yield None
        return
    try:
        yield folder
    finally:
        _unmount(folder)


def _mount(*words: str) -> bool:
    return subprocess.run(["mount", *words], capture_output=True, check=False).returncode == 0


def _unmount(folder: Path) -> None:
    subprocess.run(["umount", "-l", str(folder)], capture_output=True, check=False)
