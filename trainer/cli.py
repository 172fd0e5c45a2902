"""The command line. Commands import what they need when they run, so that help comes at once."""

import os
import sys
from importlib import metadata
from pathlib import Path
from typing import Any, NoReturn

import click

from trainer import __version__
from trainer.arguments import Commands, Duration, Speed
from trainer.config import ConfigError

VESSEL_HELP = "bb2, sdv-mk9, remus100, or the path of a vessel file"
LIBRARIES = ("numpy", "numba", "pyserial", "click")
EQUATIONS = ("full", "modified", "basic", "longitudinal")


def versions() -> str:
    """Return this version and those of the libraries underneath."""
    libraries = [f"{name} {metadata.version(name)}" for name in LIBRARIES]
    return "\n".join([f"trainer {__version__}", f"python {sys.version.split()[0]}", *libraries])


def print_versions(ctx: click.Context, _param: click.Parameter, value: bool) -> None:  # noqa: FBT001
    """Print the versions and leave."""
    if value and not ctx.resilient_parsing:
        click.echo(versions())
        ctx.exit()


@click.group(cls=Commands, context_settings={"help_option_names": ["-h", "--help"]})
@click.option(
    "--version",
    is_flag=True,
    is_eager=True,
    expose_value=False,
    callback=print_versions,
    help="Print the versions and leave.",
)
def cli() -> None:
    """Train the crew of a simulated submarine, in real time.

    \b
    trainer run                      take a 70 m submarine to sea, now
    trainer run periscope-depth      an exercise; `trainer exercises` lists them
    trainer run --headless --duration 1h --speed max --csv out.csv
    trainer check bb2                what a vessel file is worth, and at which step
    """


METHOD = [
    click.option(
        "--equations",
        type=click.Choice(EQUATIONS),
        default="modified",
        show_default=True,
        help="Full set (1)-(7), compact modified or basic, or the vertical plane alone.",
    ),
    click.option(
        "--rates",
        type=click.Choice(("exact", "lagged")),
        default=None,
        help="Accelerations by the 6x6 solve, or each from its own equation with last "
        "cycle's. [default: lagged; exact with Runge-Kutta]",
    ),
    click.option(
        "--trig",
        type=click.Choice(("exact", "report")),
        default="exact",
        show_default=True,
        help="Exact, or the 1969 approximations of the compact sets.",
    ),
]


def method_options(command: Any) -> Any:
    """Add the options that say how a boat is computed."""
    for option in reversed(METHOD):
        command = option(command)
    return command


@cli.command()
@click.argument("exercise", required=False)
@click.option("--vessel", default="bb2", show_default=True, help=VESSEL_HELP)
@method_options
@click.option(
    "--sea", default=None, metavar="NAME|PATH", help="calm, sea-state-1 to sea-state-6, or a file."
)
@click.option(
    "--integrator",
    default="adams2",
    show_default=True,
    help="euler, adams2, best2, adams3, rk4, rkv, or a multistep method as 'a=1;b=1.5,-0.5'.",
)
@click.option(
    "--step", type=float, default=None, help="Step in s. [default: the vessel file's, 0.5 for bb2]"
)
@click.option("--unsafe-step", is_flag=True, help="Run even where the step is not stable.")
@click.option(
    "--seed",
    type=click.IntRange(0, 2**53 - 1),
    default=1,
    show_default=True,
    help="Of everything random.",
)
@click.option(
    "--duration",
    type=Duration(),
    default=None,
    help="Simulated time: 120, 10m, 1h. [default: until quit]",
)
@click.option(
    "--speed", type=Speed(), default="1", show_default=True, help="Of time: 0.1 to 100, or max."
)
@click.option(
    "--overrun",
    type=click.Choice(("catch-up", "slip", "freeze")),
    default="catch-up",
    show_default=True,
    help="What happens when a tick ends too late.",
)
@click.option("--headless", is_flag=True, help="No console; a progress bar and a summary.")
@click.option(
    "--serial",
    "url",
    default=None,
    metavar="URL",
    help="Console on this pyserial port or URL instead of the terminal.",
)
@click.option(
    "--baud",
    type=click.IntRange(50, 4_000_000),
    default=9600,
    show_default=True,
    help="Of the serial port.",
)
@click.option(
    "--orders",
    "orders_file",
    type=click.Path(path_type=Path),
    default=None,
    help="Scheduled orders, a line each: SECONDS ORDER.",
)
@click.option(
    "--csv",
    "csv_path",
    type=click.Path(path_type=Path),
    default=None,
    help="Write the state of each tick to this file.",
)
def run(**options: Any) -> None:
    """Run a boat in real time on a console, or headless.

    EXERCISE is the name of a shipped one (`trainer exercises`) or the path of a file; what is
    given here overrules it.

    \b
    Example:  trainer run
              trainer run periscope-depth
              trainer run --headless --duration 1h --speed max --csv out.csv
              printf 'depth 80\\n' | trainer run --duration 120 --speed max

    Orders are typed at any time; `help` lists them. Exit codes: 0 done, 1 the boat's numbers
    or the recording failed, 2 wrong input.
    """
    from click.core import ParameterSource  # noqa: PLC0415

    from trainer.run import run_boat  # noqa: PLC0415

    source = click.get_current_context().get_parameter_source
    given = (name for name in options if source(name) is not ParameterSource.DEFAULT)
    options["given"] = frozenset(given)
    sys.exit(run_boat(options))


@cli.command()
@click.option("--json", "as_json", is_flag=True, help="Print the list as JSON.")
def exercises(*, as_json: bool) -> None:
    """List the shipped exercises.

    \b
    Example:  trainer exercises
    """
    import json  # noqa: PLC0415

    from trainer.config import shipped_names  # noqa: PLC0415
    from trainer.exercise_file import load_exercise  # noqa: PLC0415

    found = {name: load_exercise(name).heading.name for name in shipped_names("exercises")}
    lines = [f"{name:24}{title}" for name, title in found.items()]
    click.echo(json.dumps(found, indent=1) if as_json else "\n".join(lines))


@cli.command()
@click.argument("tables", nargs=-1, metavar="[FILE]...")
@click.option("--json", "as_json", is_flag=True, help="Print the list as JSON.")
def casualties(tables: tuple[str, ...], *, as_json: bool) -> None:
    """List what can break, from the shipped table and from files of your own.

    \b
    Example:  trainer casualties
    """
    import json  # noqa: PLC0415

    from trainer import casualty_file  # noqa: PLC0415

    found = casualty_file.load_casualties(*tables)
    listing = casualty_file.listing(found)
    click.echo(json.dumps(casualty_file.as_json(found), indent=1) if as_json else listing)


@cli.command()
@click.argument("vessel")
@method_options
def evaluate(vessel: str, equations: str, rates: str | None, trig: str) -> None:
    """Accelerations for states read as JSON lines: the check interface.

    \b
    Example:  trainer evaluate bb2 --equations full --rates exact < states.jsonl

    Each line of input is an object with u v w p q r phi theta psi delta_r delta_s delta_b u_c
    (SI, rad), optionally x_g y_g z_g weight and last_udot ... last_rdot; each line of output
    the twelve rates.
    """
    from trainer.study.evaluate import evaluate as rates_of  # noqa: PLC0415
    from trainer.vessel_file import load_vessel  # noqa: PLC0415

    file = load_vessel(vessel)
    for line in rates_of(file, equations, rates or "exact", trig, sys.stdin or ()):
        click.echo(line)


@cli.command()
@click.argument("vessel")
@click.option("--json", "as_json", is_flag=True, help="Print the figures as JSON.")
def check(vessel: str, *, as_json: bool) -> None:
    """Say what a vessel file lacks, how the boat behaves, and which step is stable.

    \b
    Example:  trainer check bb2

    Exit code 1 when a step of 0.5 s or 1 s makes a boat unstable that is stable by nature.
    """
    import json  # noqa: PLC0415
    from dataclasses import asdict  # noqa: PLC0415

    from trainer.study.check import check as examine  # noqa: PLC0415
    from trainer.study.check_page import render  # noqa: PLC0415
    from trainer.vessel_file import load_vessel  # noqa: PLC0415

    report = examine(load_vessel(vessel))
    click.echo(json.dumps(asdict(report), indent=1) if as_json else render(report))
    sys.exit(0 if report.stable else 1)


@cli.command()
@click.option("--vessel", default="bb2", show_default=True, help=VESSEL_HELP)
@click.option(
    "--seconds",
    type=click.IntRange(1, 3600),
    default=10,
    show_default=True,
    help="Of real time for each step.",
)
@click.option("--json", "as_json", is_flag=True, help="Print the figures as JSON.")
def bench(vessel: str, seconds: int, *, as_json: bool) -> None:
    """Measure duty cycle, work per tick, lateness and sizes on this machine.

    \b
    Example:  trainer bench --json
    """
    import json  # noqa: PLC0415
    from dataclasses import asdict  # noqa: PLC0415

    from trainer.study.bench import bench as measure  # noqa: PLC0415
    from trainer.study.bench_page import render  # noqa: PLC0415
    from trainer.vessel_file import load_vessel  # noqa: PLC0415

    figures = measure(load_vessel(vessel), seconds)
    click.echo(json.dumps(asdict(figures), indent=1) if as_json else render(figures))


@cli.command()
@click.argument("vessel")
def gains(vessel: str) -> None:
    """Design the autopilot of a boat and print the table for its vessel file.

    \b
    Example:  trainer gains my-boat.toml >> my-boat.toml
    """
    from trainer.study.gains import design_text  # noqa: PLC0415
    from trainer.vessel_file import load_vessel  # noqa: PLC0415

    click.echo(design_text(load_vessel(vessel)))


def keep_standard_streams() -> None:
    """Put the null device where one is closed, or the next file opened would take its number."""
    while (descriptor := os.open(os.devnull, os.O_RDWR)) <= 2:
        pass
    os.close(descriptor)


def fail(code: int, *lines: str) -> NoReturn:
    """Say why on stderr and leave with that exit code."""
    for line in lines:
        click.echo(f"trainer: {line}", err=True)
    sys.exit(code)


def main() -> None:
    """Run the command line; what the user got wrong is told on stderr, exit code 2."""
    keep_standard_streams()
    try:
        sys.exit(cli(prog_name="trainer", standalone_mode=False))
    except ConfigError as wrong:
        fail(2, *str(wrong).splitlines())
    except click.UsageError as wrong:
        path = wrong.ctx.command_path if wrong.ctx else "trainer"
        fail(2, f"{wrong.format_message()} ({path} --help says more)")
    except click.Abort:
        fail(130, "interrupted")
    except OSError as lost:  # the disk behind the output is full; click handles a closed pipe
        fail(1, str(lost.strerror))
