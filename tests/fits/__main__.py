"""``python -m tests.fits`` writes the wave filter's tables as they stand in the core."""

import sys
from pathlib import Path

import click

sys.path.insert(0, str(Path(__file__).parents[1]))  # packages of tests/ go by their own names

from fits.force_rows import all_numbers, all_rows
from fits.strips import strip_lines
from trainer.cli.main import run_command
from trainer.core.kernel import Numbers

NUMBERS_PER_LINE = 4


def lines(name: str, table: Numbers) -> list[str]:
    """Return a table of the core as text, in rows of numbers."""
    rows = table.reshape(-1, NUMBERS_PER_LINE if table.shape[-1] % NUMBERS_PER_LINE == 0 else 1)
    return [f"{name} {table.shape}", *(" ".join(repr(float(x)) for x in row) for row in rows)]


@click.command()
@click.option("--strips", is_flag=True, help="Write the filter's push over the strips' sum.")
def fits(*, strips: bool) -> None:
    """Write the force rows of the wave filter, and the wave numbers that are left.

    \b
    Example:  python -m tests.fits
              python -m tests.fits --strips
    """
    if strips:
        click.echo("rms of heave and pitch, their mean frequencies: now; by strips' own phases")
        click.echo("\n".join(strip_lines()))
        return
    click.echo("\n".join([*lines("_FORCE", all_rows()), *lines("LENGTHS", all_numbers())]))


if __name__ == "__main__":
    run_command(fits, "python -m tests.fits")
