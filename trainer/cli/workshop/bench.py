"""The command that measures the trainer on this machine, by ``analysis/bench``."""

from typing import Any

import click

from trainer.cli.options import VESSEL_HELP, VESSEL_NAME


@click.command()
@click.option("--vessel", type=VESSEL_NAME, default="bb2", help=VESSEL_HELP)
@click.option(
    "--seconds",
    type=click.IntRange(1, 3600),
    default=10,
    help="Of real time for each run; --latency gives four orders in each. [default: 10]",
)
@click.option("--latency", is_flag=True, help="Only how soon an order is seen at a page.")
@click.option("--starting", is_flag=True, help="Only how soon commands answer.")
@click.option("--all", "everything", is_flag=True, help="All of it: some minutes.")
@click.option("--json", "as_json", is_flag=True, help="Print the figures as JSON.")
def bench(vessel: str, seconds: int, *, everything: bool, as_json: bool, **parts: bool) -> None:
    """Measure duty cycle, work per tick and lateness on this machine.

    \b
    Example:  trainer dev bench --json
              trainer dev bench --all --json > figures.json
    """
    import json
    from dataclasses import asdict

    from trainer.analysis.bench import delays, ticks
    from trainer.config.boat.vessel import load_vessel
    from trainer.config.extras import require_library

    file = load_vessel(vessel)
    measures: dict[str, Any] = {
        "standard": (lambda: ticks.time_duty(file, seconds), ticks.lines),
        "latency": (lambda: delays.time_page(file, seconds), delays.order_lines),
        "starting": (delays.time_starts, delays.start_lines),
    }
    wanted = [name for name in measures if everything or parts.get(name)] or ["standard"]
    if "latency" in wanted:
        require_library("websockets", "trainer dev bench --latency")
    figures, pages = {}, []
    for name in wanted:
        click.echo(f"measuring: {name.replace('_', ' ')}", err=True)
        measure, lines = measures[name]
        measured = measure()
        figures[name] = asdict(measured)
        pages.append("\n".join(lines(measured)))
    tree = figures if any(parts.values()) or everything else figures["standard"]
    click.echo(json.dumps(tree, indent=1) if as_json else "\n\n".join(pages))
