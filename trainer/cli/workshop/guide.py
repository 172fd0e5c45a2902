"""The commands ``manoeuvre``, which flies one, and ``guide``, which flies all that qualify a boat.

A qualification test guide is the document by which a simulator is accepted: each manoeuvre with
its measured figures beside those demanded.
"""

import json
import sys
from dataclasses import asdict
from datetime import UTC, datetime
from pathlib import Path
from typing import Any, Final

import click

from trainer.cli.answers import json_of, outputs, show_report
from trainer.cli.options import (
    CSV_OUTPUT,
    HTML_OUTPUT,
    PDF_OUTPUT,
    VESSEL_NAME,
    combine_options,
    cores_option,
    kind_option,
    kind_options,
    options_given,
)
from trainer.cli.types import File, Number, Word, text_option
from trainer.cli.workshop import ships
from trainer.config.keywords import MANOEUVRE_KEYWORDS
from trainer.report.progress import show_progress, write_text

# fmt: off
MANOEUVRE_NAMES: Final = (  # of analysis.manoeuvres.catalogue, which would load the core
    "meander", "overshoot", "turn", "climbing-turn", "acceleration", "utmost-acceleration",
    "trim", "impulse", "rudder-impulse", "turning-circle", "zigzag-10", "zigzag-20",
    "pull-out", "spiral", "reverse-spiral", "vertical-zigzag", "crash-stop", "backing",
    "roll-decay", "beam-sea", "out-of-balance", "plane-jam", "rudder-jam",
)
# fmt: on
MANOEUVRE_OPTIONS: Final = combine_options(
    kind_option(MANOEUVRE_KEYWORDS, "speed", usual="the boat's"),
    kind_option(MANOEUVRE_KEYWORDS, "angle"),
    kind_option(MANOEUVRE_KEYWORDS, "side", usual="starboard"),
    click.option("--rise", "direction", flag_value="rise", help="Planes to rise, or first."),
    click.option(
        "--dive",
        "direction",
        flag_value="dive",
        help="Planes to dive, or first. [default: rise; of trim, dive]",
    ),
    kind_options(MANOEUVRE_KEYWORDS, "planes", "execute", "duration"),
    kind_option(MANOEUVRE_KEYWORDS, "step_speed", usual="5, or a third of the last"),
    kind_option(MANOEUVRE_KEYWORDS, "step_time"),
    kind_option(MANOEUVRE_KEYWORDS, "ahead_speed", usual="full ahead"),
    kind_option(MANOEUVRE_KEYWORDS, "ahead_time", usual="half the duration"),
    kind_option(
        MANOEUVRE_KEYWORDS,
        "depth",
        usual="1000, where neither hull nor surface sets limits",
    ),
    kind_option(
        MANOEUVRE_KEYWORDS,
        "sea",
        metavar="NAME|PATH",
        text="calm, sea-state-1 to sea-state-6, or a file; with --depth",
    ),
    kind_option(MANOEUVRE_KEYWORDS, "seed", default=1, text="of the sea"),
    kind_options(MANOEUVRE_KEYWORDS, "rates", equations="full", trig="exact"),
    kind_option(MANOEUVRE_KEYWORDS, "integrator", default="adams2", text="as for trainer run"),
    kind_option(MANOEUVRE_KEYWORDS, "step", usual="the boat's"),
    kind_options(MANOEUVRE_KEYWORDS, controls="own", trim="own", law="trainer"),
)


def list_manoeuvres() -> str:
    """Return the manoeuvres and their parameters, a line each."""
    from trainer.analysis.manoeuvres.catalogue import (
        MANOEUVRES,
        format_parameters,
        manoeuvre_parameters,
    )
    from trainer.report.text import table

    rows = [
        (name, format_parameters(manoeuvre_parameters(each))) for name, each in MANOEUVRES.items()
    ]
    return "\n".join(table(("", "degrees and seconds unless told otherwise"), rows, ""))


@click.command()
@click.argument("name", type=Word(MANOEUVRE_NAMES))
@click.argument("vessel", type=VESSEL_NAME)
@text_option("--list", list_manoeuvres, "Print the manoeuvres and their parameters, and leave.")
@MANOEUVRE_OPTIONS
@click.option("--csv", type=CSV_OUTPUT, metavar="FILE", help="Write the flight, SI, rad.")
@outputs
def manoeuvre(name: str, vessel: str, **options: Any) -> None:
    """Fly a manoeuvre and measure it (CONTR).

    VESSEL is a name, a vessel file, or the file of a ship that was identified.

    \b
    Example:  trainer boat manoeuvre turning-circle bb2 --angle 20
              trainer boat manoeuvre zigzag-20 bb2 --side port --depth 60
              trainer boat manoeuvre meander bb2 --dive --speed 15 --equations modified --plot m.svg
              trainer boat manoeuvre zigzag-10 ship.toml

    Exit code 1 when the boat is lost on the way.
    """
    from trainer.analysis.manoeuvres import page
    from trainer.analysis.manoeuvres.catalogue import find_manoeuvre
    from trainer.api.programs import fly_manoeuvre
    from trainer.config.files import ConfigError

    if vessel in MANOEUVRE_NAMES and name not in MANOEUVRE_NAMES:
        raise ConfigError(f"the manoeuvre comes first: trainer boat manoeuvre {vessel} {name}")
    asked = {each: options[each] for each in options.keys() & options_given()}
    report, flight = fly_manoeuvre(vessel, name, asked)
    if options["csv"]:
        page.write_csv(flight, options["csv"])
    render: Any = page.render
    if hasattr(report, "intervals"):
        from trainer.identify.ships import vehicle

        render = vehicle.render
    show_report(report, render, lambda: page.panels(find_manoeuvre(name), flight), options)
    sys.exit(1 if report.lost else 0)


@click.command()
@click.argument("vessel", type=VESSEL_NAME)
@click.option("--html", type=HTML_OUTPUT, metavar="FILE", help="Write one HTML page.")
@click.option("--pdf", type=PDF_OUTPUT, metavar="FILE", help="Print it by a browser.")
@click.option(
    "--depth",
    type=Number(0.1, 12000.0),
    metavar="M",
    help="At which everything begins. [default: deep, some of it near the surface]",
)
@click.option(
    "--programme",
    type=click.Choice(("today", "1969", "trainer")),
    default="today",
    help="1969: the overshoots, turns, meanders and accelerations of the report. trainer: the "
    "short one that its section V asks of a trainer, by its own rules, and nothing else.",
)
@click.option("--json", "as_json", is_flag=True, help="Print the figures as JSON.")
@click.option(
    "--baseline",
    type=File(".json", ".html"),
    metavar="FILE",
    help="An earlier guide, JSON or HTML: name what moved since.",
)
@click.option(
    "--uncertainty",
    is_flag=True,
    help="First fly the published manoeuvres with drawn boats, and write the table of u_input.",
)
@cores_option
def guide(vessel: str, **options: Any) -> None:
    """Write the qualification test guide of a boat.

    Published figures beside ours with their uncertainty; all manoeuvres by the full, modified and
    basic sets, to port and starboard, up and down, deep and near the surface, judged; neutral
    angles, modes, thrust, steps, findings of 1969.

    \b
    Example:  trainer boat guide bb2 --html bb2.html --pdf bb2.pdf

    Of a ship (mariner, kvlcc2) it prints the published figures beside ours, and nothing else.

    VESSEL is bb2, sdv-mk9, remus100, or the path of a vessel file. Exit code 1 when the
    modified set is out of tolerance; trainer boat reduce finds one that is not.
    """
    if ships.is_ship(vessel):
        ships.print_figures(vessel, as_json=options["as_json"])
        return
    from trainer.analysis.guide import contents, page
    from trainer.analysis.guide.programme import guide_legs, legs_of_1969, legs_of_trainer
    from trainer.config.boat.vessel import load_vessel

    file = load_vessel(vessel)
    baseline = options["baseline"]
    earlier = contents.load_earlier(baseline, file.name) if baseline else None
    if options["uncertainty"]:
        write_uncertainty(file, options["cores"])
    made = datetime.now(UTC).strftime("%Y-%m-%d %H:%M:%S UTC")
    programmes = {"today": guide_legs, "1969": legs_of_1969, "trainer": legs_of_trainer}
    legs = programmes[options["programme"]](file, options["depth"])
    book = write_guide(file, legs, made, options["cores"])
    now = json.loads(json_of(asdict(book.guide)))
    moved = None if earlier is None else contents.compare_guides(earlier, now)
    write_document(page.html_page(book, moved), options["html"], options["pdf"])
    if options["as_json"]:
        extra = {} if moved is None else {"moved": [asdict(one) for one in moved]}
        click.echo(json_of({**now, **extra}))
    else:
        click.echo(page.render(book.guide, moved))
    sys.exit(0 if book.guide.passed else 1)


def write_guide(file: Any, legs: Any, made: str, cores: int | None) -> Any:
    """Return the guide's book of some legs, with a progress bar on a terminal."""
    from trainer.analysis.guide import contents
    from trainer.workers import processor_count

    count = len(contents.guide_tasks(file, legs))
    with show_progress(count, "flying") as step:
        return contents.write_guide(file, legs, made, cores or processor_count(), lambda: step(1))


def write_uncertainty(file: Any, cores: int | None) -> None:
    """Fly and write the table of u_input; ConfigError if the boat has no published figures."""
    from trainer.analysis.guide import uncertainty
    from trainer.analysis.guide.trials import load_published, trials_path
    from trainer.config.files import ConfigError, renew_file
    from trainer.workers import processor_count

    path = trials_path(file)
    published = load_published(path) if path else None
    if published is None or not published.figures:
        beside = file.path.with_suffix(".trials.toml").name
        raise ConfigError(f"--uncertainty: {file.path.name} has no published figures in {beside}")
    with show_progress(uncertainty.flight_count(published), "drawing boats") as step:
        text = uncertainty.fly_uncertainty(
            file, published, cores or processor_count(), lambda: step(1)
        )
    renew_file(uncertainty.table_path(published), text)


def write_document(text: str, html: Path | None, pdf: Path | None) -> None:
    """Write the page and print it, where asked for; ConfigError if that cannot be."""
    import tempfile

    from trainer.report.pdf import print_pdf

    if html is None and pdf is None:
        return
    with tempfile.TemporaryDirectory() as folder:
        path = html or Path(folder) / "guide.html"
        write_text(path, text, "--html")
        if pdf is not None:
            print_pdf(path, pdf)
