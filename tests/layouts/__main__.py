"""``python -m tests.layouts`` plays commands over recordings of any layout, by seeds."""

import shutil
import sys
import tempfile
from pathlib import Path

import click

sys.path.insert(0, str(Path(__file__).parents[1]))  # packages of tests/ go by their own names

from layouts.machine import play


@click.command()
@click.option("--seeds", type=click.IntRange(1), default=300, show_default=True)
@click.option("--first", type=click.IntRange(0), default=0, show_default=True)
def layouts(*, seeds: int, first: int) -> None:
    r"""Play commands over recordings of any layout; look for one that is ruined.

    \b
    Example:  python -m tests.layouts --seeds 300

    Exit codes: 0 every law holds, 1 one is broken.
    """
    commands = refused = broken = 0
    with tempfile.TemporaryDirectory(prefix="trainer-l-", ignore_cleanup_errors=True) as folder:
        for seed in range(first, first + seeds):
            desk = Path(folder) / f"{seed}" / "desk"
            desk.mkdir(parents=True)
            played = play(seed, desk)
            shutil.rmtree(desk.parent, ignore_errors=True)  # a session's judge may still read there
            commands += len(played.given) - 1
            refused += played.refused
            broken += bool(played.wrong)
            for wrong in played.wrong:
                click.echo(f"seed {seed}: {wrong}")
    click.echo(f"{seeds} seeds, {commands} commands, {refused} refused: {broken} seeds break a law")
    sys.exit(1 if broken else 0)


if __name__ == "__main__":
    layouts()
