"""The command ``trainer run``: everything joined, started, and accounted for at the end."""

import contextlib
import gc
import math
import os
import signal
import sys
import threading
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import click
import numpy as np

from trainer import casualty, machine_code_is_compiled
from trainer.boat import Boat
from trainer.clock import MonotonicClock, Policy
from trainer.config import ConfigError
from trainer.console import Console
from trainer.fitout import KNOT
from trainer.io.csv_file import COLUMNS, CsvFile, NoFile
from trainer.io.outbox import Direct, Inbox, Outbox, reader, writer
from trainer.io.serial_line import LinkError, SerialLine
from trainer.io.teletype import course
from trainer.ledger import SECOND, Summary
from trainer.plan import Plan, plan_run
from trainer.session import Session, Timekeeping
from trainer.watch import Limits, Watch

BATCH = 200  # [rows] of a recording written at once by a run that keeps no time
PATIENCE = 0.5  # [s] for ports at the end, and for a pipe at the start
SECONDS_1969 = "1969: 38 % at 0.5 s, 19 % at 1 s"


def run_boat(options: dict[str, Any]) -> int:
    """Run as the command line's ``options`` say; return the exit code."""
    plan = plan_run(options)
    method = plan.method
    boat = Boat(plan.file, method)
    warm(boat)
    if not options["unsafe_step"]:
        refuse_unstable(boat)
    plan.start(boat)
    watch = Watch.over(boat, plan.limits)
    recorder = open_csv(options["csv_path"], 1 if math.isfinite(options["speed"]) else BATCH)
    last_tick = math.inf if plan.duration is None else round(plan.duration / method.step)
    time = Timekeeping.at(
        MonotonicClock(), method.step, options["speed"], Policy(options["overrun"])
    )
    wake = threading.Event()
    with contextlib.ExitStack() as ports:
        consoles = open_consoles(options, wake, ports)
        session = Session(
            boat,
            time,
            recorder,
            consoles,
            COLUMNS,
            plan.schedule,
            watch,
            last_tick=last_tick,
            wake=wake,
        )
        if options["headless"]:
            session.progress = ports.enter_context(progress_bar(last_tick))
        greet(consoles, boat, plan)
        started = time.clock.now()
        with interrupts(session), np.errstate(all="ignore"):
            session.run()
        wall = (time.clock.now() - started) / SECOND
        for console in consoles:
            console.sender.close(PATIENCE)
    recorder.close()
    return account(session, options, wall)


def warm(boat: Boat) -> None:
    """Take a tick and a casualty on a throw-away state: nothing compiles once the clock runs."""
    if not machine_code_is_compiled():
        click.echo("compiling the boat, this once (some 20 seconds) ...", err=True)
    before = boat.snapshot()
    boat.state.u = 1.0
    boat.trimmed(1.0)
    boat.put_to_sea(boat.sea)
    casualty.insert(boat, "propulsion-lost")
    boat.tick()
    casualty.readings(boat)
    casualty.clear(boat, "all")
    Watch.over(boat, Limits())
    boat.restore(before)
    gc.collect()
    gc.freeze()  # a full collection with numba loaded takes 0.1 s


def refuse_unstable(boat: Boat) -> None:
    """Raise ConfigError if the step makes the boat unstable, naming the largest that does not."""
    from trainer.study.stability import stable_step  # noqa: PLC0415

    low, high = boat.file.run.speed_range_kn
    verdict = stable_step(boat, [low * KNOT, 0.5 * (low + high) * KNOT, high * KNOT])
    if not verdict.ok:
        raise ConfigError(
            f"--step {boat.method.step:g} s is not stable with {boat.method.integrator}: "
            f"{verdict.worst}; the largest stable step is {verdict.largest:.3g} s "
            "(--unsafe-step runs it all the same)"
        )


def open_csv(path: Path | None, batch: int) -> CsvFile | NoFile:
    """Return the recorder; ConfigError if the file cannot be written."""
    if path is None:
        return NoFile()
    try:
        return CsvFile(path, batch)
    except OSError as error:
        raise ConfigError(f"--csv {path}: {error.strerror}") from None


def open_consoles(
    options: dict[str, Any], wake: threading.Event, ports: contextlib.ExitStack
) -> list[Console]:
    """Return the consoles of the run: a serial line, the terminal, or none."""
    if options["url"] is not None:
        try:
            line = SerialLine(options["url"], options["baud"])
        except LinkError as error:
            raise ConfigError(f"--serial {error}") from None
        ports.callback(line.close)
        return [Console(Inbox(line.read, wake), Outbox(line.write))]
    if options["headless"]:
        return []
    unhurried = math.isinf(options["speed"])
    out = writer(1)
    sender = Direct(out, b"\n") if unhurried else Outbox(out, line_end=b"\n")
    inbox = Inbox(reader(0), wake)
    if unhurried and not os.isatty(0):
        await_pipe(inbox)
    return [Console(inbox, sender)]


def await_pipe(inbox: Inbox) -> None:
    """Wait for a pipe to end, or to pause: at full speed its orders act before the first tick."""
    while not inbox.ended:
        inbox.arrived.clear()
        if not inbox.ended and not inbox.arrived.wait(PATIENCE):
            break
    inbox.arrived.set()


def greet(consoles: list[Console], boat: Boat, plan: Plan) -> None:
    """Tell each console what it is connected to, and what the exercise is about."""
    s = boat.state
    sea = f"; sea: {plan.sea.name}" if s.sea_height > 0.0 else ""
    for console in consoles:
        console.say(
            *filter(None, (plan.title, *plan.briefing.splitlines())),
            boat.file.name,
            f"{s.u / KNOT:.3g} kn, {s.z:g} m, course {course(math.degrees(s.psi), 0)}; "
            f"{boat.method.equations} set, step {boat.method.step:g} s{sea}",
            "type an order, such as: depth 80   course 090   rudder left 15   help   quit",
        )


@contextlib.contextmanager
def progress_bar(last_tick: float) -> Iterator[Any]:
    """Yield a function that takes the ticks done and shows them on a terminal's stderr."""
    if not (math.isfinite(last_tick) and sys.stderr.isatty()):
        yield None
        return
    with click.progressbar(
        length=int(last_tick), label="simulating", file=sys.stderr, update_min_steps=200
    ) as bar:
        yield lambda tick: bar.update(tick - bar.pos - bar._completed_intervals)  # noqa: SLF001


@contextlib.contextmanager
def interrupts(session: Session) -> Iterator[None]:
    """Let Ctrl-C and a request to terminate end the run after the tick at hand."""
    if threading.current_thread() is not threading.main_thread():
        yield
        return

    def stop(*_: object) -> None:
        # In a thread of its own: the event that wakes the run may be locked by the very call that
        # the signal interrupts, and would be waited for until the end of days.
        threading.Thread(target=session.stop).start()

    kept = {}
    for name in ("SIGINT", "SIGTERM", "SIGHUP"):
        number = getattr(signal, name, None)
        if number is not None:
            kept[number] = signal.signal(number, stop)
    try:
        yield
    finally:
        for number, handler in kept.items():
            signal.signal(number, handler)


def account(session: Session, options: dict[str, Any], wall: float) -> int:
    """Print the summary and what went wrong; return the exit code."""
    summary = summary_text(session.boat, session.time.ledger.summary(), wall)
    if session.watch.times:
        summary += f"\nevents      {session.watch.account()}"
    click.echo(summary, err=not options["headless"])
    failure = session.failure and f"frozen: {session.failure}"
    troubles = [failure, session.deserted, session.recorder.trouble]
    for console in session.consoles:
        if console.sender.dropped:
            click.echo(f"trainer: console: {console.sender.dropped} lines dropped", err=True)
    for trouble in filter(None, troubles):
        click.echo(f"trainer: {trouble}", err=True)
    return 1 if any(troubles) else 0


def summary_text(boat: Boat, ledger: Summary, wall: float) -> str:
    """Return the one-screen account of a run that took ``wall`` [s]."""
    s = boat.state
    step = boat.method.step
    return "\n".join(
        (
            boat.file.name,
            f"computed    {boat.method.equations} set, {boat.method.integrator} at {step:g} s",
            f"simulated   {boat.time:.1f} s in {ledger.ticks} ticks; {wall:.2f} s on the clock",
            f"duty cycle  {100 * ledger.duty_cycle:.4f} %   ({SECONDS_1969})",
            (
                f"work a tick median {ledger.work.p50_ns / 1e3:.1f} us, "
                f"99 % {ledger.work.p99_ns / 1e3:.1f} us, most {ledger.work.max_ns / 1e3:.1f} us"
            ),
            (
                f"on time     overruns {ledger.overruns}, caught up {ledger.caught_up}, "
                f"slipped {ledger.skipped}, gaps {ledger.gaps} ({ledger.gap_ns / 1e9:.1f} s)"
            ),
            (
                f"the boat    {s.z:.5g} m, course {course(math.degrees(s.psi), 1)}, "
                f"{s.u / KNOT:.4g} kn, pitch {math.degrees(s.theta):+.2f}, "
                f"heel {math.degrees(s.phi):+.2f} degrees"
            ),
        )
    )
