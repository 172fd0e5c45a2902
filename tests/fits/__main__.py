"""``python -m tests.fits`` writes the wave filter's tables as they stand in the core."""

import sys
from pathlib import Path

import click

sys.path.insert(0, str(Path(__file__).parents[1]))  # packages of tests/ go by their own names

from fits.force_rows import all_numbers, all_rows
from trainer.cli.main import run_command
from trainer.core.kernel import Numbers

NUMBERS_PER_LINE = 4


def lines(name: str, table: Numbers) -> list[str]:
    """Return a table of the core as text, in rows of numbers."""
    rows = table.reshape(-1, NUMBERS_PER_LINE if table.shape[-1] % NUMBERS_PER_LINE == 0 else 1)
    return [f"{name} {table.shape}", *(" ".join(repr(float(x)) for x in row) for row in rows)]


@click.command()
def fits() -> None:
    """Write the force rows of the wave filter, and the wave numbers that are left.

    \b
    Example:  python -m tests.fits
    """
    click.echo("\n".join([*lines("_FORCE", all_rows()), *lines("LENGTHS", all_numbers())]))


if __name__ == "__main__":
    run_command(fits, "python -m tests.fits")
