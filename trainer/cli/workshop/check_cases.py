"""The command ``check-cases`` flies cases whose outputs others have computed too."""

import sys
from pathlib import Path

import click

from trainer.cli.answers import json_of
from trainer.cli.options import CSV_FILE, HTML_OUTPUT
from trainer.report.progress import write_text


@click.command("check-cases")
@click.argument(
    "folder",
    required=False,
    type=click.Path(file_okay=False, path_type=Path),
    metavar="[DIR]",
)
@click.option(
    "--with",
    "others",
    type=CSV_FILE,
    multiple=True,
    metavar="FILE",
    help="Outputs of another program, CASE.csv or CASE.PROGRAM.csv; may be repeated. Only their "
    "cases are flown.",
)
@click.option("--page", type=HTML_OUTPUT, metavar="FILE", help="Write one HTML page with plots.")
@click.option("--json", "as_json", is_flag=True, help="Print the figures as JSON.")
def check_cases(
    folder: Path | None, others: tuple[Path, ...], page: Path | None, *, as_json: bool
) -> None:
    """Fly check cases, and lay them beside outputs of other programs.

    NASA's tumbling brick and twelve manoeuvres of one mechanism each, by the full set. Of each
    channel the largest difference is told, beside the spread that the case states.

    \b
    Example:  trainer boat check-cases
              trainer boat check-cases --page cases.html
              trainer boat check-cases --with turn.mine.csv

    DIR has cases of your own, NAME.toml each. Exit code 1 when this trainer's outputs are not
    those stored, or a run of a case is beyond its stated spread; files of --with are told, and
    not judged.
    """
    from trainer.analysis.check_cases import case_figures, cases_page, cases_text, fly_cases
    from trainer.config.exercise.check_case import case_paths

    flights = fly_cases(case_paths(folder), others)
    if page is not None:
        write_text(page, cases_page(flights), "--page")
    text = json_of(case_figures(flights)) if as_json else cases_text(flights)
    click.echo(text)
    sys.exit(0 if all(flight.as_stated for flight in flights) else 1)
