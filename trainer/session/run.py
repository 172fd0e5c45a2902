"""A run from its plan to its summary. It joins everything, starts it, and sums it up."""

import contextlib
import math
import signal
import sys
import threading
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, fields, replace
from itertools import islice
from pathlib import Path
from typing import Any, Final, NamedTuple

import click
import numpy as np

from trainer.boat import compilation
from trainer.boat.boat import Boat
from trainer.boat.limits import LimitMonitor, account_of
from trainer.config.exercise import load_exercise
from trainer.config.files import ConfigError, remembering
from trainer.io import paths as paths_module
from trainer.io.recording.absence import NoRecording
from trainer.io.recording.file import TakenError
from trainer.io.recording.recording import Recording, RecordingError
from trainer.io.status_line import course
from trainer.io.tables import COLUMNS, CsvFile, NoFile
from trainer.session.conduct import Following, problem_with
from trainer.session.exercise import Debriefing, Ending
from trainer.session.header import header_of
from trainer.session.history import History
from trainer.session.options import RunOptions
from trainer.session.plan import OVERRULED, Plan, plan_run
from trainer.session.ports import PATIENCE, Ports, keeps_no_time
from trainer.session.rerun.request import open_log
from trainer.session.rerun.subject import Subject
from trainer.session.session import Session
from trainer.session.stations.briefing import Briefing
from trainer.session.stations.past import recalled
from trainer.session.stations.reception import Closed
from trainer.session.stations.roles import INSTRUCTOR, STRANGER
from trainer.session.stations.station import Fact
from trainer.session.stations.subscriptions import Promptly, Publisher, Roster
from trainer.session.stations.view import StateReader
from trainer.session.time.ledger import SECOND, Summary
from trainer.session.time.pacer import Clock, MonotonicClock, Policy
from trainer.session.time.timekeeping import Punctuality, Timekeeping
from trainer.session.warm_up import refuse_unstable, set_garbage_aside, warm
from trainer.units import KNOT

SEE_IT = "trainer debrief FILE shows how it went, trainer replay FILE flies it again"
SECONDS_1969 = "1969: 38 % at 0.5 s, 19 % at 1 s"


def account(session: Session, wall: float, kept: str, *, aside: bool) -> int:
    """Print the summary of a run of ``wall`` [s] and what went wrong. Return the exit code.

    ``kept`` is the path of its recording, "" if it has none; ``aside`` prints on stderr, where a
    console has stdout.
    """
    summary = "\n".join(
        (
            *outcome_lines(session),
            summary_text(
                session.boat, session.time.ledger.summary(), wall, session.conduct.compiled_from
            ),
        )
    )
    if granted := session.time.punctuality.granted:
        summary += f"\nthe clock   {granted.line()}"
    if times := session.monitor.times | session.depths.times | session.pilot.times:
        summary += f"\nevents      {account_of(times)}"
    if kept:
        absences = session.history.recording.absences
        whole = absences and not session.history.recording.missing
        again = f"; it was out of reach {absences} times, and is whole" if whole else ""
        summary += f"\nrecorded    {kept}{again}\n            {SEE_IT}"
    click.echo(summary, err=aside)
    failure = session.control.failure and f"frozen: {session.control.failure}"
    recording = describe_missing(session.history.recording) if kept else ""
    troubles = [failure, session.deserted, session.recorder.trouble, recording]
    for station in session.event_log.stations:
        if station.line.dropped:
            name = station.line.name
            click.echo(f"trainer: {name}: {station.line.dropped} lines dropped", err=True)
    if not aside:  # nobody was there to hear it
        troubles += session.refused
    for trouble in filter(None, troubles):
        click.echo(f"trainer: {trouble}", err=True)
    return 1 if any(troubles) else 0


def outcome_lines(session: Session) -> list[str]:
    """Return the trainee's result: the end of the exercise, the marks and their reasons."""
    conduct = session.conduct
    marks = conduct.final_marks()
    if not (conduct.ending.over or marks):
        return []
    lost = f": {conduct.ending.why}" if conduct.ending.why else ""
    ended = (
        f"{conduct.ending.over}{lost}"
        if conduct.ending.over
        else f"left at {session.boat.time:g} s"
    )
    told = f"outcome     {ended}; {marks}" if marks else f"outcome     {ended}"
    return [told, *(f"            {each}" for each in (marks.reasons if marks else ()))]


def describe_missing(recording: Recording | NoRecording) -> str:
    """Return what a closed recording lacks and why, "" if it is whole."""
    if not (recording.missing or recording.trouble):
        return ""
    why = f"; {recording.trouble}" if recording.trouble else ""
    return f"NOT RECORDED: {recording.missing or 'nothing more'}{why}"


def summary_text(boat: Boat, ledger: Summary, wall: float, compiled_from: int = 0) -> str:
    """Return the one-screen account of a run that took ``wall`` [s].

    ``compiled_from`` is the tick from which machine code computed it, 0 where all was one.
    """
    s = boat.state
    step = boat.method.step
    until = f" before tick {compiled_from}" if compiled_from else ""
    how = f", interpreted{until}" if compilation.is_interpreted() else ""
    return "\n".join(
        (
            boat.file.name,
            f"computed    {boat.method.equations} set, {boat.method.integrator} at {step:g} s{how}",
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


class Ended(NamedTuple):
    """The result of a run: its exit code, and the exercise that follows."""

    code: int
    following: str


OVER = "the session is over"
EXERCISE: Final[Mapping[str, Any]] = {  # what another exercise settles anew: as not given
    each.name: each.default for each in fields(RunOptions) if each.name in OVERRULED
}
NAMES = 100  # that a new recording is tried under
BATCH = 200  # [rows] of a CSV file written at once by a run that keeps no time


@dataclass(frozen=True)
class PreparedRun:
    """The decisions before the ports open."""

    plan: Plan
    boat: Boat
    history: History
    kept: str  # path of the recording, "" for none
    clock: Clock = field(default_factory=MonotonicClock)
    debriefing: Debriefing | None = None
    following: Following = field(default_factory=Following)


def run_boat(
    options: RunOptions, clock: Clock | None = None, debriefing: Debriefing | None = None
) -> int:
    """Run as the command line's ``options`` say, by the machine's clock; return the exit code.

    Where the instructor has ordered another exercise next, that is begun, frozen, in its turn.
    """
    while True:
        ended = run_once(options, clock or MonotonicClock(), debriefing)
        if not ended.following:
            return ended.code
        given = options.given - OVERRULED.keys()
        options = replace(
            options, **EXERCISE, exercise=ended.following, given=given, record=None, frozen=True
        )


def run_once(options: RunOptions, clock: Clock, debriefing: Debriefing | None) -> Ended:
    """Run one exercise, or none, to its end."""
    with remembering() as texts:
        plan = plan_run(options)
    boat = ready(plan, options)
    set_garbage_aside()
    kept: Path | None = None
    state = boat.records.state.tobytes()
    recording: Recording | NoRecording = NoRecording()
    paths = recording_paths(plan, options)
    if options.trainee and not paths:
        raise ConfigError("--trainee: this run is not recorded, and keeps no names: --record FILE")
    if paths or options.serve or not options.headless:
        kept, recording = create_recording(paths, header_of(options, texts, boat), state)
    prepared = PreparedRun(
        *(plan, boat, History(boat, recording), str(kept or ""), clock, debriefing),
        following_of(options),
    )
    try:
        return fly(prepared, options)
    except ConfigError:
        discard(kept)  # it was begun for a run that is refused
        raise


def following_of(options: RunOptions) -> Following:
    """Return the exercises that may follow a run. Any may, if a recording is all it writes."""
    files = options.csv_path, options.rrd, options.nmea_record
    barred = "this session is begun for one run" if any(files) or keeps_no_time(options) else ""
    return Following(problem_with(load_exercise), barred)


def discard(kept: Path | None) -> None:
    """Remove a recording of nothing."""
    for ending in ("", "-wal", "-shm", "-journal"):
        if kept is not None:
            kept.with_name(kept.name + ending).unlink(missing_ok=True)


def ready(plan: Plan, options: RunOptions) -> Boat:
    """Return the boat as the plan starts it; ConfigError if it cannot be."""
    boat = Boat(plan.file, plan.method)
    if options.serve and not compilation.is_needed():
        click.echo(f"{paths_module.MAKING_READY} {plan.title or plan.file.name}", err=True)
    warm(boat)
    if not options.unsafe_step:
        refuse_unstable(boat)
    plan.start(boat)
    if plan.note:
        click.echo(f"trainer: {plan.note}", err=True)
    return boat


def create_recording(
    paths: Sequence[Path], header: Mapping[str, str], state: bytes
) -> tuple[Path | None, Recording]:
    """Make the first recording whose name nobody takes before. A passing one if there is no name.

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


def recording_paths(plan: Plan, options: RunOptions) -> tuple[Path, ...]:
    """Return the recording's path. The default is for runs with somebody to train."""
    if options.no_record:
        return ()
    if options.record is not None:
        return (options.record,)
    alone = options.headless and not options.serve
    if alone or math.isinf(options.speed):
        return ()
    return tuple(
        islice(paths_module.recording_paths(options.exercise or plan.file.path.stem), NAMES)
    )


def lives_on(options: RunOptions) -> bool:
    """Return whether the end of an exercise leaves the session to its stations, frozen."""
    attended = options.serve or not options.headless
    return attended and math.isfinite(options.speed) and "duration" not in options.given


def fly(prepared: PreparedRun, options: RunOptions) -> Ended:
    """Open the ports, run the session to its end, account for it."""
    boat, history, plan = prepared.boat, prepared.history, prepared.plan
    method = boat.method
    told = briefing_of(plan, options)
    recorder = open_csv(options.csv_path, 1 if math.isfinite(options.speed) else BATCH)
    endless = plan.duration is None or lives_on(options)
    last_tick = math.inf if endless else round((plan.duration or 0.0) / method.step)
    time = Timekeeping.at(prepared.clock, method.step, options.speed, Policy(options.overrun))
    time.punctuality = Punctuality(realtime=options.priority == "realtime")
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
            COLUMNS if options.csv_path else (),
            sending,
            schedule=plan.schedule,
            monitor=LimitMonitor.over(boat, plan.limits),
            last_tick=last_tick,
            wake=wake,
            briefing=(*told.heading(INSTRUCTOR), *situation(plan, boat, options.note)),
            crew_briefing=(*told.heading(STRANGER), *situation(plan, boat, options.note)),
            exercise=told,
            hand=frozenset(plan.hand),
            hand_from=plan.hand_from,
            allowed=frozenset(plan.allowed),
            until_left=options.until_left,
        )
        conduct_of(session, prepared, options)
        if log:
            session.event_log.hearers.append(log.hear)
        open_ports(Ports(wake, sending, session.event_log.log, stack), session, options)
        shown = progress_bar(last_tick) if options.headless else contextlib.nullcontext()
        started = time.clock.now()
        quiet = np.errstate(all="ignore")
        with interrupts(session), quiet, shown as session.progress, time.attended():
            session.run(frozen=options.frozen)
        wall = (time.clock.now() - started) / SECOND
        session.conduct.work.finish()
        if not session.control.following:  # else whoever is there comes back for it
            session.event_log.tell("time", OVER, fact=Fact("over"))
        sending.close(PATIENCE)
        for station in session.event_log.stations:
            station.close(PATIENCE)
        recorder.close()
        history.recording.close()
        code = account(session, wall, prepared.kept, aside=not options.headless)
        if log:
            code = max(code, log.account())
        return Ended(code, session.control.following)


def conduct_of(session: Session, prepared: PreparedRun, options: RunOptions) -> None:
    """Settle how a session is conducted: its exercise's end, its judge, and what follows."""
    plan, conduct = prepared.plan, session.conduct
    conduct.debriefing, conduct.following = prepared.debriefing, prepared.following
    conduct.scored = bool(plan.scores)
    conduct.kept = Path(prepared.kept) if prepared.kept else None
    if lives_on(options):
        conduct.ending = Ending.of(prepared.boat, plan.lost, plan.duration)
    if prepared.boat.ticks:
        session.event_log.news.extend(recalled(prepared.history))
    if compilation.is_interpreted() and options.note:
        await_code(session)


def await_code(session: Session) -> None:
    """Go over to machine code once it is there, between two ticks."""

    def task() -> Callable[[], None]:
        try:
            there = compilation.await_code(session.conduct.work.closing)
            tick = session.boat.compiled_tick() if there else None
        except Exception as error:  # noqa: BLE001 whatever it is, the session goes on as it does
            why = f"compiled code cannot be used: {type(error).__name__}; interpreted to the end"
            return lambda: session.event_log.tell("trouble", why)
        if tick is None:
            why = "" if session.conduct.work.closing.is_set() else "compiling beside has failed"
            return lambda: session.event_log.tell("trouble", why) if why else None
        return lambda: session.conduct.go_over(tick)

    session.conduct.work.begin("machine code", task)


def open_ports(ports: Ports, session: Session, options: RunOptions) -> None:
    """Open what the command line asks for, and greet whoever is there."""
    baud = options.baud
    session.event_log.stations += [ports.panel(given, baud) for given in options.lines]
    if options.url is not None:
        session.event_log.stations.append(ports.console_line(options.url, baud))
    elif not options.headless:
        quick = keeps_no_time(options)
        session.event_log.stations.append(ports.terminal(unhurried=quick))
    if options.nmea or options.nmea_record is not None:
        from trainer.session.nmea.outlets import open_outlets  # noqa: PLC0415  what runs seldom have

        session.event_log.stations += open_outlets(ports, session.history.recording, options)
    session.reception = ports.lobby(options) or Closed()
    for station in session.event_log.stations:
        session.greet(station)


def open_publisher(boat: Boat, time: Timekeeping, options: RunOptions) -> Publisher | Promptly:
    """Return what sends to the stations: at once where no time is kept."""
    roster = Roster(StateReader(boat, time.ledger.summary))
    return Promptly(roster) if keeps_no_time(options) else Publisher(roster)


def open_csv(path: Path | None, batch: int) -> CsvFile | NoFile:
    """Return the file of each tick's columns; ConfigError if it cannot be written."""
    if path is None:
        return NoFile()
    try:
        return CsvFile(path, batch)
    except OSError as error:
        raise ConfigError(f"--csv {path}: {error.strerror}") from None


def briefing_of(plan: Plan, options: RunOptions) -> Briefing:
    """Return what there is to say of the exercise."""
    return Briefing(
        name=Path(options.exercise).stem if options.exercise else "",
        title=plan.title,
        text=tuple(plan.briefing.splitlines()),
        instructor=tuple(plan.instructor.splitlines()),
        hides=plan.hides and not plan.instructor,
        limits=plan.limits,
        lost=plan.lost,
        tasks=tuple(rule.score.name for rule in plan.scores if rule.part != "keeping"),
        duration=plan.duration,
    )


def situation(plan: Plan, boat: Boat, note: str) -> tuple[str, ...]:
    """Return what whoever comes is told: the boat, where it is, and a note."""
    s = boat.state
    sea = f"; sea: {plan.sea.name}" if s.sea_height > 0.0 else ""
    return (
        boat.file.name,
        (
            f"{s.u / KNOT:.3g} kn, {s.z:g} m, course {course(math.degrees(s.psi), 0)}; "
            f"{boat.method.equations} set, step {boat.method.step:g} s{sea}"
        ),
        *filter(None, (plan.note, note)),
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
    """End the run after the tick at hand, by Ctrl-C or a request to terminate."""
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
