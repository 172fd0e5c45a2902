"""``python -m tests.bench`` compares the trainer with other programs, and with 1969."""

import json
import sys
from pathlib import Path

import click

sys.path.insert(0, str(Path(__file__).parents[1]))  # packages of tests/ go by their own names

from bench.sections import CLASS_BOATS, SECTIONS, BenchRequest, measure_sections, parts_against
from trainer.cli.main import run_command
from trainer.cli.options import VESSEL_HELP, VESSEL_NAME
from trainer.config.boat.vessel import load_vessel


@click.command()
@click.option("--vessel", type=VESSEL_NAME, default="bb2", show_default=True, help=VESSEL_HELP)
@click.option(
    "--seconds",
    type=click.IntRange(1, 3600),
    help="Of real time, for each loop of --on-time and --beside-c, for orders, and for --web and "
    "--class. [default: 10; 60 for --web and --class]",
)
@click.option(
    "--minutes",
    type=click.FloatRange(0.05, 1440.0),
    default=0.25,
    show_default=True,
    help="Of --on-time, for a session among all that could hold it up.",
)
@click.option("--ways", is_flag=True, help="Only the tick in three ways, and with six casualties.")
@click.option("--session", is_flag=True, help="Only a session's tick, and orders over TCP.")
@click.option("--on-time", is_flag=True, help="Only how late ticks begin, among busy processes.")
@click.option("--helm", is_flag=True, help="Only orders from serial line to instrument.")
@click.option("--against-c", is_flag=True, help="Only the tick against plain C, compiled here.")
@click.option("--beside-c", is_flag=True, help="Only how late ticks begin, beside a loop in C.")
@click.option("--same-bits", is_flag=True, help="Only whether an hour ends in the same bits.")
@click.option("--parts", is_flag=True, help="Only the tick by its parts, in a sea and in a calm.")
@click.option("--against", metavar="COMMIT", help="With the parts: the tick beside that commit's.")
@click.option("--footprint", is_flag=True, help="Only the words of machine code, beside 1969.")
@click.option("--peers", is_flag=True, help="Only the tick beside JSBSim and scipy.")
@click.option("--wasm", is_flag=True, help="Only an hour by the core for WebAssembly, in node.")
@click.option("--machines", is_flag=True, help="Only the hour on other processors, in emulators.")
@click.option("--instructions", is_flag=True, help="Only the instructions of a tick, by valgrind.")
@click.option("--waits", is_flag=True, help="Only what whole commands take of the processor.")
@click.option("--identify", is_flag=True, help="Only how fast a ship is identified.")
@click.option("--numbers", is_flag=True, help="Only what a step of a boat by numbers costs.")
@click.option("--web", is_flag=True, help="Only stations in a browser, and what they cost.")
@click.option(
    "--class",
    is_flag=False,
    flag_value=CLASS_BOATS,
    type=click.IntRange(1, 24),
    metavar="BOATS",
    help="Only a class of so many boats with stations, and what each costs; 8 unless said.",
)
@click.option("--json", "as_json", is_flag=True, help="Print the figures as JSON.")
def bench(
    *,
    vessel: str,
    seconds: int | None,
    minutes: float,
    against: str | None,
    as_json: bool,
    **parts: int | None,
) -> None:
    """Compare the trainer with other programs, with the machine of 1969, and with itself.

    Without an option of a part it is all of them: some minutes.

    \b
    Example:  python -m tests.bench --against-c
              python -m tests.bench --parts --against HEAD~1
              python -m tests.bench --json > figures.json
    """
    chosen = [name for name, wanted in parts.items() if wanted] or list(SECTIONS)
    sections = SECTIONS | ({"parts": parts_against(against)} if against else {})
    boats = parts["class"] or CLASS_BOATS
    wanted = BenchRequest(
        load_vessel(vessel), seconds or 10, minutes, attended=seconds or 60, boats=boats
    )
    figures, pages = measure_sections(sections, chosen, wanted)
    click.echo(json.dumps(figures, indent=1) if as_json else "\n\n".join(pages))


if __name__ == "__main__":
    run_command(bench, "python -m tests.bench")
