"""Commands that take a boat to sea."""

import sys
from pathlib import Path
from typing import Any, Final, NoReturn

import click

from trainer.commands.options import (
    FILE,
    console_options,
    core_options,
    exercise_options,
    port_options,
    recording_options,
    rerun_options,
    teletype_option,
    time_options,
)
from trainer.places import HOST, PORT

# what a session without a console of its own is told, beside what its user says
SERVED: Final[dict[str, Any]] = {"headless": True, "url": None, "serve": True}


def given() -> frozenset[str]:
    """Return the options that the user gave, by name."""
    from click.core import ParameterSource  # noqa: PLC0415

    context = click.get_current_context()
    source = context.get_parameter_source
    return frozenset(name for name in context.params if source(name) is not ParameterSource.DEFAULT)


@click.command()
@click.argument("exercise", required=False)
@exercise_options
@time_options
@console_options
@recording_options
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
    Others on this machine join with `trainer station ROLE`. Exit codes: 0 done, 1 the boat's
    numbers or the recording failed, 2 wrong input.
    """
    if core or state:
        from trainer.bare.run import main as run_core  # noqa: PLC0415

        sys.exit(run_core(sys.argv[sys.argv.index("run") + 1 :]))
    from trainer.screen.terminal import has_terminal  # noqa: PLC0415

    elsewhere = options["headless"] or options["url"] is not None
    if not (teletype or elsewhere) and has_terminal():
        from trainer.screen.voyage import sail  # noqa: PLC0415

        def serve_at(where: str) -> NoReturn:
            take_to_sea({**options, **SERVED, "socket": where, "until_left": True})

        from trainer.stations.door import ANY, read_tokens  # noqa: PLC0415

        tokens = read_tokens(options["token"])
        token = tokens.get("instructor", tokens.get(ANY))
        sys.exit(sail(serve_at, options["socket"], token))
    take_to_sea({**options, "serve": False})


def take_to_sea(options: dict[str, Any]) -> NoReturn:
    """Run a boat as the command line's ``options`` say, and leave with the exit code."""
    import gc  # noqa: PLC0415

    gc.disable()  # until the boat is ready: looking for garbage is a tenth of the start
    from trainer.first_start import prepare  # noqa: PLC0415

    note = prepare(options, given())  # before anything imports a kernel
    if note:
        click.echo(note, err=True)
    from trainer.run import run_boat  # noqa: PLC0415

    try:
        sys.exit(run_boat({**options, "given": given(), "note": note}))
    finally:
        gc.enable()


@click.command()
@click.argument("exercise", required=False)
@exercise_options
@time_options
@recording_options
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
    take_to_sea({**options, **SERVED})


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
    from trainer.records.resume import resume_boat  # noqa: PLC0415

    options["frozen"] = options["frozen"] or not options["headless"]
    sys.exit(resume_boat(file, {**options, "serve": False, "note": ""}, anyway=anyway))
