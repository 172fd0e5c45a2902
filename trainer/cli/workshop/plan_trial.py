"""The command ``trainer boat plan-trial``: what to sail next.

``identify/boat/plan`` computes. Here its options are read, and its exercise written.
"""

from pathlib import Path
from typing import Final

import click

from trainer.cli.options import TOML_OUTPUT, VESSEL_NAME
from trainer.cli.types import Number
from trainer.report.progress import print_note, show_progress, write_text

MINUTES_TYPE: Final = Number(0.0, 240.0, min_open=True)


@click.command()
@click.argument("prior", type=VESSEL_NAME, metavar="FILE")
@click.option("--minutes", type=MINUTES_TYPE, default=15.0, show_default=True, help="Its length.")
@click.option("--room", metavar="LENGTH", help="Of its track, such as 2000m. [default: any]")
@click.option("--depth", metavar="FROM:TO", help="To be kept [m], such as 40:120.")
@click.option(
    "--figure",
    "figures",
    multiple=True,
    metavar="WORDS",
    help="To narrow, such as diameter; may be repeated. [default: all]",
)
@click.option("-o", "--output", type=TOML_OUTPUT, metavar="FILE", help="Write it as an exercise.")
def plan_trial(
    prior: str,
    minutes: float,
    room: str | None,
    depth: str | None,
    figures: tuple[str, ...],
    output: Path | None,
) -> None:
    """Find the trial that tells most of a boat: turns, zig-zags, an acceleration.

    \b
    Example:  trainer boat estimate hull.toml -o own.toml
              trainer boat plan-trial own.toml --minutes 15 -o trial.toml
              trainer boat plan-trial own.toml --room 2000m --figure diameter

    FILE is an estimate or a fit. Its own boat sails each choice of legs, and the one is taken after
    which figures of turns and zig-zags should be surest. Beside it stands a plain zig-zag 20/20.
    """
    from trainer.api.programs import compiling_fits
    from trainer.config.files import as_typed
    from trainer.identify.boat.plan import figure_slopes, find_plan, open_question, slopes_count
    from trainer.identify.boat.planned_trial import exercise_text, render_plan

    asked = open_question(prior, minutes, room, depth)
    with show_progress(slopes_count(asked.prior), "figures") as step:
        slopes = figure_slopes(asked.prior, step).chosen(figures)
    with compiling_fits():
        plan = find_plan(asked, slopes, print_note)
    if output is not None:
        write_text(output, exercise_text(plan, output))
    click.echo(render_plan(plan))
    if output is not None:
        click.echo(f"\nnext: trainer run {as_typed(output)} --headless --record trial.trainer")
