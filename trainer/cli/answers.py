"""How the engineer's programs show their result: as a page, as JSON, as a plot.

A command makes a record and hands it to ``show_report`` with the functions that draw it, so that
``--json`` and ``--plot`` mean the same for every program.
"""

import os
import sys
from collections.abc import Callable
from typing import Any, Final

import click

from trainer.cli.options import combine_options
from trainer.cli.types import Output

PLOT_OUTPUT: Final = Output(".png", ".svg", ".pdf", dir_okay=False)
outputs = combine_options(  # how the answer is shown
    click.option("--json", "as_json", is_flag=True, help="Print the figures as JSON."),
    click.option(
        "--plot",
        type=PLOT_OUTPUT,
        metavar="FILE",
        help="Draw a plot, .png, .svg or .pdf by the name's ending.",
    ),
)


def json_of(value: Any) -> str:
    """Return a value as JSON; an infinite number, or nan, is null."""
    from trainer.config.files import json_text

    return json_text(value, indent=1)


def show_report(
    report: Any,
    page: Callable[[Any], str],
    panels: Callable[[], tuple[Any, ...]],
    how: dict[str, Any],
) -> None:
    """Draw the plot asked for. Print ``report`` as a page or as JSON."""
    from dataclasses import asdict

    if how["plot"]:
        from trainer.report.plots import draw_plot

        draw_plot(panels(), how["plot"])
    click.echo(json_of(asdict(report)) if how["as_json"] else page(report))


def input_waits() -> bool:
    """Return whether words wait at the standard input, a pipe or a file.

    They are left there, because in a shell's loop they are the input of the next rounds.
    """
    if sys.platform == "win32":  # which cannot tell
        return False
    import fcntl
    import termios

    try:
        return not os.isatty(0) and fcntl.ioctl(0, termios.FIONREAD, bytes(4)) != bytes(4)
    except OSError:  # closed, or no pipe and no file
        return False
