"""The command ``trainer boat watch``: whether records are still of a boat that was fitted.

``identify/boat/watch`` computes. Here its options are read, and its result shown and written.
``live_watch`` is the same of a session that goes on.
"""

from typing import TYPE_CHECKING, Any, Final

import click

from trainer.cli.answers import json_of, print_note, show_progress, write_text
from trainer.cli.options import HTML_OUTPUT, VESSEL_NAME, connect_options, flags_given
from trainer.cli.workshop.fit_boat import FIT_KERNELS_TEXT, TRIAL_FILE, instrument_options

if TYPE_CHECKING:
    from collections.abc import Iterable
    from pathlib import Path

    from trainer.identify.boat.watch import BoatWatch, WatchFiles

RECORD_OPTIONS: Final = ("columns", "gauge_x", "late", "coarse", "anyway")  # of what wrote a record
SESSION_OPTIONS: Final = ("url", "token")


@click.command()
@click.argument("fitted", type=VESSEL_NAME, metavar="FILE")
@click.argument("records", type=TRIAL_FILE, nargs=-1, metavar="[RECORD...]")
@instrument_options
@connect_options
@click.option("--html", type=HTML_OUTPUT, metavar="FILE", help="Write one HTML page.")
@click.option("--json", "as_json", is_flag=True, help="Print the figures as JSON.")
def watch(**options: Any) -> None:
    """Tell from when on records are no longer of a fitted boat, and why.

    \b
    Example:  trainer boat fit zigzag.csv dive.csv --prior own.toml -o fitted.toml
              trainer boat watch fitted.toml monday.csv tuesday.csv
              trainer boat watch fitted.toml --connect tcp://bridge:17800 --token WORD

    FILE is what trainer boat fit wrote. RECORD is as there; several are one after the other in
    time. Parts are lift of rudder and planes, drag, thrust, weight, trim, zeros and gauges. Without
    RECORD it watches a session that runs, and tells its instructor. Ctrl-C ends that.
    """
    from dataclasses import asdict

    from trainer.identify.boat.watch_page import render

    report = carry_out(options) if options["records"] else follow_session(options)
    if report is None:
        print_note("it ended before anything could be said")
        return
    click.echo(json_of(asdict(report)) if options["as_json"] else render(report))


def carry_out(options: dict[str, Any]) -> "BoatWatch":
    """Watch a boat by records as the options say, and write its page."""
    from trainer.boat.compilation import announce_compiling
    from trainer.identify.boat.instruments import instruments_of
    from trainer.identify.boat.watch import open_watch, watch_boat

    refuse_options(SESSION_OPTIONS, "is of a session, and records are given")
    words = (options[name] for name in ("columns", "bias", "gauge_x", "late"))
    taken = {name: options[name] for name in ("coarse", "anyway", "still")}
    instruments = instruments_of(*words, **taken)
    files = open_watch(options["fitted"], options["records"], instruments)
    with (
        announce_compiling(FIT_KERNELS_TEXT, print_note, "fits of boats", "identify/boat"),
        show_progress(files.windows, "watching") as step,
    ):
        report = watch_boat(files, step)
    write_page(options["html"], files, report)
    return report


def follow_session(options: dict[str, Any]) -> "BoatWatch | None":
    """Watch the boat of a session to its end; return the last verdict, None without."""
    from trainer.boat.compilation import announce_compiling
    from trainer.cli.workshop.live_watch import watch_session
    from trainer.identify.boat.instruments import instruments_of
    from trainer.identify.boat.watch import open_watch

    refuse_options(RECORD_OPTIONS, "is of records, and none is given")
    biases = instruments_of((), options["bias"]).biases
    files, place = open_watch(options["fitted"], ()), (options["url"], options["token"])
    with announce_compiling(FIT_KERNELS_TEXT, print_note, "fits of boats", "identify/boat"):
        last = watch_session(files, *place, biases, print_note)
    if last is None:
        return None
    write_page(options["html"], *last)
    return last[1]


def refuse_options(names: "Iterable[str]", why: str) -> None:
    """Refuse those of the options of these names that were given; ConfigError."""
    from trainer.config.files import ConfigError

    if given := flags_given(names):
        raise ConfigError(f"{given}: {why}")


def write_page(path: "Path | None", files: "WatchFiles", report: "BoatWatch") -> None:
    """Write the page of a watch, if a path is given."""
    from trainer.identify.boat.watch_page import html_page

    if path is not None:
        write_text(path, html_page(files, report), "--html")
