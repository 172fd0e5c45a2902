"""The command ``trainer boat fit``: a boat from its trials.

``identify/boat`` computes. Here its options are read, and its results shown.
"""

import sys
from typing import Any, Final

import click

from trainer.cli.answers import json_of
from trainer.cli.options import combine_options, kind_option, kind_options
from trainer.cli.types import File
from trainer.config.keywords import FIT_BOAT_KEYWORDS, TRIAL_ENDINGS

TRIAL_FILE: Final = File(*TRIAL_ENDINGS)
instrument_options = combine_options(  # of what wrote the records
    kind_option(FIT_BOAT_KEYWORDS, "columns", metavar="CHANNEL=HEADING[:UNIT[*SCALE[+OFFSET]]]"),
    kind_option(FIT_BOAT_KEYWORDS, "bias", metavar="NAME=SD"),
    kind_options(FIT_BOAT_KEYWORDS, gauge_x=0.0, late=0.0),
    kind_options(FIT_BOAT_KEYWORDS, "still", "coarse", "anyway"),
)


@click.command()
@click.argument("records", type=TRIAL_FILE, nargs=-1, required=True, metavar="RECORD...")
@kind_option(FIT_BOAT_KEYWORDS, "prior", required=True, metavar="FILE")
@kind_option(FIT_BOAT_KEYWORDS, "output", "-o", "--output")
@kind_option(FIT_BOAT_KEYWORDS, "hold_out", metavar="RECORD")
@instrument_options
@kind_option(FIT_BOAT_KEYWORDS, "draws", default=100)
@kind_option(FIT_BOAT_KEYWORDS, "html")
@click.option("--json", "as_json", is_flag=True, help="Print the figures as JSON.")
def fit(*, as_json: bool, **options: Any) -> None:
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

    from trainer.api.programs import fit_boat
    from trainer.config.files import as_typed
    from trainer.identify.boat.page import render

    result, output = fit_boat(**options), options["output"]
    if as_json:
        click.echo(json_of(asdict(result.report)))
    else:
        click.echo(render(result.report))
        if output is not None and (options["anyway"] or result.is_whole):
            click.echo(f"\nnext: trainer boat check {as_typed(output)}")
    sys.exit(0 if result.report.settled or options["anyway"] else 1)
