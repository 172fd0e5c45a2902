"""The command line: its commands, its versions, and its messages about errors.

``main`` is the program ``trainer``. A user's mistake (ConfigError, UsageError) ends in one line on
stderr and exit code 2; what the machine lacks, such as room on a disk or memory, in one line and
exit code 1.
"""

import io
import os
import sys
from typing import Final, NoReturn

import click

from trainer import __version__
from trainer.cli.moved import name_successor
from trainer.cli.types import Commands, text_option

SHOWN_LIBRARIES = ("numpy", "numba", "pyserial", "click", "textual")
IDENTIFY_PLACE: Final = "trainer.cli.workshop.identify.identify"
# A command is named by its place, and imported when it is typed or listed.
COMMAND_GROUPS: Final = (
    Commands(
        "boat",
        places=(
            "trainer.cli.listings.vessels",
            "trainer.cli.workshop.vessel.new",
            "trainer.cli.workshop.estimate.estimate",
            "trainer.cli.workshop.fit_boat.fit",
            "trainer.cli.workshop.plan_trial.plan_trial",
            "trainer.cli.workshop.watch_boat.watch",
            "trainer.cli.workshop.vessel.check",
            "trainer.cli.workshop.vessel.plant",
            "trainer.cli.workshop.guide.manoeuvre",
            "trainer.cli.workshop.guide.guide",
            "trainer.cli.workshop.vessel.reduce",
            "trainer.cli.workshop.vessel.gains",
            "trainer.cli.workshop.vessel.evaluate",
            "trainer.cli.workshop.sweep.sweep",
            "trainer.cli.workshop.vessel.sea",
            "trainer.cli.workshop.check_cases.check_cases",
            "trainer.cli.export.export_core",
            "trainer.cli.export.export_fmu",
            "trainer.cli.export.export_page",
        ),
        help="""Make a boat of your own, judge it, fly its manoeuvres, export it.

        \b
        Example:  trainer boat new boat.toml --from bb2 --length 60
                  trainer boat check boat.toml
        """,
    ),
    Commands(
        "ship",
        places=(
            IDENTIFY_PLACE,
            "trainer.cli.workshop.identify.prbs",
            "trainer.cli.workshop.identify.decca",
            "trainer.cli.workshop.identify.steering",
        ),
        help="""Find the steering of a ship from recordings of it.

        \b
        Example:  trainer ship steering bb2 --speed 10
        """,
    ),
    Commands(
        "report-1969",
        places=(
            "trainer.cli.workshop.programs.neutral",
            "trainer.cli.workshop.programs.thrust",
            "trainer.cli.workshop.programs.tanks",
            "trainer.cli.workshop.programs.modes",
            "trainer.cli.workshop.programs.compare",
            "trainer.cli.workshop.programs.fit",
        ),
        help="""Run the engineer's programs of the report of 1969.

        \b
        Example:  trainer report-1969 modes bb2 --speed 10
        """,
    ),
    Commands(
        "dev",
        places=(
            "trainer.cli.workshop.bench.bench",
            "trainer.cli.workshop.learn.learn",
            "trainer.cli.conform.conform",
            "trainer.cli.listings.instruments",
            "trainer.cli.schema.schema",
        ),
        help="""Measure this machine; print what standards, plotters and editors ask for.

        \b
        Example:  trainer dev schema exercise -o exercise.schema.json
        """,
    ),
)
COMMAND_SECTIONS: Final = {
    "Train": (
        "trainer.cli.run.run",
        "trainer.cli.run.serve",
        "trainer.cli.classroom.class_command",
        "trainer.cli.run.attach",
        "trainer.cli.run.station",
        "trainer.cli.web.web",
    ),
    "Exercises": (
        "trainer.cli.listings.exercises",
        "trainer.cli.listings.exercise",
        "trainer.cli.listings.casualties",
        "trainer.cli.listings.seas",
    ),
    "Recordings": (
        "trainer.cli.recordings.debrief",
        "trainer.cli.recordings.recordings",
        "trainer.cli.run.resume",
        "trainer.cli.recordings.replay",
        "trainer.cli.recordings.export",
    ),
    "Ships": (IDENTIFY_PLACE,),
    "More": (*COMMAND_GROUPS, "trainer.cli.explain.help_command"),
}
# fmt: off
UNGROUPED_NAMES: Final = frozenset({  # typed before there were groups: a new command is none
    "bench", "check", "check-cases", "compare", "conform", "decca", "estimate", "evaluate",
    "export-core", "export-fmu", "export-page", "fit", "gains", "guide", "instruments",
    "manoeuvre", "modes", "neutral", "prbs", "reduce", "schema", "sea", "steering", "sweep",
    "tanks", "thrust", "vessels",
})
# fmt: on
# By what was typed then, and goes on for good: what is typed now.
EARLIER_NAMES: Final = {"vessel": "boat"} | {
    name: f"{group.name} {name}"
    for group in COMMAND_GROUPS
    for name in group.commands
    if name in UNGROUPED_NAMES
}


def versions() -> str:
    """Return this version and those of the libraries underneath."""
    from importlib import metadata

    libraries = [f"{name} {metadata.version(name)}" for name in SHOWN_LIBRARIES]
    return "\n".join([f"trainer {__version__}", f"python {sys.version.split()[0]}", *libraries])


HELP_SETTINGS: Final = {"help_option_names": ["-h", "--help"], "show_default": True}


@click.group(cls=Commands, context_settings=HELP_SETTINGS)
@text_option("--version", versions, "Print the versions and exit.")
def cli() -> None:
    """Train the crew of a simulated submarine, in real time.

    \b
    Example:  trainer run                  take a 70 m submarine to sea, now
              trainer run periscope-depth  an exercise; `trainer exercises` lists them
              trainer run --headless --duration 1h --speed max --csv out.csv
              trainer boat check bb2       what a vessel file is worth, and at which step
    """


for title, commands in COMMAND_SECTIONS.items():
    cli.add_section(title, commands)
cli.earlier_names = EARLIER_NAMES


def keep_standard_streams() -> None:
    """Open the null device for each closed standard stream, as services and cron leave them.

    Otherwise the next file that is opened would take its number, and get its output. Python has
    None for such a stream, which knows neither ``write`` nor ``isatty``.
    """
    # The system gives the lowest free number: 0, 1 and 2 are the standard streams.
    while (descriptor := os.open(os.devnull, os.O_RDWR)) <= 2:
        pass
    os.close(descriptor)
    for name, mode in (("stdin", "r"), ("stdout", "w"), ("stderr", "w")):
        if getattr(sys, name) is None:
            stream = open(os.devnull, mode, encoding="utf-8")  # noqa: PTH123, SIM115
            setattr(sys, name, stream)
            setattr(sys, f"__{name}__", stream)


def show_any_name() -> None:
    """Make stdout show any file name, with codes for what it cannot encode."""
    if isinstance(sys.stdout, io.TextIOWrapper):
        sys.stdout.reconfigure(errors="backslashreplace")


def leave_with(code: int, *lines: str) -> NoReturn:
    """Print lines on stderr, and end with an exit code."""
    from trainer.io.lines import fit_terminal, plain

    for line in lines:
        click.echo(fit_terminal(f"trainer: {plain(line)}"), err=True)
    sys.exit(code)


def memory_limit() -> str:
    """Return the limit of memory and how to raise it, "" without a limit."""
    try:
        import resource
    except ImportError:
        return ""
    limit, _ = resource.getrlimit(resource.RLIMIT_AS)
    if limit == resource.RLIM_INFINITY:
        return ""
    return f"; this process may have {limit / 1e6:.0f} MB (ulimit -v {limit // 1024}): give it more"


def cause_of(lost: OSError) -> str:
    """Return the cause of an OSError: its file, if any, and the system's words."""
    name = "" if lost.filename is None else f"{lost.filename}: "
    if lost.strerror:
        return f"{name}{lost.strerror}"
    return f"{name}{str(lost) or type(lost).__name__}".removesuffix(".")


def main() -> None:
    """Run the command line."""
    keep_standard_streams()
    gone = name_successor(sys.argv[1:])
    if gone:
        leave_with(2, gone)
    run_command(cli, "trainer")


def run_command(command: click.Command, name: str) -> NoReturn:
    """Run a command. A user's mistake is a line on stderr and exit code 2."""
    show_any_name()
    limit = memory_limit()  # now, because it needs memory itself
    try:
        sys.exit(command(prog_name=name, standalone_mode=False))
    except ValueError as wrong:
        from trainer.config.files import ConfigError

        if not isinstance(wrong, ConfigError):
            raise
        leave_with(2, *str(wrong).splitlines())
    except click.UsageError as wrong:
        path = wrong.ctx.command_path if wrong.ctx else name
        message = " ".join(wrong.format_message().split())  # choices have a line each
        leave_with(2, f"{message} ({path} --help says more)")
    except click.Abort:
        leave_with(130, "interrupted")
    except OSError as lost:  # the disk behind the output is full; click handles a closed pipe
        # Without the system's words a library was not loaded, most likely for lack of memory.
        leave_with(1, f"{cause_of(lost)}{'' if lost.strerror else limit}")
    except (MemoryError, ImportError, SystemError) as lack:
        if not (limit or isinstance(lack, MemoryError)):
            raise  # a fault of this program: its developers need the whole trace
        cause = str(lack) if isinstance(lack, ImportError) else "out of memory"
        # Not by ``leave_with``, which imports a module, and that takes memory.
        click.echo(f"trainer: {cause}{limit}", err=True)
        sys.exit(1)
