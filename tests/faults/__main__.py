"""``python -m tests.faults`` tries every fault on purpose, or opens damaged recordings."""

import sys
from pathlib import Path

import click

sys.path.insert(0, str(Path(__file__).parents[1]))  # packages of tests/ go by their own names

from helpers.progress import as_json

from faults.faults import HEAD, fault_row, try_all
from faults.recordings import try_damage
from trainer.cli.main import run_command


@click.command()
@click.option(
    "--kills",
    type=click.IntRange(1),
    default=1000,
    show_default=True,
    help="Sessions killed; every other fault is tried in proportion.",
)
@click.option(
    "--damaged",
    type=click.IntRange(1),
    default=None,
    metavar="N",
    help="Instead damage N recordings, and open them by every command.",
)
@click.option("--seed", type=click.IntRange(0, 2**31 - 1), default=1, show_default=True)
@click.option("--json", "json", is_flag=True, help="Print the findings as JSON.")
def faults(*, kills: int, damaged: int | None, seed: int, json: bool) -> None:
    """Kill sessions, fill disks, pull plugs, set the clock; look for orders that are lost.

    \b
    Example:  python -m tests.faults --kills 100
              python -m tests.faults --damaged 2000

    Exit codes: 0 every promise kept, 1 one is broken.
    """
    findings = []
    if not json:
        click.echo(HEAD)
    for tried in try_damage(damaged, seed) if damaged else try_all(kills, seed):
        findings.append(tried)
        if not json:  # it takes hours: each row is printed when it is known
            click.echo(fault_row(tried))
    if json:
        click.echo(as_json(findings))
    sys.exit(1 if any(tried.wrong for tried in findings) else 0)


if __name__ == "__main__":
    run_command(faults, "python -m tests.faults")
