"""``python -m tests.bench`` compares the trainer with other programs, and with 1969."""

import json
import sys
from pathlib import Path

import click

sys.path.insert(0, str(Path(__file__).parents[1]))  # packages of tests/ go by their own names

from bench.sections import SECTIONS, parts_against
from trainer.analysis.bench.sections import BenchRequest, measure_sections
from trainer.cli.main import run_command
from trainer.cli.options import VESSEL_HELP, VESSEL_NAME
from trainer.config.vessel import load_vessel


@click.command()
@click.option("--vessel", type=VESSEL_NAME, default="bb2", show_default=True, help=VESSEL_HELP)
@click.option(
    "--seconds",
    type=click.IntRange(1, 3600),
    default=10,
    show_default=True,
    help="Of real time, for each loop of --beside-c.",
)
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
@click.option("--json", "as_json", is_flag=True, help="Print the figures as JSON.")
def bench(*, vessel: str, seconds: int, against: str | None, as_json: bool, **parts: bool) -> None:
    """Compare the trainer with other programs, and with the machine of 1969.

    Without an option of a part it is all of them: some minutes.

    \b
    Example:  python -m tests.bench --against-c
              python -m tests.bench --parts --against HEAD~1
              python -m tests.bench --json > figures.json
    """
    chosen = [name for name, wanted in parts.items() if wanted] or list(SECTIONS)
    sections = SECTIONS | ({"parts": parts_against(against)} if against else {})
    figures, pages = measure_sections(sections, chosen, BenchRequest(load_vessel(vessel), seconds))
    click.echo(json.dumps(figures, indent=1) if as_json else "\n\n".join(pages))


if __name__ == "__main__":
    run_command(bench, "python -m tests.bench")
