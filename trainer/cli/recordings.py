"""Commands about recordings."""

import sys
from pathlib import Path
from typing import Any

import click

from trainer.cli.shared_options import FILE, VESSEL_HELP
from trainer.config.method import EQUATIONS


@click.command()
@click.argument("file", type=FILE)
@click.option("--anyway", is_flag=True, help="Even if this version would compute otherwise.")
@click.option("--vessel", default=None, help=f"Fly another boat: {VESSEL_HELP}.")
@click.option("--step", type=float, default=None, help="Fly at another step in s.")
@click.option("--equations", type=click.Choice(EQUATIONS), default=None, help="By another set.")
@click.option("--json", "as_json", is_flag=True, help="Print the comparison as JSON.")
def replay(file: Path, *, anyway: bool, as_json: bool, **otherwise: Any) -> None:
    """Fly a recording again, all its branches, and compare every state bit by bit.

    \b
    Example:  trainer replay drill.trainer

    Exit codes: 0 the same, 1 not the same, 2 it would be computed otherwise than then: what
    differs is told, and --anyway flies it all the same.
    """
    from trainer.analysis.replay_page import replay_file  # noqa: PLC0415

    changed = {name: value for name, value in otherwise.items() if value is not None}
    sys.exit(replay_file(file, changed, anyway=anyway, as_json=as_json))


@click.command()
@click.argument("file", type=FILE)
@click.option("--csv", type=FILE, default=None, help="States here, orders and events beside.")
@click.option("--parquet", type=FILE, default=None, help="The same as Parquet files.")
@click.option("--rrd", type=FILE, default=None, help="The run as Rerun's viewer shows it.")
@click.option(
    "--plot", type=FILE, default=None, help="Columns over time, .png, .svg or .pdf by its ending."
)
@click.option(
    "--column",
    "columns",
    multiple=True,
    metavar="NAME[,NAME]",
    help="What --plot draws, a panel each time it is given. [default: z, theta, u]",
)
@click.option("--branch", type=click.IntRange(1), default=None, help="[default: the last one]")
def export(
    file: Path,
    branch: int | None,
    plot: Path | None,
    columns: tuple[str, ...],
    **wanted: Path | None,
) -> None:
    """Write a recording's states, orders and events as tables, or as pictures.

    \b
    Example:  trainer export drill.trainer --csv drill.csv
              trainer export drill.trainer --rrd drill.rrd && rerun drill.rrd
              trainer export drill.trainer --plot drill.svg --column z --column delta_s,delta_b

    Of a run's CSV file, as `trainer run --csv` writes it, --plot draws the columns as well.
    """
    from trainer.analysis.recording_export import draw_run, export_file  # noqa: PLC0415

    if columns and plot is None:
        raise click.UsageError("--column says what --plot FILE draws")
    if plot is None or any(wanted.values()):
        export_file(file, wanted, branch)
    if plot is not None:
        draw_run(file, plot, columns, branch)


@click.command()
@click.argument("file", type=FILE)
@click.option("--html", type=FILE, default=None, help="[default: beside the recording]")
@click.option("--pdf", type=FILE, default=None, help="Printed by a browser of this machine.")
@click.option("--branch", type=click.IntRange(1), default=None, help="[default: the last one]")
@click.option("--json", "as_json", is_flag=True, help="Print the figures as JSON.")
def debrief(
    file: Path, html: Path | None, pdf: Path | None, branch: int | None, *, as_json: bool
) -> None:
    """Write what was ordered, what came of it, and the marks, as one page.

    \b
    Example:  trainer debrief drill.trainer
              trainer debrief drill.trainer --pdf drill.pdf

    The page is one HTML file that needs nothing else.
    """
    from trainer.analysis.debrief.page import debrief_file  # noqa: PLC0415

    debrief_file(file, html, pdf, branch, as_json=as_json)
