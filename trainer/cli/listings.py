"""Commands that list what is shipped and sent, and the schemas of files for editors."""

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any, Final

import click

from trainer.cli.options import EXERCISE_NAME, TOML_FILE
from trainer.cli.types import Commands

MAX_LINE_COLUMNS: Final = 79  # [columns] of a line at most
as_json_option = click.option("--json", "as_json", is_flag=True, help="Print the list as JSON.")


@click.command()
@as_json_option
def exercises(*, as_json: bool) -> None:
    """List the shipped exercises, in the order of the course.

    \b
    Example:  trainer exercises
    """
    from trainer.config.course import course

    titles = {lesson.name: lesson.title for lesson in course()}
    lines = [f"{name:24}{title}" for name, title in titles.items()]
    click.echo(json.dumps(titles, indent=1) if as_json else "\n".join(lines))


@click.command()
@as_json_option
def vessels(*, as_json: bool) -> None:
    """List the shipped boats: their length, their sets of equations, what they are.

    \b
    Example:  trainer vessels

    A file of your own is not listed: give its path, such as ./boat.toml, wherever a name is asked
    for. `trainer check VESSEL` tells more.
    """
    from trainer.config.files import shipped_tables

    rows = {name: vessel_row(table) for name, table in shipped_tables("vessels").items()}
    lines = [
        f"{name:10}{row['length_m']:7g} m  "
        f"{'full and compact set' if row['compact_set'] else 'full set alone':22}{row['name']}"
        for name, row in rows.items()
    ]
    print_rows(rows, lines, as_json=as_json)


def vessel_row(table: Mapping[str, Any]) -> dict[str, Any]:
    """Return the facts of a vessel's file that are listed: lengths in metres."""
    return {
        "name": table["name"],
        "kind": table["kind"],
        "length_m": table["vessel"]["length"],
        "compact_set": "modified" in table.get("compensation", {}),
    }


@click.command()
@as_json_option
def seas(*, as_json: bool) -> None:
    """List the shipped seas: their sea state by WMO code 3700, and its name.

    \b
    Example:  trainer seas

    A file of your own is not listed: give its path, such as ./storm.toml, to --sea.
    `trainer sea SEA` shows the waves of one.
    """
    from trainer.config.files import shipped_tables

    rows = {
        name: {"name": table["name"], "sea_state": table["sea"]["sea_state"]}
        for name, table in shipped_tables("seas").items()
    }
    lines = [
        f"{name:14}sea state {row['sea_state']:g}  {row['name']}" for name, row in rows.items()
    ]
    print_rows(rows, lines, as_json=as_json)


def print_rows(rows: Mapping[str, Any], lines: list[str], *, as_json: bool) -> None:
    """Print what is listed as JSON, or as lines that fit an ordinary terminal."""
    shown = [
        line if len(line) <= MAX_LINE_COLUMNS else f"{line[: MAX_LINE_COLUMNS - 4].rstrip()} ..."
        for line in lines
    ]
    click.echo(json.dumps(rows, indent=1) if as_json else "\n".join(shown))


@click.group(cls=Commands)
def exercise() -> None:
    """Make an exercise of your own: a file to begin with, and its check.

    \b
    Example:  trainer exercise new drill.toml --from stern-plane-jam
              trainer exercise check drill.toml
              trainer run drill.toml
    """


@exercise.command()
@click.argument("file", type=TOML_FILE)
@click.option("--name", help="One line for the list.")
@click.option(
    "--from", "source", type=EXERCISE_NAME, metavar="EXERCISE", help="Copy a shipped one."
)
def new(file: Path, name: str | None, source: str | None) -> None:
    """Write a valid exercise with comments, to be changed; never over another file.

    \b
    Example:  trainer exercise new drill.toml --name "Lost in the fog"
              trainer exercise new jam.toml --from stern-plane-jam
    """
    from trainer.analysis.exercise_page import write_new

    write_new(file, name, source)


@exercise.command()
@click.argument("file", type=EXERCISE_NAME)
def check(file: str) -> None:
    """Say what is wrong with an exercise, or else what it is.

    \b
    Example:  trainer exercise check drill.toml

    FILE is a path, or the name of a shipped exercise. It is flown with nobody aboard and with its
    reference crew. Exit code 2 when something is wrong, each mistake with its line.
    """
    from trainer.analysis import exercise_page

    click.echo("\n".join(exercise_page.check_exercise(file)))


@exercise.command()
@click.argument("file", type=EXERCISE_NAME)
@click.option("--seeds", type=click.IntRange(1, 1000), default=20, show_default=True)
def baseline(file: str, seeds: int) -> None:
    """Fly an exercise with nobody aboard and with its reference crew. Keep their marks beside it.

    \b
    Example:  trainer exercise baseline depth-changes
              trainer exercise baseline ./drill.toml --seeds 5

    FILE is a path, or the name of a shipped exercise. The debrief takes from each task what it
    gives with nobody aboard. What is kept is drill.baseline.toml, beside drill.toml.
    """
    from trainer.analysis import exercise_page

    study = exercise_page.study_exercise(file, seeds)
    click.echo("\n".join(exercise_page.baseline_lines(study)))
    click.echo(f"kept in {exercise_page.save_baseline(study)}")


@click.command()
@click.argument("tables", type=TOML_FILE, nargs=-1, metavar="[FILE]...")
@as_json_option
def casualties(tables: tuple[Path, ...], *, as_json: bool) -> None:
    """List what can break, from the shipped table and from files of your own.

    \b
    Example:  trainer casualties
    """
    from trainer.config import casualties as casualties_module

    loaded = casualties_module.load_casualties(*map(str, tables))
    listing = casualties_module.listing(loaded)
    click.echo(json.dumps(casualties_module.as_json(loaded), indent=1) if as_json else listing)


@click.command()
@click.option("--sample", is_flag=True, help="Print one set, of the bb2 in trim.")
@click.option("--json", "as_json", is_flag=True, help="Print it as JSON.")
def instruments(*, sample: bool, as_json: bool) -> None:
    """List the NMEA 0183 sentences sent by `--nmea`: their fields, units and sources.

    \b
    Example:  trainer instruments --sample
              trainer run --nmea udp://127.0.0.1:10110
              trainer serve --nmea /dev/ttyUSB0 --nmea-baud 4800 --nmea-sentences HDT,XDR,ROT
    """
    from trainer.config.vessel import load_vessel
    from trainer.session.nmea import page as nmea_page

    if sample:
        lines = nmea_page.sample(load_vessel("bb2"))
        click.echo(json.dumps(lines, indent=1) if as_json else "\n".join(lines))
        return
    click.echo(json.dumps(nmea_page.as_json(), indent=1) if as_json else nmea_page.page())
