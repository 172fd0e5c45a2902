"""``python -m tests.cases`` runs the acceptance tests of identification."""

import sys
from pathlib import Path

import click

sys.path.insert(0, str(Path(__file__).parents[1]))  # packages of tests/ go by their own names

from cases.selftest import run_selftest
from trainer.cli.main import run_command


@click.command()
def cases() -> None:
    """Simulate the ships of the report of 1974, identify them, and compare with ranges.

    \b
    Example:  python -m tests.cases

    Exit codes: 0 every number lies in its range, 1 one does not.
    """
    sys.exit(0 if run_selftest(click.echo) else 1)


if __name__ == "__main__":
    run_command(cases, "python -m tests.cases")
