"""Commands that take a boat to sea."""

import sys
from pathlib import Path
from typing import Any

import click

from trainer.arguments import Duration, Speed
from trainer.commands.options import VESSEL_HELP, method_options, port_options


@click.command()
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
@click.option("--frozen", is_flag=True, help="Start with time frozen, until the order run.")
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
@click.option(
    "--record",
    type=click.Path(path_type=Path),
    default=None,
    help="Keep the whole run in this file. [default: a file of its own, unless headless or "
    "at --speed max]",
)
@click.option("--no-record", is_flag=True, help="Keep nothing.")
@port_options
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
