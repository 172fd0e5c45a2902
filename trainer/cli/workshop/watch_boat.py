"""The command ``trainer boat watch``: whether records are still of a boat that was fitted.

``identify/boat/watch`` computes. Here its options are read, and its result shown and written.
"""

from typing import TYPE_CHECKING, Any

import click

from trainer.cli.answers import json_of, print_note, show_progress, write_text
from trainer.cli.options import HTML_OUTPUT, VESSEL_NAME
from trainer.cli.workshop.fit_boat import FIT_KERNELS_TEXT, TRIAL_FILE, instrument_options

if TYPE_CHECKING:
    from trainer.identify.boat.watch import BoatWatch


@click.command()
@click.argument("fitted", type=VESSEL_NAME, metavar="FILE")
@click.argument("records", type=TRIAL_FILE, nargs=-1, required=True, metavar="RECORD...")
@instrument_options
@click.option("--html", type=HTML_OUTPUT, metavar="FILE", help="Write one HTML page.")
@click.option("--json", "as_json", is_flag=True, help="Print the figures as JSON.")
def watch(**options: Any) -> None:
    """Tell from when on records are no longer of a fitted boat, and why.

    \b
    Example:  trainer boat fit zigzag.csv dive.csv --prior own.toml -o fitted.toml
              trainer boat watch fitted.toml monday.csv tuesday.csv

    FILE is what trainer boat fit wrote. RECORD is as there; several are one after the other in
    time. Parts are lift of rudder and planes, drag, thrust, weight, trim, zeros and gauges.
    """
    from dataclasses import asdict

    from trainer.identify.boat.watch_page import render

    report = carry_out(options)
    click.echo(json_of(asdict(report)) if options["as_json"] else render(report))


def carry_out(options: dict[str, Any]) -> "BoatWatch":
    """Watch a boat as the options say, and write the page if asked for."""
    from trainer.boat.compilation import announce_compiling
    from trainer.identify.boat.instruments import instruments_of
    from trainer.identify.boat.watch import open_watch, watch_boat
    from trainer.identify.boat.watch_page import html_page

    words = (options[name] for name in ("columns", "bias", "gauge_x", "late"))
    files = open_watch(options["fitted"], options["records"], instruments_of(*words))
    with (
        announce_compiling(FIT_KERNELS_TEXT, print_note, "fits of boats", "identify/boat"),
        show_progress(files.windows, "watching") as step,
    ):
        report = watch_boat(files, step)
    if options["html"] is not None:
        write_text(options["html"], html_page(files, report), "--html")
    return report
