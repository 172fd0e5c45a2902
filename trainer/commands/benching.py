"""The command that measures the trainer on this machine, whole or by parts."""

import click

from trainer.commands.options import VESSEL_HELP


@click.command()
@click.option("--vessel", default="bb2", show_default=True, help=VESSEL_HELP)
@click.option(
    "--seconds",
    type=click.IntRange(1, 3600),
    default=10,
    show_default=True,
    help="Of real time for each step, recorded and not, and for the orders over TCP; --latency "
    "gives four in each.",
)
@click.option("--against-c", is_flag=True, help="Only the tick against plain C, compiled here.")
@click.option("--side-by-side", is_flag=True, help="Only how fast many boats are flown at once.")
@click.option("--same-bits", is_flag=True, help="Only whether an hour ends in the same bits.")
@click.option("--footprint", is_flag=True, help="Only the words of machine code, beside 1969.")
@click.option("--peers", is_flag=True, help="Only the tick beside JSBSim and scipy.")
@click.option("--exported", is_flag=True, help="Only what a run on an exported core takes.")
@click.option("--on-time", is_flag=True, help="Only how late ticks begin, among busy processes.")
@click.option(
    "--minutes",
    type=click.FloatRange(0.05, 1440.0),
    default=0.25,
    show_default=True,
    help="Of --on-time, for a session among all that could hold it up.",
)
@click.option("--latency", is_flag=True, help="Only how soon an order is seen at an instrument.")
@click.option("--starting", is_flag=True, help="Only how soon commands answer.")
@click.option("--identify", is_flag=True, help="Only how fast a ship is identified.")
@click.option("--all", "everything", is_flag=True, help="All of it: some minutes.")
@click.option("--json", "as_json", is_flag=True, help="Print the figures as JSON.")
def bench(
    vessel: str, seconds: int, *, minutes: float, everything: bool, as_json: bool, **parts: bool
) -> None:
    """Measure duty cycle, work per tick, lateness and sizes on this machine.

    \b
    Example:  trainer bench --json
              trainer bench --against-c
              trainer bench --on-time --minutes 10
              trainer bench --all --json > figures.json
    """
    import json  # noqa: PLC0415
    from dataclasses import asdict  # noqa: PLC0415

    from trainer.files.vessel_file import load_vessel  # noqa: PLC0415

    file = load_vessel(vessel)
    chosen = [name for name, wanted in parts.items() if wanted or everything]
    found, pages = {}, []
    if everything or not chosen:
        from trainer.study.bench import bench as measure  # noqa: PLC0415
        from trainer.study.bench_page import render  # noqa: PLC0415

        figures = measure(file, seconds)
        pages.append(render(figures))
        found["standard"] = asdict(figures)
    if chosen:
        from trainer.commands.bench_sections import SECTIONS, Wanted  # noqa: PLC0415

        for name in chosen:
            answer = SECTIONS[name].measure(Wanted(file, seconds, minutes))
            pages.append("\n".join(SECTIONS[name].lines(answer)).strip())
            found[name] = asdict(answer)
    tree = found if chosen else found["standard"]
    click.echo(json.dumps(tree, indent=1) if as_json else "\n\n".join(pages))
