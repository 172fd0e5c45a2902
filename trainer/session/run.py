"""A run from its plan to its summary: parts made, joined, started and closed.

``cli`` calls ``run_boat`` for ``trainer run`` and ``serve``; ``resume`` calls ``fly_session`` with
a boat brought to where its recording ends. One run may fly several exercises, one after another:
clock, judge and pages stay (``LastingParts``), all else is made anew for each.
"""

import contextlib
import math
import signal
import sys
import threading
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, fields, replace
from itertools import islice
from pathlib import Path
from typing import Any, Final, NamedTuple

import click
import numpy as np

from trainer.boat.boat import Boat
from trainer.boat.limits import LimitMonitor
from trainer.config.exercise.class_course import NO_COURSE, ClassCourse
from trainer.config.exercise.class_file import load_class
from trainer.config.extras import require_library
from trainer.config.files import ConfigError, remembering
from trainer.core.kernel import INTERPRETED
from trainer.io import paths as paths_module
from trainer.io.orders.grammar import Refused
from trainer.io.recording.absence import NoRecording
from trainer.io.recording.recording import Recording, RecordingError, TakenError
from trainer.io.status_line import course
from trainer.io.tables import MOTION_COLUMNS, CsvFile, NoFile
from trainer.session.account import SummaryOptions, account
from trainer.session.attendance import Introduction
from trainer.session.crew.agenda import Agenda
from trainer.session.doors.page_server import PageServer, serving_pages
from trainer.session.doors.ports import PORT_TIMEOUT_S, Ports, keeps_no_time
from trainer.session.doors.warm_up import set_garbage_aside
from trainer.session.exercise.aids import GHOST
from trainer.session.exercise.marks import DebriefSource
from trainer.session.exercise.terms import SINGLE_REFUSAL, Terms
from trainer.session.parts import Monitors
from trainer.session.past.header import header_of, learners_of
from trainer.session.past.history import History
from trainer.session.past.options import RunOptions
from trainer.session.past.plan import OVERRULED_SETTINGS, Plan, plan_run
from trainer.session.people.briefing import Briefing
from trainer.session.ready import crew_talk, ready_boat
from trainer.session.rerun.batch import Subject
from trainer.session.rerun.request import open_log
from trainer.session.session import ColumnFile, Session
from trainer.session.stations.past import recalled_past
from trainer.session.stations.roles import INSTRUCTOR_ROLE, STRANGER_ROLE, TRAINEE_ROLE
from trainer.session.stations.station import Fact, NoReception
from trainer.session.stations.subscriptions import PromptSender, Publisher, Roster
from trainer.session.stations.view import StateReader
from trainer.session.time.ledger import SECOND_NS
from trainer.session.time.pacer import Clock, MonotonicClock, Policy
from trainer.session.time.timekeeping import Punctuality, Timekeeping
from trainer.units import KNOT

SESSION_OVER = "the session is over"
EXERCISE_DEFAULTS: Final[Mapping[str, Any]] = {  # what another exercise settles anew: as not given
    each.name: each.default for each in fields(RunOptions) if each.name in OVERRULED_SETTINGS
}
MAX_NAME_TRIES = 100  # that a new recording is tried under
BATCH_ROWS = 200  # [rows] of a CSV file written at once by a run that keeps no time


class RunResult(NamedTuple):
    """The result of a run: its exit code, and what follows, chosen by whom."""

    code: int
    following: str
    trains: bool  # who trains chose it


@dataclass(frozen=True)
class PreparedRun:
    """The plan, boat and recording of a run, made before the ports open."""

    plan: Plan
    boat: Boat
    history: History
    kept: str  # path of the recording, "" for none
    begun: "LastingParts"
    barred: Refused | None = SINGLE_REFUSAL  # why no other exercise may follow


@dataclass
class LastingParts:
    """The parts that outlive an exercise: clock, judge, course, pages for browsers."""

    clock: Clock = field(default_factory=MonotonicClock)
    debriefing: DebriefSource | None = None
    course: ClassCourse = NO_COURSE
    pages: PageServer | None = None


def run_boat(
    options: RunOptions, clock: Clock | None = None, debriefing: DebriefSource | None = None
) -> int:
    """Run by the machine's clock as ``options`` say; return the exit code.

    If the instructor orders a next exercise, it begins, frozen, when this one has ended.
    """
    begun = LastingParts(clock or MonotonicClock(), debriefing, course_of(options))
    with serving_pages(options) as begun.pages:
        return run_following(run_once(options, begun), options, begun)


def run_following(ended: RunResult, options: RunOptions, begun: LastingParts) -> int:
    """Run the exercises that follow a run until none does; return the last exit code."""
    while ended.following:
        chosen = following_options(options, ended.following)
        if ended.trains and options.browse:
            chosen = replace(chosen, train=True, trainee=learners_of(options))
        ended = run_once(chosen, begun)
    return ended.code


def following_options(options: RunOptions, exercise: str) -> RunOptions:
    """Return the options of the run that follows: of the exercise that was ordered, frozen.

    It settles anew what options have overruled; in a course the boat keeps its own seed.
    """
    kept = {"seed": options.seed} if options.course else {}
    return replace(
        options,
        **{**EXERCISE_DEFAULTS, **kept},
        exercise=exercise,
        given=options.given - (OVERRULED_SETTINGS.keys() - kept.keys()),
        record=recordings_folder(options),
        frozen=True,
        familiarisation=False,  # the next exercise is one
    )


def course_of(options: RunOptions) -> ClassCourse:
    """Return the course that the options name, without rows where they name none; ConfigError."""
    if options.course is None:
        return NO_COURSE
    rows = load_class(options.course).course
    if not rows:
        raise ConfigError(f"--course {options.course}: it has no rows [[course]]")
    return ClassCourse(rows)


def why_single(options: RunOptions) -> Refused | None:
    """Return why no exercise may follow in the same process, None where one may."""
    files = options.csv_path, options.rrd, options.nmea_record  # another run would replace them
    single = any(files) or keeps_no_time(options)
    return Refused("this session is begun for one run") if single else None


def run_once(options: RunOptions, begun: LastingParts) -> RunResult:
    """Run one exercise, or none, to its end."""
    if options.familiarisation and not options.trainee:
        raise ConfigError(
            "--familiarisation: it is kept with a trainee's recordings: --trainee NAME"
        )
    with remembering() as texts:
        plan = plan_run(options)
    if options.rrd is not None:
        require_library("rerun", "--rrd")
    boat = ready_boat(plan, options)
    set_garbage_aside()
    path: Path | None = None
    state = boat.records.state.tobytes()
    recording: Recording | NoRecording = NoRecording()
    paths = recording_paths(plan, options)
    if options.trainee and not paths:
        raise ConfigError("--trainee: this run is not recorded, and keeps no names: --record FILE")
    if paths or options.serve or not options.headless:
        path, recording = create_recording(paths, header_of(options, texts, boat), state)
    history = History(boat, recording)
    prepared = PreparedRun(plan, boat, history, str(path or ""), begun, why_single(options))
    try:
        return fly_session(prepared, options)
    except ConfigError:
        discard_recording(path)  # it was begun for a run that is refused
        raise


def discard_recording(kept: Path | None) -> None:
    """Remove a recording that holds nothing."""
    for ending in ("", "-wal", "-shm", "-journal"):
        if kept is not None:
            kept.with_name(kept.name + ending).unlink(missing_ok=True)


def create_recording(
    paths: Sequence[Path], header: Mapping[str, str], state: bytes
) -> tuple[Path | None, Recording]:
    """Make a recording under the first free name, a temporary one without names.

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
    """Return paths for the recording. Only runs with somebody to train have a default."""
    folder = recordings_folder(options)
    if options.no_record:
        return ()
    if options.record is not None and not folder:
        return (options.record,)
    alone = options.headless and not options.serve
    if (alone or math.isinf(options.speed)) and not folder:
        return ()
    name = options.exercise or plan.file.path.stem
    return tuple(islice(paths_module.recording_paths(name, folder), MAX_NAME_TRIES))


def recordings_folder(options: RunOptions) -> Path | None:
    """Return the folder that was asked for recordings, one after another; None without one."""
    return options.record if options.record and options.record.is_dir() else None


def lives_on(options: RunOptions) -> bool:
    """Return whether the end of an exercise leaves the session to its stations, frozen."""
    attended = options.serve or not options.headless
    return attended and math.isfinite(options.speed) and "duration" not in options.given


def fly_session(prepared: PreparedRun, options: RunOptions) -> RunResult:
    """Open the ports, run the session to its end, account for it."""
    boat, history, plan = prepared.boat, prepared.history, prepared.plan
    recorder = open_csv(options.csv_path, 1 if math.isfinite(options.speed) else BATCH_ROWS)
    endless = plan.duration is None or lives_on(options)
    step = boat.method.step
    last_tick = math.inf if endless else round((plan.duration or 0.0) / step)
    time = Timekeeping.at(prepared.begun.clock, step, options.speed, Policy(options.overrun))
    time.punctuality = Punctuality(realtime=options.priority == "realtime")
    publisher = open_publisher(boat, time, options)
    log = open_log(publisher, time.ledger, Subject.of(plan, boat), options)
    sending = log or publisher
    wake = threading.Event()
    with contextlib.closing(history.recording), contextlib.ExitStack() as stack:
        stack.callback(publisher.close, PORT_TIMEOUT_S)  # also where a port cannot be opened
        session = Session(
            boat,
            time,
            history,
            sending,
            Agenda(boat, plan.schedule, plan.armed),
            crew_talk(plan, boat),
            Monitors.over(boat, LimitMonitor.over(boat, plan.limits)),
            wake,
            terms_of(prepared, options),
            introduction_of(prepared, options),
            ColumnFile(recorder, MOTION_COLUMNS if options.csv_path else ()),
            last_tick,
        )
        session.attendance.until_left = options.until_left
        if boat.ticks:
            session.event_log.news.extend(recalled_past(history))
        session.event_log.recall_alerts()  # at tick 0 too: snapshots may lead back to them
        if not INTERPRETED:
            judge = session.conduct.terms.debriefing
            session.evaluation.begin(
                judge.evaluator if judge else (), session.conduct.terms.kept, plan
            )
        if log:
            session.event_log.hearers.append(log.hear)
        crowd, work = session.event_log.strangers, session.conduct.work

        def report(text: str) -> None:
            work.post(lambda: crowd.log("trouble", text))  # not more than a crowd may say

        ports = Ports(wake, sending, session.event_log.log, stack, report)
        open_lines(ports, session, options)
        shown = progress_bar(last_tick) if options.headless else contextlib.nullcontext()
        with end_on_interrupt(session):
            open_door(ports, session, options, prepared.begun.pages)
            stands = options.browse and not plan.visitors and "duration" not in options.given
            started = time.clock.now()
            with np.errstate(all="ignore"), shown as session.progress, time.attended():
                session.run(frozen=options.frozen or stands)
        wall = (time.clock.now() - started) / SECOND_NS
        wind_up(session)
        sending.close(PORT_TIMEOUT_S)
        for station in session.event_log.stations:
            station.close(PORT_TIMEOUT_S)
        recorder.close()
        history.recording.close()
        kept = prepared.kept
        if stands and not (boat.ticks or options.record):  # a choice alone is nothing to keep
            discard_recording(Path(kept) if kept else None)
            kept = ""
        summary = SummaryOptions(kept, options.verbose, aside=not options.headless)
        code = account(session, wall, summary)
        if log:
            code = max(code, log.account())
        return RunResult(code, session.control.following, session.control.trains)


def wind_up(session: Session) -> None:
    """End what goes on beside a session, and say that it is over."""
    session.dispatch.way.end_in_time()  # so that its last branch is the crew's
    session.evaluation.finish()
    session.conduct.training.remember()
    session.conduct.work.finish()
    session.event_log.strangers.close()
    if not session.control.following:  # else whoever is there comes back for it
        session.event_log.tell("time", SESSION_OVER, fact=Fact("over"))


def terms_of(prepared: PreparedRun, options: RunOptions) -> Terms:
    """Return what is settled of a session before it begins."""
    plan = prepared.plan
    ending = (plan.lost, plan.duration) if lives_on(options) else ((), None)
    return Terms(
        *(plan, Path(options.exercise).stem if options.exercise else "", *ending),
        kept=Path(prepared.kept) if prepared.kept else None,
        debriefing=prepared.begun.debriefing,
        trainees=options.trainee,
        learners=learners_of(options),
        course=prepared.begun.course,
        barred=prepared.barred,
    )


def open_lines(ports: Ports, session: Session, options: RunOptions) -> None:
    """Open the lines that the command line asks for."""
    baud = options.baud
    session.event_log.stations += [ports.panel(given, baud) for given in options.lines]
    if options.url is not None:
        session.event_log.stations.append(ports.console_line(options.url, baud))
    elif not options.headless:
        role = (TRAINEE_ROLE if options.train else INSTRUCTOR_ROLE).name
        session.event_log.stations.append(ports.terminal(role, unhurried=keeps_no_time(options)))
    if options.nmea or options.nmea_record is not None:
        from trainer.session.nmea.outlets import open_outlets  # noqa: PLC0415  what runs seldom have

        session.event_log.stations += open_outlets(ports, session.history.recording, options)


def open_door(
    ports: Ports, session: Session, options: RunOptions, pages: PageServer | None
) -> None:
    """Open the sockets for newcomers, and greet the stations that are attached already."""
    session.attendance.reception = ports.lobby(options) or NoReception()
    if options.browse:
        session.event_log.hearers.append(ports.news_printer())
    if pages:
        log, work = session.event_log, session.conduct.work
        pages.attend(
            ports.nearest(options), lambda text: work.post(lambda: log.tell("trouble", text))
        )
    for station in session.event_log.stations:
        session.attendance.greet(station)


def open_publisher(boat: Boat, time: Timekeeping, options: RunOptions) -> Publisher | PromptSender:
    """Return the sender to the stations, which sends at once where no time is kept."""
    roster = Roster(StateReader(boat, time.ledger.summary))
    return PromptSender(roster) if keeps_no_time(options) else Publisher(roster)


def open_csv(path: Path | None, batch: int) -> CsvFile | NoFile:
    """Return the CSV file with a row for each tick. ConfigError if it cannot be written."""
    if path is None:
        return NoFile()
    try:
        return CsvFile(path, batch)
    except OSError as error:
        raise ConfigError(f"--csv {path}: {error.strerror}") from None


def briefing_of(plan: Plan, options: RunOptions) -> Briefing:
    """Return the briefing of the exercise."""
    return Briefing(
        name=Path(options.exercise).stem if options.exercise else "",
        title=plan.title,
        text=tuple(plan.briefing.splitlines()),
        instructor=tuple(plan.instructor.splitlines()),
        hides=plan.hides and not plan.instructor,
        limits=plan.limits,
        lost=plan.lost,
        tasks=tuple(rule.score.name for rule in plan.scores if rule.part != "keeping"),
        steps=len(plan.steps),
        duration=plan.duration,
        visitors=plan.visitors,
        aids=plan.aids if plan.crew.rules else tuple(each for each in plan.aids if each != GHOST),
        way=bool(plan.crew.rules),
        hint_marks=plan.hint_marks,
        light=plan.light,
    )


def introduction_of(prepared: PreparedRun, options: RunOptions) -> Introduction:
    """Return what newcomers are told: the briefing, and where the boat is."""
    plan, boat = prepared.plan, prepared.boat
    briefing, here = briefing_of(plan, options), situation(plan, boat)
    computed = f"computed by the {boat.method.equations} set, step {boat.method.step:g} s"
    briefing = replace(briefing, course=prepared.begun.course.told(briefing.name))
    return Introduction(
        (*briefing.heading(INSTRUCTOR_ROLE), *here, computed),
        (*briefing.heading(STRANGER_ROLE), *here),
        briefing,
    )


def situation(plan: Plan, boat: Boat) -> tuple[str, ...]:
    """Return the lines for newcomers: the boat, where it is, the plan's note."""
    s = boat.state
    sea = f"; sea: {plan.sea.name}" if s.sea_height > 0.0 else ""
    return (
        boat.file.name,
        f"{s.u / KNOT:.3g} kn, {s.z:g} m, course {course(math.degrees(s.psi), 0)}{sea}",
        *filter(None, (plan.note,)),
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
        shown = 0

        def show(tick: int) -> None:
            nonlocal shown
            bar.update(tick - shown)
            shown = tick

        yield show


@contextlib.contextmanager
def end_on_interrupt(session: Session) -> Iterator[None]:
    """End the run after the present tick, on Ctrl-C or a request to terminate."""
    if threading.current_thread() is not threading.main_thread():
        yield
        return

    def stop(*_: object) -> None:
        # In a thread of its own: the event that wakes the run may be locked by the very call that
        # the signal interrupts, and would be waited for until the end of days.
        threading.Thread(target=session.stop).start()

    handlers = {}
    for name in ("SIGINT", "SIGTERM", "SIGHUP"):
        number = getattr(signal, name, None)
        if number is not None:
            handlers[number] = signal.signal(number, stop)
    try:
        yield
    finally:
        for number, handler in handlers.items():
            signal.signal(number, handler)
