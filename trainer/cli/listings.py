"""Commands that list what is shipped and sent, and that make and check an exercise.

``main`` has them. Each prints lines that fit a terminal, or with ``--json`` the same for programs.
"""

import json
import math
import sys
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

import click

from trainer.cli.answers import json_of
from trainer.cli.options import EXERCISE_NAME, HTML_OUTPUT, TOML_FILE, TOML_OUTPUT, cores_option
from trainer.cli.types import Commands, Output
from trainer.report.progress import show_progress, write_text

if TYPE_CHECKING:
    from trainer.config.exercise.course import Lesson

MAX_LINE_COLUMNS: Final = 79  # [columns] of a line at most
as_json_option = click.option("--json", "as_json", is_flag=True, help="Print the list as JSON.")


@click.command()
@as_json_option
def exercises(*, as_json: bool) -> None:
    """List the shipped lessons and exercises, in the order of the course.

    \b
    Example:  trainer exercises

    Each has its place in the course, its title, its length, how many stations share it, and what
    they work by hand. As JSON the exercises alone are listed, because lessons have no marks.
    """
    from trainer.config.exercise.course import course, lessons

    if as_json:
        click.echo(json.dumps({each.name: each.title for each in course()}, indent=1))
        return
    for heading, listed in (
        ("Lessons, step by step, for one person alone:", lessons()),
        (f"{'Exercises, easy ones first:':52}length, stations, by hand", course()),
    ):
        click.echo("\n".join((heading, *map(exercise_line, listed), "")))
    click.echo(
        "Stations: helm (rudder, speed), planes, ballast. The rest is automatic.\n"
        "Alone, take all of them: trainer run NAME --train. A crew: trainer serve NAME."
    )


def exercise_line(each: "Lesson") -> str:
    """Return name, number, title, length, number of stations and what is in hand, in columns."""
    number = "" if math.isinf(each.number) else f"{each.number:g}"
    title = each.title.removeprefix(f"Lesson {number}: ")
    in_hand = each.in_hand.replace(", ", ",")
    return f"{each.name:20}{number:>2} {title:28}{each.length:>7} {len(each.stations)} {in_hand}"


@click.command()
@as_json_option
def vessels(*, as_json: bool) -> None:
    """List the shipped boats: their length, their sets of equations, what they are.

    \b
    Example:  trainer boat vessels

    A file of your own is not listed: give its path, such as ./boat.toml, wherever a name is asked
    for. `trainer boat check VESSEL` tells more.
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
    `trainer boat sea SEA` shows the waves of one.
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
@click.argument("file", type=TOML_OUTPUT)
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
    from trainer.authoring.exercise_page import write_new

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
    from trainer.authoring import exercise_page

    click.echo("\n".join(exercise_page.check_exercise(file)))


@exercise.command()
@click.argument("file", type=EXERCISE_NAME)
@click.option("--seeds", type=click.IntRange(1, 1000), default=20)
def baseline(file: str, seeds: int) -> None:
    """Fly an exercise with nobody aboard and with its reference crew. Keep their marks beside it.

    \b
    Example:  trainer exercise baseline depth-changes
              trainer exercise baseline ./drill.toml --seeds 5

    FILE is a path, or the name of a shipped exercise. The debrief takes from each task what it
    gives with nobody aboard. What is kept is drill.baseline.toml, beside drill.toml.
    """
    from trainer.authoring import exercise_page

    study = exercise_page.study_exercise(file, seeds)
    click.echo("\n".join(exercise_page.baseline_lines(study)))
    click.echo(f"kept in {exercise_page.save_baseline(study)}")


@exercise.command()
@click.argument("names", type=EXERCISE_NAME, nargs=-1, metavar="[NAME]...")
@click.option("--seeds", type=click.IntRange(1, 1000), default=10, show_default=True)
@click.option("--html", type=HTML_OUTPUT, metavar="FILE", help="Write the evidence as a page.")
@click.option("--json", "as_json", is_flag=True, help="Print the figures as JSON.")
@click.option("--people", is_flag=True, help="Have model people fly too, each of them twice.")
@click.option("--keep", is_flag=True, help="Keep their figures in the baselines, for debriefs.")
@cores_option
def validate(
    names: tuple[str, ...], seeds: int, html: Path | None, cores: int | None, **how: bool
) -> None:
    """Say whether the marks of exercises order skill, by graded and by silly crews.

    \b
    Example:  trainer exercise validate stern-plane-jam --seeds 3
              trainer exercise validate ./drill.toml --html drill.validation.html
              trainer exercise validate stern-plane-jam --seeds 1 --people

    NAME is a path, or the name of a shipped exercise; without one all shipped ones are flown, which
    takes minutes. Exit code 1 when the marks of an exercise do not order skill.
    """
    import trainer
    from trainer.authoring import people as model_people
    from trainer.authoring.validation import (
        exercise_text,
        summary_text,
        validate_exercises,
        validation_data,
        validation_page,
    )
    from trainer.workers import processor_count

    chosen, found = tuple(dict.fromkeys(names or trainer.exercises())), []
    cores, marks = cores or processor_count(), {}
    if how["keep"]:
        model_people.kept_baselines(chosen)
    with show_progress(seeds * len(chosen), "flying") as step:
        for each in validate_exercises(chosen, seeds, cores, step):
            found.append(each)
            if not how["as_json"]:
                click.echo(exercise_text(each))
    data, chapters, said = validation_data(found), [], [summary_text(found)]
    if how["people"] or how["keep"]:
        with show_progress(model_people.SITTINGS * len(chosen), "flying people") as step:
            marks = model_people.fly_people(chosen, cores, step)
        data["people"] = people = model_people.people_data(marks)
        chapters = [model_people.people_section(found, people)]
        said.append(model_people.people_text(found, people))
    if html is not None:
        write_text(html, validation_page(found, data, chapters), "--html")
    if how["keep"]:
        model_people.keep_people(marks)
    click.echo(json_of(data) if how["as_json"] else "\n\n".join(said))
    sys.exit(1 if any(each.faults for each in found) else 0)


@exercise.command()
@click.argument("file", type=EXERCISE_NAME)
@click.option("--peer", is_flag=True, help="For who sat beside the trainee, not for an assessor.")
@click.option("-o", "--output", type=Output(".html", ".toml"), required=True)
def form(file: str, output: Path, *, peer: bool) -> None:
    """Write an exercise's evaluation form: a page to print, or TOML to fill in.

    \b
    Example:  trainer exercise form stern-plane-jam -o form.html
              trainer exercise form stern-plane-jam --peer -o jones.toml

    `trainer debrief FILE --form jones.toml` keeps a filled one beside the recording, and lays its
    marks beside the program's.
    """
    from trainer.debrief.marks.forms import form_page, form_text
    from trainer.session.past.options import RunOptions
    from trainer.session.past.plan import plan_run

    plan, kind = plan_run(RunOptions(exercise=file)), "peer" if peer else "assessor"
    write_text(output, (form_page if output.suffix == ".html" else form_text)(plan, kind), "-o")
    click.echo(output)


@click.command()
@click.argument("tables", type=TOML_FILE, nargs=-1, metavar="[FILE]...")
@as_json_option
def casualties(tables: tuple[Path, ...], *, as_json: bool) -> None:
    """List what can break, from the shipped table and from files of your own.

    \b
    Example:  trainer casualties
    """
    from trainer.config.boat import casualties as casualties_module

    loaded = casualties_module.load_casualties(*map(str, tables))
    listing = casualties_module.listing(loaded)
    click.echo(json.dumps(casualties_module.as_json(loaded), indent=1) if as_json else listing)


@click.command()
@click.option("--sample", is_flag=True, help="Print one set, of the bb2 in trim.")
@click.option("--json", "as_json", is_flag=True, help="Print it as JSON.")
def instruments(*, sample: bool, as_json: bool) -> None:
    """List the NMEA 0183 sentences sent by `--nmea`: their fields, units and sources.

    \b
    Example:  trainer dev instruments --sample
              trainer run --nmea udp://127.0.0.1:10110
              trainer serve --nmea /dev/ttyUSB0 --nmea-baud 4800 --nmea-sentences HDT,XDR,ROT
    """
    from trainer.config.boat.vessel import load_vessel
    from trainer.session.nmea import page as nmea_page

    if sample:
        lines = nmea_page.sample(load_vessel("bb2"))
        click.echo(json.dumps(lines, indent=1) if as_json else "\n".join(lines))
        return
    click.echo(json.dumps(nmea_page.as_json(), indent=1) if as_json else nmea_page.page())
