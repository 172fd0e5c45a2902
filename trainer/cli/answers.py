"""How the engineer's programs show their result: as a page, as JSON, as a plot.

A command makes a record and hands it to ``show_report`` with the functions that draw it, so that
``--json`` and ``--plot`` mean the same for every program.
"""

import os
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
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


def print_note(text: str) -> None:
    """Print a line on stderr, so that it is no part of the answer."""
    click.echo(text, err=True)


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


def show_step(step: int, cost: float) -> None:
    """Show the step and cost of a fit in one line, on a terminal only."""
    if sys.stderr.isatty():
        click.echo(f"\rstep {step}, -log L {cost:.4f}  ", nl=False, err=True)


def write_text(path: Path, text: str, option: str = "") -> None:
    """Write a file whole; ConfigError, with the option that named it, if that cannot be."""
    from trainer.config.files import ConfigError
    from trainer.io.outputs import write_whole

    try:
        write_whole(path, text)
    except OSError as error:
        named = f"{option} {path}".lstrip()
        raise ConfigError(f"{named}: cannot be written: {error.strerror}") from None


@contextmanager
def show_progress(length: int, label: str) -> Iterator[Callable[[int], None]]:
    """Show a progress bar on stderr, if a terminal; yield what moves it."""
    hidden = not sys.stderr.isatty()
    with click.progressbar(length=length, label=label, file=sys.stderr, hidden=hidden) as shown:
        yield shown.update
