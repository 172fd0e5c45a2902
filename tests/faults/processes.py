"""Faults of programs: killed at any instant, stopped, their console killed, the clock set."""

import contextlib
import itertools
import os
import shutil
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Iterator
from datetime import datetime
from pathlib import Path
from typing import Final

from soak.audit import same_bits
from soak.session_process import GoneError

from faults.rig import Bench, Session, Tried, is_journalled, is_told
from trainer.io.recording.recording import Recording

EXERCISE: Final = ("depth-changes", "--speed", "100")
WITHIN: Final = 0.15  # [s] of the first orders, a kill comes
EVERY: Final = 10  # kills: then the run is gone on with and flown again as well
STOPPED: Final = 0.3, 1.0  # [s]
GAP: Final = "the process was not running for"
HOUR: Final = 3600.0  # [s]
STEPPED: Final = """
#define _GNU_SOURCE
#include <time.h>
#include <sys/syscall.h>
#include <unistd.h>
/* The time of day, set by hours twice a second; all other clocks are as they are. */
int clock_gettime(clockid_t id, struct timespec *t) {
    long done = syscall(SYS_clock_gettime, id, t);
    if (done == 0 && id == CLOCK_REALTIME) {
        long half = 2 * t->tv_sec + (t->tv_nsec >= 500000000);
        t->tv_sec += 3600 * ((half * 7919) % 13 - 6);
    }
    return (int)done;
}
"""


def kill_sessions(bench: Bench, times: int) -> Tried:
    """Kill sessions that are given orders."""
    tried = Tried("kill -9 at a random instant", "no answered order is lost; the run can go on")
    for _ in range(times):
        tried.times += 1
        path = bench.folder / "killed.trainer"
        session = bench.serve(path, *EXERCISE)
        drive_and_kill(bench, session)
        session.process.wait()
        tried.orders += len(session.answered)
        with contextlib.closing(Recording.look(path)) as recording:
            check = is_journalled(recording, session)
            tried.must(check.kept, check.seen)
        if tried.times % EVERY == 0:
            tried.must(resumes(bench, path), f"cannot be gone on with: {bench.told()}")
            tried.note("gone on with, the same bits")
        bench.told()
        remove(path)
    return tried


def drive_and_kill(bench: Bench, session: Session) -> None:
    """Give orders as fast as they are answered, and kill the session among them."""
    with contextlib.suppress(GoneError), session.instructed() as by:
        session.order_some(by, bench.dice, bench.dice.randrange(1, 4))
        # in a process of its own: it does not wait for our orders
        killer = subprocess.Popen(
            [
                "/bin/sh",
                "-c",
                f"sleep {bench.dice.uniform(0.0, WITHIN):.4f}; kill -9 {session.process.pid}",
            ]
        )
        try:
            while True:
                session.order_some(by, bench.dice, 1)
        finally:
            killer.wait()


def resumes(bench: Bench, path: Path) -> bool:
    """Return whether a killed run goes on, and flies again to the same bits."""
    with contextlib.closing(Recording.look(path)) as recording:
        seconds = recording.latest().tick // 2 + 20
    words = ("--headless", "--speed", "max", "--duration", str(seconds), "--anyway")
    if bench.run("resume", str(path), *words) not in (0, 1):  # 1: the boat was lost, and says so
        return False
    with contextlib.closing(Recording.look(path)) as recording:
        return same_bits(recording).kept


def stop_session(bench: Bench, times: int) -> Tried:
    """Stop a session's process for a while, again and again."""
    tried = Tried("SIGSTOP, then SIGCONT", "the gap is told, no burst follows, orders go on")
    path = bench.folder / "stopped.trainer"
    session = bench.serve(path, "depth-changes", "--speed", "10")
    with session.instructed() as by:
        for _ in range(times):
            tried.times += 1
            session.process.send_signal(signal.SIGSTOP)
            time.sleep(bench.dice.uniform(*STOPPED))
            session.process.send_signal(signal.SIGCONT)
            tried.must(
                "by hand" in session.order(by, "rudder left 5"),
                "an order is refused afterwards",
            )
            time.sleep(0.1)  # some ticks
        by.ask("quit")
    tried.must(session.process.wait() == 0, bench.told())
    tried.orders = len(session.answered)
    with contextlib.closing(Recording.look(path)) as recording:
        told = sum(GAP in event.text for event in recording.events())
        tried.must(told == times, f"{told} gaps told of {times}")
        tried.must(same_bits(recording).kept, "not the same bits")
        tried.must(is_journalled(recording, session).kept, "an order is lost")
    tried.seen["gaps told"] = told
    remove(path)
    return tried


def console_killed(bench: Bench, times: int) -> Tried:
    """Kill the screen of a station while its session runs."""
    tried = Tried("console killed", "the session goes on, and tells that the station has gone")
    path = bench.folder / "console.trainer"
    session = bench.serve(path, "depth-changes", "--speed", "10")
    with session.instructed() as by:
        for _ in range(times):
            tried.times += 1
            with screen(session.door) as console:
                tried.must(is_told(by, "now has the helm"), "the screen did not come")
                console.kill()
            tried.must(is_told(by, ": gone"), "its going is not told")
            tried.must(
                "by hand" in session.order(by, "rudder left 5"),
                "an order is refused afterwards",
            )
        by.ask("quit")
    tried.must(session.process.wait() == 0, bench.told())
    tried.orders = len(session.answered)
    with contextlib.closing(Recording.look(path)) as recording:
        tried.must(is_journalled(recording, session).kept, "an order is lost")
        tried.must(same_bits(recording).kept, "not the same bits")
    remove(path)
    return tried


@contextlib.contextmanager
def screen(door: Path) -> Iterator["subprocess.Popen[bytes]"]:
    """Yield the screen of the helm, on a terminal of its own."""
    ours, theirs = os.openpty()
    command = [sys.executable, "-m", "trainer", "station", "helm", "--connect", str(door)]
    try:
        with subprocess.Popen(
            command, stdin=theirs, stdout=theirs, stderr=theirs, start_new_session=True
        ) as console:
            drain = threading.Thread(target=swallow, args=(ours,), daemon=True)
            drain.start()
            yield console
            console.wait()
        os.close(theirs)
        drain.join()
    finally:
        os.close(ours)


def swallow(terminal: int) -> None:
    """Read a terminal to its end, so that nobody waits for it."""
    with contextlib.suppress(OSError):
        while os.read(terminal, 65536):
            pass


def clock_set(bench: Bench, times: int) -> Tried:
    """Set the time back and forward by hours, twice a second, during a session."""
    tried = Tried("clock set by hours", "no tick is missed or made twice, orders go on")
    shim = build_clock(bench.folder)
    if shim is None:
        tried.note("not tried: no C compiler here")
        return tried
    path, door = bench.folder / "clock.trainer", bench.folder / "clock.sock"
    paced = ("serve", "depth-changes", "--speed", "10", "--verbose")
    words = (*paced, "--listen", "none", "--socket", str(door))
    with subprocess.Popen(
        [sys.executable, "-m", "trainer", *words, "--record", str(path)],
        env=os.environ | {"LD_PRELOAD": str(shim)},
        stdout=subprocess.PIPE,
        stderr=subprocess.DEVNULL,
        text=True,
    ) as process:
        session = Session(process, path, door)
        with session.instructed() as by:
            for _ in range(times):
                tried.times += 1
                time.sleep(0.5)  # the time of day leaps twice a second
                tried.must(
                    "by hand" in session.order(by, "rudder left 5"),
                    "an order is refused",
                )
            by.ask("quit")
        account = process.communicate()[0]
    tried.must(process.returncode == 0 and "slipped 0, gaps 0" in account, account)
    tried.orders = len(session.answered)
    with contextlib.closing(Recording.look(path)) as recording:
        walls = [datetime.fromisoformat(event.wall) for event in recording.events()]
        jumps = [(b - a).total_seconds() for a, b in itertools.pairwise(walls)]
        tried.seen["times of day that went back"] = sum(jump < -HOUR for jump in jumps)
        tried.must(any(abs(jump) > HOUR for jump in jumps), "the clock was not set at all")
        tried.must(is_journalled(recording, session).kept, "an order is lost")
        tried.must(same_bits(recording).kept, "not the same bits")
    remove(path)
    return tried


def build_clock(folder: Path) -> Path | None:
    """Return a library that, loaded first, sets the time of day. None without a C compiler."""
    compiler = shutil.which("cc")
    if compiler is None:
        return None
    source, made = folder / "clock.c", folder / "clock.so"
    source.write_text(STEPPED, encoding="ascii")
    subprocess.run([compiler, "-shared", "-fPIC", "-O1", "-o", str(made), str(source)], check=True)
    return made


def remove(path: Path) -> None:
    """Remove a recording and what lies beside it."""
    for each in path.parent.glob(f"{path.name}*"):
        each.unlink(missing_ok=True)  # a judge that outlives a kill brings it home
