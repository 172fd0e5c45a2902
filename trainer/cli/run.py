"""The commands that take a boat to sea, and attach to its session.

``trainer run`` on a terminal starts a session in a process of its own and shows its console
(``console/own_session``); headless, or without a terminal, it runs the session itself.
"""

import gc
import json
import math
import mmap
import socket
import sys
from collections.abc import Callable, Mapping
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, NoReturn

import click

from trainer.cli.answers import input_waits
from trainer.cli.options import (
    EXERCISE_NAME,
    HTML_OUTPUT,
    RECORDING_FILE,
    class_options,
    connect_options,
    console_options,
    exercise_options,
    last_option,
    named_recording,
    port_options,
    recording_options,
    rerun_options,
    run_options,
    teletype_option,
    time_options,
    trainee_options,
    web_run_options,
    web_serve_options,
    without_console,
)
from trainer.config.files import ConfigError
from trainer.io.paths import DEFAULT_HOST, DEFAULT_PORT, PAGES_PORT, RECORDING_SUFFIX
from trainer.report.progress import print_note
from trainer.session.doors.owner import end_with_owner
from trainer.session.past.options import RunOptions

if TYPE_CHECKING:
    import threading

    from trainer.console.exercise_choice import ExerciseChoice
    from trainer.session.exercise.marks import DebriefSource
from trainer.cli.web import require_pages

MENU_OPTIONS = frozenset({"train", "instruct", "trainee"})  # beside which a menu asks the rest
Begin = Callable[[RunOptions], NoReturn]
IMPORT_SPACE = 320_000_000  # [B] of addresses: numba and numpy were seen to take 350 million
UNREAD_ORDERS = "orders at the standard input are not heard by --headless: leave it out"
WRITER_WORDS = ("-X", "utf8", "-m", "trainer.debrief.live.beside")  # a refusal may name any path
STATION_ROLES = (
    "instructor",
    "helm",
    "planes",
    "pilot",
    "ballast",
    "diving",
    "deck",
    "observer",
    "visitor",
    "scope",
    "trainee",
)  # see stations.roles


@click.command()
@click.argument("exercise", type=EXERCISE_NAME, required=False)
@exercise_options
@time_options
@console_options
@recording_options
@trainee_options
@rerun_options
@port_options(listen=None, socket=None)
@web_run_options
@click.option("--train", is_flag=True, help="Train alone: nothing hidden is told, lessons lead.")
@click.option("--instruct", is_flag=True, help="Instruct: all is shown, others may join as crew.")
@teletype_option
@click.option(
    "--debrief", type=HTML_OUTPUT, help="With --headless: the debrief's page; keeps the recording."
)
def run(*, teletype: bool, **options: Any) -> None:
    """Run a boat in real time on a console, or headless.

    EXERCISE is the name of a shipped exercise (`trainer exercises` lists them) or the path of
    a file. Options given here overrule the file.

    \b
    Example:  trainer run
              trainer run periscope-depth --train
              trainer run --web
              trainer run --headless --duration 1h --speed max --csv out.csv
              trainer run depth-changes --headless --speed max --debrief it.html
              printf 'depth 80\\n' | trainer run --duration 120 --speed max

    On a terminal you see the instructor's console; F1 shows its help. Without any option you are
    first asked whether you train or instruct; --train and --instruct answer that. Who trains works
    the boat alone, led by lessons, and is told nothing that is to be found out. You may type
    orders at any time.
    Others on this machine join with `trainer station ROLE`. Exit codes: 0 done, 1 the boat or
    the exercise is lost, or the recording failed, 2 wrong input.
    """
    choices = run_options(options)
    refuse_both(choices)
    if choices.debrief is not None:
        fly_and_debrief(choices, choices.debrief)
    if choices.browse or choices.web:
        refuse_other_screens(choices)
        take_to_sea(without_console(with_pages(trained(replace(choices, browse=True)))))
    with_pages(choices)
    set_out(choices, take_to_sea, choose, teletype=teletype)


def refuse_both(asked: RunOptions) -> None:
    """Refuse to be both who trains and who instructs; UsageError."""
    if asked.train and asked.instruct:
        raise click.UsageError("--train and --instruct exclude each other: say who you are")


def fly_and_debrief(asked: RunOptions, page: Path) -> NoReturn:
    """Run without a console, and write the debrief's page.

    The recording goes beside the page, unless a place was asked for.
    """
    if not asked.headless or asked.serve or asked.no_record:
        raise click.UsageError(
            "--debrief goes with --headless and a recording; of any other run that was kept: "
            "trainer debrief --last"
        )
    if asked.record and asked.record.is_dir():
        raise ConfigError(f"--record {asked.record}: beside --debrief it names a file")
    record = asked.record or page.with_suffix(RECORDING_SUFFIX)
    if record.exists() and not asked.record:
        raise ConfigError(f"--debrief {page}: {record} is there already; give another name")
    code = sail(replace(asked, record=record))
    gc.disable()  # as for the command debrief
    from trainer.debrief.page.page import DebriefRequest, debrief_file

    debrief_file(record, page, None, DebriefRequest())
    sys.exit(code)


def with_pages(asked: RunOptions) -> RunOptions:
    """Return a session's options, checked for its pages if it has any; ConfigError."""
    option = "--web" if asked.browse else "--web HOST:PORT"
    if not (asked.browse or asked.web):
        if asked.cert or asked.key or asked.public_url or asked.proxy:
            raise ConfigError(f"--cert, --key, --public-url and --proxy are of pages: add {option}")
        return asked
    require_pages("--web")
    from trainer.session.stations.roles import read_tokens, refuse_open_door
    from trainer.web.front import front_of
    from trainer.web.launch import certificate_of

    certificate_of(asked.cert, asked.key)
    if front := front_of(asked.public_url, asked.proxy, asked.cert):
        refuse_open_door("--public-url", front.url, read_tokens(asked.token))
    if math.isinf(asked.speed):
        raise ConfigError("--web: pages show a boat in its own time: leave out --speed max")
    if not asked.browse or asked.socket or not hasattr(socket, "AF_UNIX"):
        return asked
    from trainer.console.own_session import free_socket

    return replace(asked, socket=str(free_socket()))


def refuse_other_screens(asked: RunOptions) -> None:
    """Raise ConfigError if a run with pages is to have another console too."""
    if asked.headless:
        raise ConfigError(
            "--web and --headless exclude each other; trainer serve --web "
            f"{DEFAULT_HOST}:{PAGES_PORT} "
            "serves pages and opens none"
        )
    if asked.url:
        raise ConfigError(f"--web: add --line instructor={asked.url} in place of --serial")


def set_out(
    asked: RunOptions, begin: Begin, choose: Callable[[RunOptions], RunOptions], *, teletype: bool
) -> NoReturn:
    """Begin a session with a console of its own, for another's console, or without.

    ``choose`` lets the user choose an exercise, if the command has no option.
    """
    from trainer.console.terminal import asked_beside, has_terminal

    elsewhere = asked.headless or asked.url is not None
    address, word = asked_beside()
    if address:
        asked = replace(without_console(asked), listen=address, token=(word,), until_left=True)
    elif not (teletype or elsewhere) and has_terminal():
        sys.exit(on_screen(asked, choose(asked) if asked.given <= MENU_OPTIONS else asked, begin))
    begin(asked)


def on_screen(asked: RunOptions, chosen: RunOptions, begin: Begin) -> int:
    """Begin a session and show its console here; return the exit code."""
    from trainer.console import own_session

    role = "trainee" if chosen.train else "instructor"

    def serve_at(where: str) -> NoReturn:
        begin(replace(without_console(trained(chosen)), socket=where, until_left=True))

    from trainer.session.stations.roles import ANY_ROLE, read_tokens

    tokens = read_tokens(chosen.token)
    token = tokens.get(role, tokens.get(ANY_ROLE))
    if own_session.can_fork():
        return own_session.sail(serve_at, chosen.socket, token, role)
    begun = [chosen.exercise] if chosen.exercise and not asked.exercise else []
    begun += ["--train"] if chosen.train and not asked.train else []
    begun += ["--frozen"] if trained(chosen).frozen and not asked.frozen else []
    begun += [f"--trainee={name}" for name in trained(chosen).trainee if not asked.trainee]
    return own_session.sail_beside([*sys.argv[1:], *begun], token, role)


def choose(asked: RunOptions) -> RunOptions:
    """Return the options with an exercise chosen at the terminal. End without a choice."""
    from trainer.console.exercise_choice import I_INSTRUCT, I_TRAIN, choose_exercise

    def offer(side: str) -> "ExerciseChoice":
        from trainer.config.exercise.course import course, lessons
        from trainer.config.exercise.progress import read_progress
        from trainer.console.exercise_choice import exercise_choice

        trains = side == I_TRAIN
        offered = [*lessons(), *course()] if trains else course()
        names = trained(replace(asked, train=trains)).trainee
        progress = read_progress(names[0]) if names else None
        return exercise_choice(offered, trains=trains, progress=progress)

    given = I_TRAIN if asked.train else I_INSTRUCT if asked.instruct else ""
    chosen = choose_exercise(offer, given)
    if chosen is None:
        sys.exit(0)
    side, name = chosen
    asked = replace(asked, train=side == I_TRAIN)
    return replace(asked, exercise=name, given=frozenset({"exercise"})) if name else asked


def trained(asked: RunOptions) -> RunOptions:
    """Return the options of a session for who trains.

    An exercise waits for his "run". His progress is kept by the name of his account, unless he
    gave another.
    """
    if not asked.train:
        return asked
    from trainer.session.past.header import learners_of

    names = learners_of(asked)
    return replace(asked, frozen=asked.frozen or bool(asked.exercise), trainee=names)


def take_to_sea(options: RunOptions) -> NoReturn:
    """Run a boat as the command line's ``options`` say, and leave with the exit code."""
    sys.exit(sail(options))


def sail(options: RunOptions) -> int:
    """Run a boat as the command line's ``options`` say; return the exit code."""
    gc.disable()  # until the boat is ready: looking for garbage is a tenth of the start
    refuse_little_memory()
    from trainer.session.run import run_boat

    alone = options.headless and not options.serve
    told = alone and tell_unread_orders()
    try:
        code = run_boat(options, debriefing=debriefing())
    finally:
        gc.enable()
    if alone and not told:  # the program before the pipe may have begun later
        tell_unread_orders()
    return code


def tell_unread_orders() -> bool:
    """Tell of orders that wait unread at the standard input; return whether any do."""
    waiting = input_waits()
    if waiting:
        print_note(f"trainer: {UNREAD_ORDERS}")
    return waiting


def refuse_little_memory() -> None:
    """Raise MemoryError where what a session imports has no room.

    CPython 3.11 that can make no object any more may handle the same exception for ever.
    """
    try:
        mmap.mmap(-1, IMPORT_SPACE).close()  # nothing is written to it
    except OSError:
        raise MemoryError from None


def debriefing() -> "DebriefSource":
    """Return the functions that judge a recording and have its debrief written.

    A session calls them. It gets them from here, because its layer must not import the debrief.
    """
    import numpy as np

    from trainer.session.exercise.marks import DebriefSource, Judgement, WrittenDebrief

    def judge(path: Path, branch: int) -> Judgement:
        from trainer.config.exercise.outcome import Outcome
        from trainer.debrief.page.page import read_dossier
        from trainer.debrief.passage.episodes import hints_told

        with np.errstate(all="ignore"):  # a state may hold any number
            debrief = read_dossier(path, branch)
        card = debrief.final
        lines = [each.told for each in card.scores if each.marks is not None]
        uncounted = tuple(each.name for each in card.scores if each.marks is None)
        times: list[float | None] = [None] * len(lines)
        hints = hints_told(debrief.trajectory)
        lines += [each.answer for each in hints]
        times += [each.tick * debrief.step for each in hints]
        lines += [f"cost most: {each.told}" for each in debrief.costs]
        times += [None if each.tick is None else each.tick * debrief.step for each in debrief.costs]
        if card.verdict is None:
            return Judgement(
                Outcome.UNDECIDED, card.total, tuple(lines), uncounted, tuple(times), debrief.aids
            )
        if card.verdict.reason:
            end = float(debrief.trajectory.seconds[-1])  # a loss ends the exercise
            lines = [card.verdict.reason, *lines]
            times = [end if card.verdict.outcome is Outcome.LOST else None, *times]
        outcome = card.verdict.outcome
        return Judgement(outcome, card.total, tuple(lines), uncounted, tuple(times), debrief.aids)

    def write(
        path: Path, branch: int, closing: "threading.Event", share: Callable[[float], object]
    ) -> WrittenDebrief:
        from trainer.session.aside import answer_aside

        whole = (*WRITER_WORDS, str(path.absolute()), str(branch))
        answer = json.loads(answer_aside(whole, closing, share))
        return WrittenDebrief(answer["page"], [tuple(each) for each in answer["minutes"]])

    evaluator, progress = "trainer.debrief.live.evaluator", "trainer.debrief.trainees.progress"
    return DebriefSource(judge, write, ("-m", evaluator), ("-m", progress))


@click.command()
@click.argument("exercise", type=EXERCISE_NAME, required=False)
@exercise_options
@time_options
@recording_options
@trainee_options
@rerun_options
@port_options(listen=f"{DEFAULT_HOST}:{DEFAULT_PORT}", socket=None)
@web_serve_options
@click.option("--until-left", is_flag=True, help="End when the last station has left.")
@class_options
def serve(*, owned: bool, **options: Any) -> None:
    """Run a session that stations join, without a console here.

    \b
    Example:  trainer serve periscope-depth --frozen --duration 1h
              trainer attach                        as instructor
              trainer station helm                  as helmsman
              trainer serve --line helm=/dev/ttyUSB0 --listen 0.0.0.0:17800 --token WORD

    It ends at --duration, by the instructor's `quit`, or by Ctrl-C, its recording complete.
    """
    if owned:
        end_with_owner()
    take_to_sea(without_console(with_pages(run_options(options))))


@click.command()
@click.argument("file", type=RECORDING_FILE, required=False)
@last_option
@time_options
@console_options
@rerun_options
@port_options(listen=None, socket=None)
@click.option("--train", is_flag=True, help="Who trains alone goes on: nothing hidden is told.")
@click.option("--instruct", is_flag=True, help="The instructor's console, whoever sat there.")
@click.option("--serve", is_flag=True, help="No console here: stations join, as with serve.")
@teletype_option
@click.option("--anyway", is_flag=True, help="Even if this version would compute otherwise.")
@class_options
def resume(
    file: Path | None, *, last: bool, anyway: bool, teletype: bool, owned: bool, **options: Any
) -> None:
    """Go on with a recorded run from its end, now or on another day.

    The boat is brought to the last order of the recording and waits there, frozen; headless, where
    nobody could say run, it goes on at once unless --frozen is given. On a terminal it shows the
    console of who sat there, who trains alone or an instructor; --train and --instruct change that.

    \b
    Example:  trainer resume drill.trainer
              trainer resume --last --train
              trainer resume drill.trainer --serve
              trainer resume drill.trainer --headless --speed max --duration 1h
    """
    if owned:
        end_with_owner()
    path = named_recording(file, last=last)
    options["frozen"] = options["frozen"] or not options["headless"]

    def go_on(chosen: RunOptions) -> NoReturn:
        from trainer.session.resume import resume_boat

        sys.exit(resume_boat(path, chosen, debriefing(), anyway=anyway))

    chosen = run_options(options)
    refuse_both(chosen)
    header = header_from(path)
    from trainer.session.past.header import ALONE_KEY, account_names, trainees_of

    if chosen.train or (ALONE_KEY in header and not chosen.instruct):
        names = trainees_of(header) or account_names()
        chosen = replace(chosen, train=True, trainee=names)
    if chosen.serve:
        go_on(without_console(chosen))
    set_out(chosen, go_on, lambda asked: asked, teletype=teletype)


def header_from(path: Path) -> Mapping[str, str]:
    """Return the header of a recording."""
    from trainer.session.past.header import open_recording

    with open_recording(path) as recording:
        return recording.header()


@click.command()
@connect_options
@teletype_option
def attach(url: str | None, token: str | None, *, teletype: bool) -> None:
    """Join a session as its instructor.

    \b
    Example:  trainer attach
              trainer attach --connect tcp://bridge:17800 --token WORD
              printf 'mark the stern planes stuck\\n' | trainer attach

    On a terminal you see the instructor's console; F1 shows its help. `detach` leaves the session
    running, `quit` ends it. One instructor has command and gives the orders. The others watch and
    set marks, until they type `take command`.
    """
    sys.exit(be(url, "instructor", token, teletype=teletype))


@click.command()
@click.argument("role", type=click.Choice(STATION_ROLES), metavar="ROLE")
@connect_options
@teletype_option
def station(role: str, url: str | None, token: str | None, *, teletype: bool) -> None:
    """Join a session as one of its crew, with your own instruments and controls.

    \b
    Example:  trainer station helm
              trainer station ballast --connect tcp://192.168.1.10:17800 --token WORD

    On a terminal you see the panel of that role. Its keys move the controls; F1 lists the keys.
    """
    sys.exit(be(url, role, token, teletype=teletype))


def be(url: str | None, role: str, token: str | None, *, teletype: bool) -> int:
    """Be a station of that role, on a screen or as a teletype. Return the exit code."""
    from trainer.console.terminal import has_terminal
    from trainer.session.stations.roles import refuse_unsayable_token

    if token:
        refuse_unsayable_token(token)
    if has_terminal() and not teletype:
        from trainer.console.launch import attend_session

        return attend_session(url, role, token)
    from trainer.session.doors.attach import attach_to

    return attach_to(url, role, token)
