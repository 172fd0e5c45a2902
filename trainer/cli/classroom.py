"""The command ``trainer class``: one instructor, many boats; the file of a class; its debrief.

Each boat is a session of its own (``trainer serve``), which the class begins and keeps at sea.
"""

import secrets
import socket
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

import click

from trainer.cli.options import (
    CSV_OUTPUT,
    EXERCISE_NAME,
    TOML_FILE,
    TOML_OUTPUT,
    WEB_ADDRESS,
    cores_option,
    flags_given,
    kind_option,
    page_options,
)
from trainer.cli.types import Number, ParentCommand
from trainer.cli.web import require_pages
from trainer.config.files import ConfigError, is_path, path_named
from trainer.config.keywords import RUN_KEYWORDS, fill_record
from trainer.report.progress import print_note

if TYPE_CHECKING:
    from trainer.classroom.launch import ClassSite
    from trainer.config.exercise.class_file import ClassFile

FOLDER_PATH: Final = click.Path(file_okay=False, path_type=Path)
CLASS_OPTIONS: Final = ("boats", "on", "seed", "own_seeds", "one_sea")  # that a class file says
boats_option = click.option("--boats", type=int, default=3, metavar="N", help="How many, 1 to 24.")


@click.command(cls=ParentCommand)
@click.argument("exercise", type=EXERCISE_NAME, required=False)
@boats_option
@click.option(
    "--on",
    multiple=True,
    metavar="URL",
    help="One boat more, whose session runs there (trainer serve); may be given again.",
)
@kind_option(RUN_KEYWORDS, "seed", default=1, text="seed of the random numbers of every boat")
@click.option(
    "--one-sea",
    type=Number(0.0, 5000.0),
    metavar="METRES",
    help="All boats in one sea, each so far east of the one before.",
)
@click.option("--own-seeds", is_flag=True, help="Each boat has one more than the boat before.")
@click.option(
    "--token",
    multiple=True,
    metavar="[ROLE=]WORD",
    help="Word that who comes has to give, of one role or of all; may be given again.",
)
@click.option(
    "--web",
    default=WEB_ADDRESS,
    metavar="HOST:PORT",
    help="Where the pages are; beyond this machine only with --token.",
)
@page_options
@click.option(
    "--folder", type=FOLDER_PATH, help="Of recordings. [default: in the recordings' folder]"
)
@click.option("--resume", type=FOLDER_PATH, help="Go on with the class kept in this folder.")
def class_command(
    exercise: str | None, token: tuple[str, ...], resume: Path | None, **options: Any
) -> None:
    """Begin a class: one instructor, many boats, each a session of its own.

    EXERCISE is an exercise, or the class file that `trainer class new FILE` writes and `trainer
    class check FILE` reads; a class file says boats and seeds itself.

    \b
    Example:  trainer class periscope-depth --boats 8 --web 0.0.0.0:8080 --token WORD
              trainer class tuesday.toml
              trainer class --resume FOLDER

    The pages have one address: each trainee says his name and comes to his boat, and the
    instructor's page, at /class, shows all boats. All begin frozen. One that dies is resumed from
    its recording, and the others notice nothing. Ctrl-C ends all in order; then --resume has all
    boats where they were. Exit codes: 0 ended, 1 no boat could go to sea, 2 wrong input.
    """
    if not hasattr(socket, "AF_UNIX"):
        raise ConfigError("a class needs local sockets: use Linux or macOS")
    if (exercise is None) is (resume is None):
        raise click.UsageError("name an exercise or a class file, or say --resume FOLDER")
    require_pages("trainer class")
    from trainer.classroom import launch

    refuse_new_plan(resume)
    site = fill_record(launch.ClassSite, options)
    words = words_of_class(token, site)
    if resume is not None:
        sys.exit(launch.resume_class(resume, words, site))
    planned = plan_class(exercise or "", **options)
    sys.exit(launch.begin_class(planned, options["folder"], words, site))


def refuse_new_plan(resume: Path | None) -> None:
    """Raise ConfigError for options that a class which goes on has in its file already."""
    from trainer.config.exercise.class_file import CLASS_FILE_NAME

    if resume is not None and (given := flags_given((*CLASS_OPTIONS, "folder"))):
        kept = resume / CLASS_FILE_NAME
        raise ConfigError(f"{given}: a class goes on as {kept} says: leave it out, or change that")


def words_of_class(given: tuple[str, ...], site: "ClassSite") -> tuple[str, ...]:
    """Return the words of a class, the instructor's own among them; ConfigError.

    A word for all roles is known to all trainees, so the instructor gets another one.
    """
    from trainer.io.server import parse_address
    from trainer.session.stations.roles import INSTRUCTOR_ROLE, read_tokens, refuse_open_door

    tokens = read_tokens(given)
    door = ("--public-url", site.public_url) if site.public_url else ("--web", "")
    refuse_open_door(door[0], door[1] or parse_address(site.web, WEB_ADDRESS)[0], tokens)
    if not tokens or INSTRUCTOR_ROLE.name in tokens:
        return given
    word = secrets.token_hex(3)
    print_note(f"class: the instructor's word is {word}; --token instructor=WORD gives your own")
    return (*given, f"{INSTRUCTOR_ROLE.name}={word}")


def plan_class(
    name: str,
    *,
    boats: int,
    on: tuple[str, ...],
    seed: int,
    own_seeds: bool,
    one_sea: float | None,
    **_others: object,
) -> "ClassFile":
    """Return the class of a class file, or of an exercise and the options; ConfigError."""
    from trainer.config.exercise.class_file import (
        OWN_SEEDS,
        SAME_SEEDS,
        BoatRow,
        ClassFile,
        is_class_file,
        load_class,
        refuse_many,
    )

    if is_class_file(name):
        if given := flags_given(CLASS_OPTIONS):
            raise ConfigError(f"{given}: {name} is a class file, and says it itself")
        planned = load_class(Path(name))
    else:
        refuse_many(boats, len(on))
        seeds = OWN_SEEDS if own_seeds else SAME_SEEDS
        rows = tuple(BoatRow(number=number, on=url) for number, url in enumerate(on, boats + 1))
        count = boats + len(on)
        planned = ClassFile(
            exercise=name, boats=count, seed=seed, seeds=seeds, one_sea_m=one_sea, boat=rows
        )
    for exercise in planned.exercises:
        refuse_exercise(exercise)
    return planned


def refuse_exercise(name: str) -> None:
    """Raise ConfigError for an exercise that no boat could begin.

    One that is shipped is right: to read it would load the core, which a class does without.
    """
    path = path_named(name, "exercises")
    if is_path(name):
        from trainer.config.exercise.exercise import load_exercise

        load_exercise(str(path))


@class_command.below
@click.command()
@click.argument("file", type=TOML_OUTPUT)
@click.argument("exercise", type=EXERCISE_NAME, default="periscope-depth")
@boats_option
def new(file: Path, exercise: str, boats: int) -> None:
    """Write a class file with comments, to be changed; never over another file.

    \b
    Example:  trainer class new tuesday.toml periscope-depth --boats 8
    """
    from trainer.config.exercise.class_file import refuse_many, write_new_class

    refuse_many(boats)
    click.echo(write_new_class(file, exercise, boats))


@class_command.below
@click.command()
@click.argument("file", type=TOML_FILE)
def check(file: Path) -> None:
    """Check a class file, and say what it begins: a line a boat.

    \b
    Example:  trainer class check tuesday.toml
    """
    from trainer.config.exercise.class_file import load_class

    planned = load_class(file)
    for exercise in planned.exercises:
        refuse_exercise(exercise)
    course = f"course of {len(planned.course)}"
    click.echo(f"{planned.exercise or course}, boats: {planned.boats}")
    for place, each in enumerate(planned.course, 1):
        click.echo(f"{place:3}. {each.told}")
    if planned.one_sea_m is not None:
        click.echo(f"all in one sea, each {planned.one_sea_m:g} m east of the one before")
    for number in planned.numbers:
        row = planned.row_of(number)
        who = ", ".join(row.trainees) or "no names"
        begun = f"on {row.on}" if row.on else f"seed {row.seed}, {who}"
        click.echo(f"{number:3} {row.name or '':24} {begun}")


@class_command.below
@click.command()
@click.argument("folder", type=click.Path(exists=True, file_okay=False, path_type=Path))
@click.option("--html", type=FOLDER_PATH, help="Folder of the pages. [default: debrief, in FOLDER]")
@click.option("--csv", type=CSV_OUTPUT, help="A row for each trainee and exercise.")
@click.option("--json", "json", is_flag=True, help="Print the figures as JSON.")
@cores_option
def debrief(folder: Path, cores: int | None, **asked: Any) -> None:
    """Lay the boats of a class beside one another: marks, curves, common losses.

    \b
    Example:  trainer class debrief FOLDER
              trainer class debrief FOLDER --csv books.csv

    FOLDER is where the class keeps its recordings; its terminal names it. The pages are one for the
    class and one for each boat. What has been judged once is kept beside the recordings.
    """
    from trainer.debrief.trainees import class_page
    from trainer.workers import processor_count

    request = fill_record(class_page.ClassRequest, asked)
    class_page.debrief_class(folder, request, cores or processor_count())
