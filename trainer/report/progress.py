"""What a program tells while it works, on stderr, and the files that it writes."""

import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

import click

from trainer.config.files import ConfigError
from trainer.io.outputs import write_whole


def print_note(text: str) -> None:
    """Print a line on stderr, so that it is no part of the answer."""
    click.echo(text, err=True)


def show_step(step: int, cost: float) -> None:
    """Show the step and cost of a fit in one line, on a terminal only."""
    if sys.stderr.isatty():
        click.echo(f"\rstep {step}, -log L {cost:.4f}  ", nl=False, err=True)


def write_text(path: Path, text: str, option: str = "") -> None:
    """Write a file whole; ConfigError, with the option that named it, if that cannot be."""
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
