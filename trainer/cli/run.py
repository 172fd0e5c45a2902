"""Commands that take a boat to sea, and that attach to a running session."""

import sys
from dataclasses import replace
from pathlib import Path
from typing import Any, NoReturn

import click

from trainer.cli.options import run_options, without_console
from trainer.cli.shared_options import (
    FILE,
    connect_options,
    console_options,
    core_options,
    exercise_options,
    port_options,
    recording_options,
    rerun_options,
    teletype_option,
    time_options,
    trainee_options,
)
from trainer.io.paths import HOST, PORT
from trainer.session.options import RunOptions


@click.command()
@click.argument("exercise", required=False)
@exercise_options
@time_options
@console_options
@recording_options
@trainee_options
@rerun_options
@port_options(listen=None, socket=None)
@teletype_option
@core_options
def run(*, teletype: bool, core: Path | None, state: Path | None, **options: Any) -> None:
    """Run a boat in real time on a console, or headless.

    EXERCISE is the name of a shipped one (`trainer exercises`) or the path of a file; what is
    given here overrules it.

    \b
    Example:  trainer run
              trainer run periscope-depth
              trainer run --headless --duration 1h --speed max --csv out.csv
              printf 'depth 80\\n' | trainer run --duration 120 --speed max

    On a terminal it shows the instructor's console, F1 its help. Orders are typed at any time.
    Others on this machine join with `trainer station ROLE`. Exit codes: 0 done, 1 the boat
    is lost or the recording failed, 2 wrong input.
    """
    if core or state:
        from trainer.boat.export.runner.run import main as run_core  # noqa: PLC0415

        sys.exit(run_core(sys.argv[sys.argv.index("run") + 1 :]))
    from trainer.console.terminal import has_terminal  # noqa: PLC0415

    asked = run_options(options)
    elsewhere = asked.headless or asked.url is not None
    if not (teletype or elsewhere) and has_terminal():
        from trainer.console.own_session import sail  # noqa: PLC0415

        def serve_at(where: str) -> NoReturn:
            take_to_sea(replace(without_console(asked), socket=where, until_left=True))

        from trainer.session.stations.access import ANY, read_tokens  # noqa: PLC0415

        tokens = read_tokens(asked.token)
        token = tokens.get("instructor", tokens.get(ANY))
        sys.exit(sail(serve_at, asked.socket, token))
    take_to_sea(asked)


def take_to_sea(options: RunOptions) -> NoReturn:
    """Run a boat as the command line's ``options`` say, and leave with the exit code."""
    import gc  # noqa: PLC0415

    gc.disable()  # until the boat is ready: looking for garbage is a tenth of the start
    from trainer.session.first_start import prepare  # noqa: PLC0415

    note = prepare(options)  # before anything imports a kernel
    if note:
        click.echo(note, err=True)
    from trainer.session.run import run_boat  # noqa: PLC0415

    try:
        sys.exit(run_boat(replace(options, note=note)))
    finally:
        gc.enable()


@click.command()
@click.argument("exercise", required=False)
@exercise_options
@time_options
@recording_options
@trainee_options
@rerun_options
@port_options(listen=f"{HOST}:{PORT}", socket=None)
@click.option("--until-left", is_flag=True, help="End when the last station has left.")
def serve(**options: Any) -> None:
    """Run a boat for stations to attach to, without a console of its own.

    \b
    Example:  trainer serve periscope-depth --frozen --duration 1h
              trainer attach                        as instructor
              trainer station helm                  as helmsman
              trainer serve --line helm=/dev/ttyUSB0 --listen 0.0.0.0:17800 --token WORD

    It ends at --duration, by the instructor's `quit`, or by Ctrl-C, its recording complete.
    """
    take_to_sea(without_console(run_options(options)))


@click.command()
@click.argument("file", type=FILE)
@time_options
@console_options
@rerun_options
@port_options(listen=None, socket=None)
@click.option("--anyway", is_flag=True, help="Even if this version would compute otherwise.")
def resume(file: Path, *, anyway: bool, **options: Any) -> None:
    """Go on with a recorded run where it ended, after a crash or on another day.

    The boat is brought to the last order of the recording and waits there, frozen; headless, where
    nobody could say run, she goes on at once unless --frozen is given.

    \b
    Example:  trainer resume drill.trainer
              trainer resume drill.trainer --headless --speed max --duration 1h
    """
    from trainer.session.resume import resume_boat  # noqa: PLC0415

    options["frozen"] = options["frozen"] or not options["headless"]
    sys.exit(resume_boat(file, run_options(options), anyway=anyway))


ROLES = (
    "instructor",
    "helm",
    "planes",
    "pilot",
    "ballast",
    "diving",
    "observer",
)  # see stations.roles


@click.command()
@connect_options
@teletype_option
def attach(url: str | None, token: str | None, *, teletype: bool) -> None:
    """Attach to a session as its instructor.

    \b
    Example:  trainer attach
              trainer attach --connect tcp://bridge:17800 --token WORD
              printf 'casualty stern-stuck\\n' | trainer attach

    On a terminal it shows the instructor's console, F1 its help. `detach` leaves the session
    running, `quit` ends it.
    """
    sys.exit(be(url, "instructor", token, teletype=teletype))


@click.command()
@click.argument("role", type=click.Choice(ROLES))
@connect_options
@teletype_option
def station(role: str, url: str | None, token: str | None, *, teletype: bool) -> None:
    """Attach to a session as one of its crew: own instruments, own controls.

    \b
    Example:  trainer station helm
              trainer station ballast --connect tcp://192.168.1.10:17800 --token WORD

    On a terminal it shows the panel of that role; its keys move the controls, F1 lists them.
    """
    sys.exit(be(url, role, token, teletype=teletype))


def be(url: str | None, role: str, token: str | None, *, teletype: bool) -> int:
    """Be a station of that role, on a screen or as a teletype; return the exit code."""
    from trainer.console.terminal import has_terminal  # noqa: PLC0415

    if has_terminal() and not teletype:
        from trainer.console.launch import attend  # noqa: PLC0415

        return attend(url, role, token)
    from trainer.session.attach import attach_to  # noqa: PLC0415

    return attach_to(url, role, token)
