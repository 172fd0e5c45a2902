"""The command ``trainer boat watch``: whether records are still of a boat that was fitted.

``identify/boat/watch`` computes. Here its options are read, and its result shown.
``live_watch`` is the same of a session that goes on.
"""

from typing import TYPE_CHECKING, Any, Final

import click

from trainer.cli.answers import json_of
from trainer.cli.options import VESSEL_NAME, connect_options, flags_given, kind_option
from trainer.cli.workshop.fit_boat import TRIAL_FILE, instrument_options
from trainer.config.keywords import FIT_BOAT_KEYWORDS
from trainer.report.progress import print_note

if TYPE_CHECKING:
    from collections.abc import Iterable

    from trainer.identify.boat.watch import BoatWatch

# of what wrote a record
RECORD_OPTIONS: Final = ("columns", "gauge_x", "late", "still", "coarse", "anyway")
SESSION_OPTIONS: Final = ("url", "token")


@click.command()
@click.argument("fitted", type=VESSEL_NAME, metavar="FILE")
@click.argument("records", type=TRIAL_FILE, nargs=-1, metavar="[RECORD...]")
@instrument_options
@connect_options
@kind_option(FIT_BOAT_KEYWORDS, "html")
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

    from trainer.api.programs import watch_boat
    from trainer.identify.boat.watch_page import render

    as_json, session = options.pop("as_json"), {name: options.pop(name) for name in SESSION_OPTIONS}
    if options["records"]:
        refuse_options(SESSION_OPTIONS, "is of a session, and records are given")
        report = watch_boat(**options)
    elif (last := follow_session(options, **session)) is not None:
        report = last
    else:
        print_note("it ended before anything could be said")
        return
    click.echo(json_of(asdict(report)) if as_json else render(report))


def follow_session(
    options: dict[str, Any], url: str | None, token: str | None
) -> "BoatWatch | None":
    """Watch the boat of a session to its end; return the last verdict, None without."""
    from trainer.api.programs import compiling_fits, write_watch
    from trainer.cli.workshop.live_watch import watch_session
    from trainer.identify.boat.instruments import instruments_of
    from trainer.identify.boat.watch import open_watch

    refuse_options(RECORD_OPTIONS, "is of records, and none is given")
    biases = instruments_of(bias=options["bias"]).biases
    files = open_watch(options["fitted"], ())
    with compiling_fits():
        last = watch_session(files, url, token, biases, print_note)
    if last is None:
        return None
    write_watch(options["html"], *last)
    return last[1]


def refuse_options(names: "Iterable[str]", why: str) -> None:
    """Refuse those of the options of these names that were given; ConfigError."""
    from trainer.config.files import ConfigError

    if given := flags_given(names):
        raise ConfigError(f"{given}: {why}")
