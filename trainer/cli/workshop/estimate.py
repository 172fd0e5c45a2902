"""The command ``trainer boat estimate``: a boat from the drawing of its hull.

``analysis/estimate`` computes. Here its results are written: the vessel file, a page, a study that
draws such boats, and a hull file to begin with.
"""

import sys
from pathlib import Path
from typing import Any, Final

import click

from trainer.cli.answers import json_of
from trainer.cli.options import HTML_OUTPUT, TOML_OUTPUT
from trainer.cli.types import Name
from trainer.report.progress import show_progress, write_text

NEW_HULL: Final = "new"  # the word before the name of a hull to be written
HULL_SKELETON: Final = "hull-skeleton"


@click.command()
@click.argument("hull", type=Name("hulls"))
@click.argument("file", type=TOML_OUTPUT, required=False)
@click.option("-o", "--output", type=TOML_OUTPUT, metavar="FILE", help="Write the boat so.")
@click.option("--html", type=HTML_OUTPUT, metavar="FILE", help="Write a page, with the hull drawn.")
@click.option(
    "--study", type=TOML_OUTPUT, metavar="FILE", help="Write a study of the turn's bands."
)
@click.option(
    "--draws", type=click.IntRange(0, 2000), default=50, help="Of the coefficients, for the bands."
)
@click.option("--reduce", is_flag=True, help="Find the compact set too; takes minutes.")
@click.option("--json", "as_json", is_flag=True, help="Print the figures as JSON.")
def estimate(hull: str, file: Path | None, output: Path | None, **options: Any) -> None:
    """Estimate a boat from its drawing: coefficients, their deviations, gains.

    \b
    Example:  trainer boat estimate new hull.toml
              trainer boat estimate hull.toml -o boat.toml --html boat.html
              trainer boat estimate suboff

    HULL is remus100, suboff, small-boat, or the path of a hull file; `new` before the name of a
    file writes one with comments, to be changed. The boat has a standard deviation on every
    coefficient, and flies at once. `trainer boat sweep` draws from it.
    """
    if hull == NEW_HULL:
        _write_skeleton(file)
        return
    if file is not None:
        raise click.UsageError(f"{file}: the boat is written with -o {file}")
    from dataclasses import asdict

    from trainer.analysis.estimate.boat_file import open_hull, write_boat
    from trainer.analysis.estimate.page import html_page, render
    from trainer.analysis.estimate.survey import survey_boat, turns_of

    if options["reduce"] and output is None:
        raise click.UsageError("--reduce: needs -o, where the boat is written")
    if options["study"] is not None and output is None:
        raise click.UsageError("--study: needs -o, the boat that it flies")
    made = write_boat(open_hull(hull), output or Path(f"{Path(hull).stem}-boat.toml"))
    if output is not None:
        write_text(output, made.text)
    with show_progress(turns_of(made, options["draws"]), "turning") as step:
        result = survey_boat(made, options["draws"], step)
    if options["html"] is not None:
        write_text(options["html"], html_page(result, made))
    if options["study"] is not None:
        _write_study(options["study"], output, result.rudder_deg)
    click.echo(json_of(asdict(result)) if options["as_json"] else render(result, made))
    if options["reduce"]:
        _reduce(output)


def _write_skeleton(file: Path | None) -> None:
    """Write a hull file with comments for the user to change; ConfigError if it is there."""
    from trainer.config.files import as_typed, read_text, shipped_path, write_once

    if file is None:
        raise click.UsageError("new: give the name of the file, such as hull.toml")
    write_once(file, read_text(shipped_path("", HULL_SKELETON)))
    click.echo(f"{file} written; next: trainer boat estimate {as_typed(file)} -o boat.toml")


def _write_study(path: Path, boat: Path | None, rudder: float) -> None:
    """Write a study that draws the boat's coefficients and flies a turn with each draw."""
    from os.path import relpath

    from trainer.analysis.estimate.boat_file import study_text

    # A study names its boat as seen from the study's own folder.
    boat_name = relpath(boat or "", path.parent)
    write_text(path, study_text(boat_name, rudder))


def _reduce(boat: Path | None) -> None:
    """Find the compact set of the boat in a file, and add it to the file."""
    from trainer.cli.workshop.vessel import reduce

    if boat is not None:
        sys.stdout.flush()  # the estimate appears before the minutes that the search takes
        # A bare name would be that of a shipped boat.
        path = f"./{boat}" if boat.parent == Path() else str(boat)
        reduce.main([path, "--write", "--quick"], standalone_mode=False)
