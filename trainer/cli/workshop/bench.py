"""The command that measures the trainer on this machine.

``analysis/bench`` measures; the command chooses the parts and prints them. That package is imported
in the function, because the other commands need none of it.
"""

import click

from trainer.cli.options import VESSEL_HELP, VESSEL_NAME


@click.command()
@click.option("--vessel", type=VESSEL_NAME, default="bb2", help=VESSEL_HELP)
@click.option(
    "--seconds",
    type=click.IntRange(1, 3600),
    help="Of real time for each step, recorded and not, and for the orders over TCP; --latency "
    "gives four in each. [default: 10]",
)
@click.option("--on-time", is_flag=True, help="Only how late ticks begin, among busy processes.")
@click.option(
    "--minutes",
    type=click.FloatRange(0.05, 1440.0),
    default=0.25,
    help="Of --on-time, for a session among all that could hold it up.",
)
@click.option("--latency", is_flag=True, help="Only how soon an order is seen at an instrument.")
@click.option("--starting", is_flag=True, help="Only how soon commands answer.")
@click.option("--all", "everything", is_flag=True, help="All of it: some minutes.")
@click.option("--json", "as_json", is_flag=True, help="Print the figures as JSON.")
def bench(
    vessel: str,
    seconds: int | None,
    *,
    minutes: float,
    everything: bool,
    as_json: bool,
    **parts: bool,
) -> None:
    """Measure duty cycle, work per tick, lateness and sizes on this machine.

    \b
    Example:  trainer dev bench --json
              trainer dev bench --on-time --minutes 10
              trainer dev bench --all --json > figures.json
    """
    import json
    from dataclasses import asdict

    from trainer.config.boat.vessel import load_vessel

    file = load_vessel(vessel)
    chosen = [name for name, wanted in parts.items() if wanted or everything]
    figures, pages = {}, []
    if everything or not chosen:
        from trainer.analysis.bench.bench import bench_boat as measure
        from trainer.analysis.bench.bench import render

        standard = measure(file, seconds or 10)
        pages.append(render(standard))
        figures["standard"] = asdict(standard)
    if chosen:
        from trainer.analysis.bench.sections import SECTIONS, BenchRequest, measure_sections

        wanted = BenchRequest(file, seconds or 10, minutes)
        more_figures, more_pages = measure_sections(SECTIONS, chosen, wanted)
        figures |= more_figures
        pages += more_pages
    tree = figures if chosen else figures["standard"]
    click.echo(json.dumps(tree, indent=1) if as_json else "\n\n".join(pages))
