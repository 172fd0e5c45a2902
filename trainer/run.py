"""A run from its plan to its account: everything joined, started, and accounted for at the end."""

import contextlib
import math
import signal
import sys
import threading
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import islice
from pathlib import Path
from typing import Any

import click
import numpy as np

from trainer import compilation, places
from trainer.account import account
from trainer.boat import Boat
from trainer.clock import Clock, MonotonicClock
from trainer.config import ConfigError, remembering
from trainer.history import History
from trainer.io.csv_file import COLUMNS, CsvFile, NoFile
from trainer.io.no_recording import NoRecording
from trainer.io.recording import Recording, RecordingError
from trainer.io.recording_file import TakenError
from trainer.io.teletype import course
from trainer.ledger import SECOND
from trainer.pacer import Policy
from trainer.plan import Plan, plan_run
from trainer.ports import PATIENCE, Ports, unhurried
from trainer.punctuality import Punctuality
from trainer.readiness import refuse_unstable, warm
from trainer.records.log_book import header_of
from trainer.rerun_log.opening import open_log
from trainer.rerun_log.subject import Subject
from trainer.session import Session
from trainer.stations.frame import Lookout
from trainer.stations.publisher import Promptly, Publisher, Roster
from trainer.stations.reception import Closed
from trainer.timekeeping import Timekeeping
from trainer.units import KNOT
from trainer.watch import Watch

OVER = "the session is over"
NAMES = 100  # that a new recording is tried under
BATCH = 200  # [rows] of a CSV file written at once by a run that keeps no time


@dataclass(frozen=True)
class Voyage:
    """What is settled before the ports open."""

    plan: Plan
    boat: Boat
    history: History
    kept: str  # path of the recording, "" for none
    clock: Clock = field(default_factory=MonotonicClock)


def run_boat(options: dict[str, Any], clock: Clock | None = None) -> int:
    """Run as the command line's ``options`` say, by the machine's clock; return the exit code."""
    with remembering() as texts:
        plan = plan_run(options)
    boat = ready(plan, options)
    kept: Path | None = None
    state = boat.records.state.tobytes()
    recording: Recording | NoRecording = NoRecording()
    paths = recording_paths(plan, options)
    if paths or options["serve"] or not options["headless"]:
        kept, recording = create_recording(paths, header_of(options, texts, boat), state)
    history = History(boat, recording)
    return fly(Voyage(plan, boat, history, str(kept or ""), clock or MonotonicClock()), options)


def ready(plan: Plan, options: dict[str, Any]) -> Boat:
    """Return the boat as the plan starts her; ConfigError if she cannot be."""
    boat = Boat(plan.file, plan.method)
    if options["serve"] and not compilation.needed():
        click.echo(f"{places.MAKING_READY} {plan.title or plan.file.name}", err=True)
    warm(boat)
    if not options["unsafe_step"]:
        refuse_unstable(boat)
    plan.start(boat)
    return boat


def create_recording(
    paths: Sequence[Path], header: Mapping[str, str], state: bytes
) -> tuple[Path | None, Recording]:
    """Make the first recording whose name nobody takes before; a passing one if there is no name.

    ConfigError if it cannot be made.
    """
    for path in paths or (None,):
        try:
            return path, Recording.create(path, header, state)
        except TakenError as error:
            taken = error
        except RecordingError as error:
            raise ConfigError(f"--record {error}") from None
    raise ConfigError(f"--record {taken}")


def recording_paths(plan: Plan, options: dict[str, Any]) -> tuple[Path, ...]:
    """Return where the run is recorded: where told, by default if somebody is there to train."""
    if options["record"] is not None or options["no_record"]:
        return () if options["no_record"] else (Path(options["record"]),)
    alone = options["headless"] and not options["serve"]
    if alone or math.isinf(options["speed"]):
        return ()
    return tuple(islice(places.recording_paths(options["exercise"] or plan.file.path.stem), NAMES))


def fly(voyage: Voyage, options: dict[str, Any]) -> int:
    """Open the ports, run the session to its end, account for it; return the exit code."""
    boat, history, plan = voyage.boat, voyage.history, voyage.plan
    method = boat.method
    recorder = open_csv(options["csv_path"], 1 if math.isfinite(options["speed"]) else BATCH)
    last_tick = math.inf if plan.duration is None else round(plan.duration / method.step)
    time = Timekeeping.at(voyage.clock, method.step, options["speed"], Policy(options["overrun"]))
    time.punctuality = Punctuality(realtime=options["priority"] == "realtime")
    publisher = open_publisher(boat, time, options)
    log = open_log(publisher, time.ledger, Subject.of(plan, boat), options)
    sending = log or publisher
    wake = threading.Event()
    with contextlib.closing(history.recording), contextlib.ExitStack() as stack:
        stack.callback(publisher.close, PATIENCE)  # also where a port cannot be opened
        session = Session(
            boat,
            time,
            history,
            recorder,
            COLUMNS if options["csv_path"] else (),
            sending,
            schedule=plan.schedule,
            watch=Watch.over(boat, plan.limits),
            last_tick=last_tick,
            wake=wake,
            briefing=(*heading(plan), *situation(plan, boat, options["note"])),
            crew_briefing=(
                *(() if plan.hides else heading(plan)),
                *situation(plan, boat, options["note"]),
            ),
            until_left=bool(options.get("until_left")),
        )
        if log:
            session.board.hearers.append(log.hear)
        open_ports(Ports(wake, sending, session.board.log, stack), session, options)
        shown = progress_bar(last_tick) if options["headless"] else contextlib.nullcontext()
        started = time.clock.now()
        quiet = np.errstate(all="ignore")
        with interrupts(session), quiet, shown as session.progress, time.attended():
            session.run(frozen=options["frozen"])
        wall = (time.clock.now() - started) / SECOND
        session.board.tell("time", OVER)
        sending.close(PATIENCE)
        for station in session.board.stations:
            station.close(PATIENCE)
        recorder.close()
        history.recording.close()
        code = account(session, wall, voyage.kept, aside=not options["headless"])
        return max(code, log.account()) if log else code


def open_ports(ports: Ports, session: Session, options: dict[str, Any]) -> None:
    """Open what the command line asks for, and greet whoever is there."""
    baud = options["baud"]
    session.board.stations += [ports.panel(given, baud) for given in options["lines"]]
    if options["url"] is not None:
        session.board.stations.append(ports.console_line(options["url"], baud))
    elif not options["headless"]:
        quick = unhurried(options)
        session.board.stations.append(ports.terminal(unhurried=quick))
    if options["nmea"] or options["nmea_record"] is not None:
        from trainer.nmea.outlets import open_outlets  # noqa: PLC0415  what runs seldom have

        session.board.stations += open_outlets(ports, session.history.recording, options)
    session.reception = ports.lobby(options) or Closed()
    for station in session.board.stations:
        session.greet(station)


def open_publisher(boat: Boat, time: Timekeeping, options: dict[str, Any]) -> Publisher | Promptly:
    """Return what sends to the stations: at once where no time is kept."""
    roster = Roster(Lookout(boat, time.ledger.summary))
    return Promptly(roster) if unhurried(options) else Publisher(roster)


def open_csv(path: Path | None, batch: int) -> CsvFile | NoFile:
    """Return the file of each tick's columns; ConfigError if it cannot be written."""
    if path is None:
        return NoFile()
    try:
        return CsvFile(path, batch)
    except OSError as error:
        raise ConfigError(f"--csv {path}: {error.strerror}") from None


def heading(plan: Plan) -> tuple[str, ...]:
    """Return what the exercise is about."""
    return tuple(filter(None, (plan.title, *plan.briefing.splitlines())))


def situation(plan: Plan, boat: Boat, note: str) -> tuple[str, ...]:
    """Return what whoever comes is told: the boat, where she is, and a note."""
    s = boat.state
    sea = f"; sea: {plan.sea.name}" if s.sea_height > 0.0 else ""
    return (
        boat.file.name,
        (
            f"{s.u / KNOT:.3g} kn, {s.z:g} m, course {course(math.degrees(s.psi), 0)}; "
            f"{boat.method.equations} set, step {boat.method.step:g} s{sea}"
        ),
        *filter(None, (note,)),
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
