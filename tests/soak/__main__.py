"""``python -m tests.soak`` keeps a session under load and audits what the trainer promises."""

import sys
from pathlib import Path

import click

sys.path.insert(0, str(Path(__file__).parents[1]))  # packages of tests/ go by their own names

from helpers.progress import Bar, as_json

from soak import stress as stressing
from soak.soak import Plan, page, soaked_as_json
from soak.soak import soak as soak_session
from trainer.cli.main import run_command
from trainer.cli.options import RECORDING_FILE


@click.command()
@click.option(
    "--hours",
    type=click.FloatRange(0.01, 1000.0),
    default=24.0,
    show_default=True,
    help="Of exercise time, at full speed.",
)
@click.option("--real-time", is_flag=True, help="By the clock instead, for --minutes.")
@click.option(
    "--minutes",
    type=click.FloatRange(0.1, 10_000.0),
    default=30.0,
    show_default=True,
    help="Of the clock, with --real-time.",
)
@click.option("--seed", type=click.IntRange(0, 2**31 - 1), default=1, show_default=True)
@click.option("--keep", type=RECORDING_FILE, default=None, help="Keep the recording in this file.")
@click.option(
    "--stress",
    type=click.IntRange(1),
    default=None,
    metavar="N",
    help="Instead give N orders to each boat by each set within --hours.",
)
@click.option("--json", "json", is_flag=True, help="Print the findings as JSON.")
def soak(
    *,
    hours: float,
    real_time: bool,
    minutes: float,
    seed: int,
    keep: Path | None,
    stress: int | None,
    json: bool,
) -> None:
    """Keep a session under random orders, seas, casualties and visitors, and audit its promises.

    \b
    Example:  python -m tests.soak
              python -m tests.soak --real-time --minutes 30
              python -m tests.soak --stress 2000 --hours 10

    Exit codes: 0 every promise kept, 1 one is broken.
    """
    if stress:
        sys.exit(stress_boats(stress, hours, seed, json=json))
    plan = Plan(60.0 * minutes if real_time else 3600.0 * hours, real_time, seed)
    with Bar("soaking", plan.ticks) as bar:
        findings = soak_session(plan, keep, bar.at)
    click.echo(soaked_as_json(findings) if json else page(findings))
    sys.exit(0 if findings.kept else 1)


def stress_boats(orders: int, hours: float, seed: int, *, json: bool) -> int:
    """Stress every boat by every set, and print the findings. Return the exit code."""
    findings = []
    if not json:
        click.echo(stressing.HEAD)
    for boat in stressing.stress(orders, hours, seed):
        findings.append(boat)
        if not json:
            click.echo(stressing.row(boat))
    if json:
        click.echo(as_json(findings))
    return 0 if all(boat.kept for boat in findings) else 1


if __name__ == "__main__":
    run_command(soak, "python -m tests.soak")
