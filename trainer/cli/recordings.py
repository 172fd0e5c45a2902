"""The commands about recordings: replay, export to tables, debrief, and what a crew has flown.

``main`` has them. They work on the file alone, during a run or years later; the session need not be
there.
"""

import sys
from pathlib import Path
from typing import Any

import click

from trainer.cli.answers import PLOT_OUTPUT
from trainer.cli.export import page_text
from trainer.cli.options import (
    CSV_OUTPUT,
    HTML_OUTPUT,
    PDF_OUTPUT,
    RATING_WIDTHS,
    RECORDING_FILE,
    RRD_OUTPUT,
    TOML_FILE,
    VESSEL_HELP,
    VESSEL_NAME,
    last_option,
    named_recording,
)
from trainer.cli.types import Duration, File, Output
from trainer.config.words import EQUATION_SETS


@click.command()
@click.argument("file", type=RECORDING_FILE)
@click.option("--anyway", is_flag=True, help="Even if this version would compute otherwise.")
@click.option("--vessel", type=VESSEL_NAME, help=f"Fly another boat: {VESSEL_HELP}.")
@click.option("--step", type=float, help="Fly at another step in s.")
@click.option("--equations", type=click.Choice(EQUATION_SETS), help="By another set.")
@click.option("--json", "as_json", is_flag=True, help="Print the comparison as JSON.")
def replay(file: Path, *, anyway: bool, as_json: bool, **otherwise: Any) -> None:
    """Fly a recording again, all its branches, and compare every state bit by bit.

    \b
    Example:  trainer replay drill.trainer

    Exit codes: 0 the same, 1 not the same, 2 it would be computed otherwise than then: what
    differs is told, and --anyway flies it all the same.
    """
    from trainer.session.replay import replay_file

    changed = {name: value for name, value in otherwise.items() if value is not None}
    sys.exit(replay_file(file, changed, anyway=anyway, as_json=as_json))


@click.command()
@click.argument("file", type=File(".trainer", ".csv"))
@click.option("--csv", type=CSV_OUTPUT, help="States here, orders and events beside.")
@click.option("--parquet", type=Output(".parquet"), help="The same as Parquet files.")
@click.option("--rrd", type=RRD_OUTPUT, help="The run as Rerun's viewer shows it.")
@click.option("--mcap", type=Output(".mcap"), help="The run for Foxglove, and viewers of robots.")
@click.option(
    "--plot", type=PLOT_OUTPUT, help="Columns over time, .png, .svg or .pdf by its ending."
)
@click.option(
    "--column",
    "columns",
    multiple=True,
    metavar="NAME[,NAME]",
    help="What --plot draws, a panel each time it is given. [default: z, theta, u]",
)
@click.option("--branch", type=click.IntRange(1), help="[default: the last one]")
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
    from trainer.debrief.passage.recording_export import export_file, panels_of_run
    from trainer.report.plots import draw_plot

    if columns and plot is None:
        raise click.UsageError("--column says what --plot FILE draws")
    panels = () if plot is None else panels_of_run(file, columns, branch)  # refusals before a file
    if plot is None or any(wanted.values()):
        export_file(file, wanted, branch)
    if plot is not None:
        draw_plot(panels, plot)
        click.echo(str(plot))


@click.command()
@click.argument("file", type=RECORDING_FILE, required=False)
@last_option
@click.option("--html", type=HTML_OUTPUT, help="[default: beside the recording]")
@click.option("--pdf", type=PDF_OUTPUT, help="Printed by a browser of this machine.")
@click.option("--branch", type=click.IntRange(1), help="[default: the last that ended]")
@click.option("--width", type=click.Choice(RATING_WIDTHS), help="[default: the run's own]")
@click.option(
    "--reference-from",
    type=Duration(),
    metavar="TIME",
    help="Also fly the reference crew from this recorded moment on.",
)
@click.option(
    "--change",
    multiple=True,
    metavar='"NAME: WHAT, REASON"',
    help="Change a mark: weight 2, strike; outcome: won; width: basic. May be given again.",
)
@click.option(
    "--change-back", multiple=True, metavar="NAME", help="Take such a change back; all: all."
)
@click.option(
    "--form",
    "forms",
    type=TOML_FILE,
    multiple=True,
    help="Keep a filled form beside the recording. May be given again.",
)
@click.option("--fly", is_flag=True, help="Put the boat into the page, to be taken over there.")
@click.option("--text", is_flag=True, help="Print the marks and what each minute cost.")
@click.option("--json", "json", is_flag=True, help="Print the figures as JSON.")
def debrief(file: Path | None, *, last: bool, **how: Any) -> None:
    """Write what was ordered, what came of it, and the marks, as one page.

    \b
    Example:  trainer debrief drill.trainer
              trainer debrief --last --text
              trainer debrief --last --pdf drill.pdf
              trainer debrief drill.trainer --reference-from 320
              trainer debrief drill.trainer --fly
              trainer debrief drill.trainer --change "Time to 100 m: weight 0, the gauge was wrong"

    The page is one HTML file that needs nothing else. What is changed is kept beside the
    recording, and both marks are shown.
    """
    import gc

    gc.disable()  # little of a debrief is garbage before its end: to look for it is a tenth of all
    click.get_current_context().call_on_close(gc.enable)
    from trainer.debrief.page.page import (
        DebriefRequest,
        as_json,
        as_text,
        debrief_file,
    )

    if how["text"] and how["json"]:
        raise click.UsageError("--text and --json print two things: say one of them")
    path = named_recording(file, last=last)
    boat = page_text(None, path, "instructor") if how["fly"] else ""
    asked = ("branch", "width", "reference_from", "change", "change_back", "forms")
    request = DebriefRequest(boat=boat, **{name: how[name] for name in asked})
    printed = as_json if how["json"] else as_text if how["text"] else None
    debrief_file(path, how["html"], how["pdf"], request, printed)


@click.command()
@click.argument("places", type=RECORDING_FILE, nargs=-1)
@click.option("--trainee", metavar="NAME", help="What this trainee has done.")
@click.option("--progress", is_flag=True, help="With --trainee: the way through the course.")
@click.option("--csv", "csv_path", type=CSV_OUTPUT, help="All runs of the trainees, or of PLACES.")
@click.option("--forget", metavar="NAME", help="Remove this name everywhere.")
@click.option("--json", "as_json", is_flag=True, help="Print the list as JSON.")
def recordings(
    places: tuple[Path, ...],
    *,
    trainee: str | None,
    progress: bool,
    csv_path: Path | None,
    forget: str | None,
    as_json: bool,
) -> None:
    """List recordings: when, what, who was trained, and what it came to.

    \b
    Example:  trainer recordings
              trainer recordings --trainee "A. Jones"
              trainer recordings --trainee "A. Jones" --progress
              trainer recordings --csv class.csv
              trainer recordings ~/drills --forget "A. Jones"

    PLACES are folders and recordings; without any it is the folder where recordings are kept.
    A mark with * was changed by the instructor.

    Exit code 1 when a name that was to be removed still stands somewhere: where, and why, is told.
    """
    if trainee is not None and forget is not None:
        raise click.UsageError("--trainee and --forget are two things: say one")
    from trainer.debrief.trainees import forgetting, history

    if progress and trainee is None:
        raise click.UsageError("--progress says whose: add --trainee NAME")
    if csv_path is not None or progress:
        from trainer.debrief.trainees import progress_words

        if csv_path is not None:
            progress_words.write_class(csv_path, trainee, places)
        if progress and trainee is not None:
            progress_words.print_progress(trainee)
    elif forget is not None:
        sys.exit(forgetting.print_forgotten(places, forget))
    elif trainee is not None:
        history.print_history(places, trainee, as_json=as_json)
    else:
        history.print_list(places, as_json=as_json)
