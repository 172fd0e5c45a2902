"""The command ``trainer boat fit``: a boat from its trials.

``identify/boat`` computes. Here its options are read, and its results shown and written.
"""

import sys
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

import click

from trainer.cli.answers import json_of, print_note, show_progress, show_step, write_text
from trainer.cli.options import HTML_OUTPUT, TOML_OUTPUT, VESSEL_NAME, combine_options
from trainer.cli.types import File

if TYPE_CHECKING:
    from trainer.identify.boat.fit import BoatFound

FIT_KERNELS_TEXT: Final = "the kernels of fits of boats, once (up to a minute)"
TRIAL_FILE: Final = File(".trainer", ".csv")
instrument_options = combine_options(  # of what wrote the records
    click.option(
        "--columns",
        multiple=True,
        metavar="CHANNEL=HEADING[:UNIT[*SCALE[+OFFSET]]]",
        help="Where a channel is, such as --columns depth=Keel:m; may be repeated.",
    ),
    click.option(
        "--bias",
        multiple=True,
        metavar="NAME=SD",
        help="What may be off: weight [-], trim [m], pitch or roll [deg], log [-]; repeatable.",
    ),
    click.option(
        "--gauge-x", type=float, default=0.0, help="Depth gauge, ahead of the origin [m]."
    ),
    click.option("--late", type=float, default=0.0, help="Surfaces are logged late by this [s]."),
    click.option(
        "--still",
        multiple=True,
        type=click.Choice(("rudder", "stern", "bow")),
        help="A surface without a column stood at zero.",
    ),
    click.option("--coarse", is_flag=True, help="Take readings too rare; bands then hold less."),
    click.option(
        "--anyway", is_flag=True, help="Even if signs are wrong, or a fit is not settled."
    ),
)


@click.command()
@click.argument("records", type=TRIAL_FILE, nargs=-1, required=True, metavar="RECORD...")
@click.option(
    "--prior", type=VESSEL_NAME, required=True, metavar="FILE", help="The boat before: an estimate."
)
@click.option("-o", "--output", type=TOML_OUTPUT, metavar="FILE", help="Write the fitted boat so.")
@click.option(
    "--hold-out",
    type=TRIAL_FILE,
    multiple=True,
    metavar="RECORD",
    help="A record to foretell, not to fit; may be repeated.",
)
@instrument_options
@click.option(
    "--draws", type=click.IntRange(0, 2000), default=100, help="Of the coefficients, for the bands."
)
@click.option("--html", type=HTML_OUTPUT, metavar="FILE", help="Write one HTML page.")
@click.option("--json", "as_json", is_flag=True, help="Print the figures as JSON.")
def fit(**options: Any) -> None:
    """Fit a boat to records of its trials: coefficients, their deviations, gains.

    \b
    Example:  trainer boat estimate hull.toml -o own.toml
              trainer boat fit zigzag.csv dive.csv --prior own.toml -o fitted.toml
              trainer boat fit turn.csv --prior fitted.toml -o better.toml

    RECORD is a recording of ours, a CSV file or a log: rudder, stern planes, revolutions, heading,
    pitch and depth, better also the log and roll; columns are known by their names. The fitted boat
    flies at once, and may be the prior of the next fit.

    Exit code 1 when the fit does not settle: the boat is written only with --anyway.
    """
    from dataclasses import asdict

    from trainer.config.files import as_typed
    from trainer.identify.boat.page import render

    result, output = carry_out(options), options["output"]
    if options["as_json"]:
        click.echo(json_of(asdict(result.report)))
    else:
        click.echo(render(result.report))
        if output is not None and (options["anyway"] or result.is_whole):
            click.echo(f"\nnext: trainer boat check {as_typed(output)}")
    sys.exit(0 if result.report.settled or options["anyway"] else 1)


def carry_out(options: dict[str, Any]) -> "BoatFound":
    """Fit a boat as the options say, and write it where they ask for that."""
    from trainer.boat.compilation import announce_compiling
    from trainer.identify.boat.fit import check_controls, judge_boat, open_trials, search_boat
    from trainer.identify.boat.instruments import instruments_of
    from trainer.identify.boat.report import figures_count

    output: Path | None = options["output"]
    words = (options[name] for name in ("columns", "bias", "gauge_x", "late"))
    taken = {name: options[name] for name in ("coarse", "anyway", "still")}
    instruments = instruments_of(*words, **taken)
    trials = open_trials(options["prior"], options["records"], options["hold_out"], instruments)
    with announce_compiling(FIT_KERNELS_TEXT, print_note, "fits of boats", "identify/boat"):
        found = search_boat(trials, lambda step: show_step(step.steps, step.cost))
    if not options["anyway"]:
        check_controls(found)
    path = output or Path("fitted.toml")
    with show_progress(figures_count(options["draws"]), "sailing") as step:
        result = judge_boat(trials, found, path, options["draws"], step)
    if output is not None and (options["anyway"] or result.is_whole):
        write_text(output, result.text)
    elif output is not None:
        print_note(f"{output} is not written: {result.report.doubt}; --anyway writes it")
    if options["html"] is not None:
        write_text(options["html"], result.html, "--html")
    if result.lacks:
        print_note(f"{path} has no gains: {result.lacks}")
    return result
