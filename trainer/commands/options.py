"""Options that several commands share."""

from pathlib import Path
from typing import Any, Final

import click

from trainer.places import HOST, PORT

VESSEL_HELP: Final = "bb2, sdv-mk9, remus100, or the path of a vessel file"
EQUATIONS: Final = ("full", "modified", "basic", "longitudinal")

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


PORTS = [
    click.option(
        "--line",
        "lines",
        multiple=True,
        metavar="ROLE=URL",
        help="A station on a serial port or pyserial URL; may be given again.",
    ),
    click.option(
        "--listen",
        default=None,
        metavar="HOST:PORT",
        help=f"Let stations in by TCP, such as {HOST}:{PORT}.",
    ),
    click.option(
        "--socket",
        type=click.Path(path_type=Path),
        default=None,
        help="Let stations in at this local socket.",
    ),
    click.option("--token", default=None, help="Word that stations at sockets have to give."),
]


def port_options(command: Any) -> Any:
    """Add the options that say where stations are."""
    for option in reversed(PORTS):
        command = option(command)
    return command


def method_options(command: Any) -> Any:
    """Add the options that say how a boat is computed."""
    for option in reversed(METHOD):
        command = option(command)
    return command
