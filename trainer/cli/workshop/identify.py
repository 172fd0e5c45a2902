"""The analyst's programs: experiments designed, ships identified, lanes made into tracks.

``main`` lists the commands ``prbs``, ``identify``, ``decca`` and ``steering``. Each turns its
options into a record, calls the package ``identify``, and shows the report. Imports stand in
functions, because scipy takes long to load, and ``--help`` needs none of it.
"""

import sys
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

import click

from trainer.cli.answers import outputs, show_report
from trainer.cli.options import (
    CSV_OUTPUT,
    HTML_OUTPUT,
    SEA_NAME,
    TOML_FILE,
    TOML_OUTPUT,
    VESSEL_NAME,
    combine_options,
    kind_option,
    kind_options,
    options_given,
)
from trainer.cli.types import AHEAD_SPEED_TYPE, File, Name, Number, Output, ParentCommand
from trainer.cli.workshop import ships
from trainer.config.keywords import IDENTIFY_KEYWORDS, RECORD_ENDINGS, fill_record
from trainer.config.ship.fit_options import FIT_KINDS, SHIP_MODELS, USUAL_PRIOR_STRENGTH
from trainer.report.progress import write_text

if TYPE_CHECKING:
    from trainer.identify.pages.results import Identification
    from trainer.identify.record.study import Study

OUTPUT_CHANNELS: Final = ("sway", "yaw_rate", "heading")
RECORD_FILE: Final = File(*RECORD_ENDINGS)
POSITIVE_NUMBER: Final = Number(0.0, 1e6, min_open=True)
strength_option = kind_option(FIT_KINDS, "prior_strength", default=USUAL_PRIOR_STRENGTH)
model_options = combine_options(
    kind_option(
        FIT_KINDS,
        "model",
        text="1 sway and yaw, 2 sway, 3 yaw, Nomoto's, or with speed and --ship the last four",
        usual="the study's",
    ),
    kind_option(IDENTIFY_KEYWORDS, "vessel"),
    kind_option(FIT_KINDS, "length", text="of the ship"),
    kind_option(FIT_KINDS, "speed", "--at", "knots", text="speed; else the record's mean"),
    kind_option(
        FIT_KINDS,
        "outputs",
        "--output",
        "channels",
        text="what to fit, may be repeated",
        usual="all the model has",
    ),
    kind_option(FIT_KINDS, "noise"),
    kind_option(
        FIT_KINDS, "method", text="minimiser; else scoring, by BFGS where it gets no further"
    ),
    kind_options(IDENTIFY_KEYWORDS, "exact", "system"),
    kind_option(FIT_KINDS, "reject", metavar="P"),
    kind_option(
        FIT_KINDS, "between_readings", text="how the rudder goes; else as name and record say"
    ),
    kind_option(FIT_KINDS, "every"),
    kind_option(FIT_KINDS, "begin", "--from", "begin"),
    kind_option(FIT_KINDS, "end", "--to", "end"),
)
of_ships = combine_options(
    click.option("--ship", type=Name("ships"), help="For linear to mmg, its file."),
    strength_option,
    click.option(
        "--predict", type=RECORD_FILE, multiple=True, help="A record held back, may be repeated."
    ),
    click.option("--write-ship", type=TOML_OUTPUT, help="Write the ship; it sails."),
    click.option("--coefficients", type=CSV_OUTPUT, help="Write them and their covariance."),
)


class ZigzagAngles(click.ParamType[tuple[float, float]]):
    """Helm and heading of a zig-zag: 10/10."""

    name = "angles"

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        """Return helm and heading [deg]."""
        if isinstance(value, tuple):
            return value
        helm, _, heading = str(value).partition("/")
        try:
            angles = float(helm), float(heading or helm)
        except ValueError:
            angles = (0.0, 0.0)
        if not (0.0 < angles[0] <= 90.0 and 0.0 < angles[1] <= 90.0):
            self.fail(f"{value!r} is not helm and heading in degrees, such as 10/10", param, ctx)
        return angles


class ApproachSpeed(click.ParamType[tuple[float, float]]):
    """A speed, and that whose revolutions turn the propeller: 15, or 15/8."""

    name = "approach"

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        """Return both speeds [kn]."""
        if isinstance(value, tuple):
            return value
        speed, _, held = str(value).partition("/")
        return AHEAD_SPEED_TYPE.convert(speed, param, ctx), AHEAD_SPEED_TYPE.convert(
            held or speed, param, ctx
        )


def sensor(name: str, default: float, text: str) -> Any:
    """Return an option for the standard deviation of a sensor."""
    limits = Number(0.0, 100.0)
    flag = f"--noise-{name.replace('_', '-')}"
    return click.option(flag, name, type=limits, default=default, help=text)


sensor_options = combine_options(
    sensor("sway", 0.05, "Standard deviation of the log, knots."),
    sensor("yaw_rate", 0.02, "Of the rate gyro, deg/s."),
    sensor("heading", 0.1, "Of the compass, degrees."),
)


sequence_options = combine_options(
    click.option("--amplitude", type=POSITIVE_NUMBER, default=5.0, help="Degrees."),
    click.option("--bits", type=click.IntRange(2, 12), help="Of the register."),
    click.option("--hold", type=POSITIVE_NUMBER, help="Seconds of a bit. [default: T1/3; L/U]"),
    click.option("--periods", type=click.IntRange(1, 50), default=1),
    click.option("--seed", type=click.IntRange(1, 4095), default=1),
    click.option(
        "--by",
        type=click.Choice(("rudder", "course")),
        default="rudder",
        help="Order rudder angles, or courses that the autopilot steers, near north.",
    ),
    click.option("--zigzag", type=ZigzagAngles(), metavar="HELM/HEADING", help="Instead."),
    click.option("--seconds", type=POSITIVE_NUMBER, default=600.0, help="Of a zig-zag."),
)


@click.command()
@click.argument("vessel", type=VESSEL_NAME)
@click.option(
    "--speed",
    "speeds",
    type=ApproachSpeed(),
    multiple=True,
    metavar="KN[/KN]",
    help="[default: the vessel's] Of a ship may be repeated; 15/8 has the revolutions of 8 kn.",
)
@click.option("--depth", type=POSITIVE_NUMBER, help="Metres. [default: the vessel's]")
@sequence_options
@click.option("--interval", type=POSITIVE_NUMBER, help="Seconds between samples.")
@click.option(
    "--output",
    "outputs",
    type=click.Choice(OUTPUT_CHANNELS),
    multiple=True,
    help="What will be read, may be repeated. [default: all three]",
)
@sensor_options
@click.option(
    "--unrest",
    type=Number(0.0, 10.0),
    default=0.02,
    help="Yaw rate that the sea alone makes, rms deg/s.",
)
@strength_option
@click.option("--sea", type=SEA_NAME, metavar="NAME", help="Sea of the exercise written.")
@click.option("--write", type=TOML_OUTPUT, metavar="FILE", help="Write the exercise.")
@outputs
def prbs(vessel: str, write: Path | None, **options: Any) -> None:
    """Design a rudder experiment and say what it will tell.

    VESSEL is a name or the path of a vessel file, or the file of a ship that is not linear.
    Such a ship sails a zig-zag, a binary sequence, or both; these, and several speeds, are tried
    one by one and together in the same time.

    \b
    Example:  trainer ship prbs bb2 --amplitude 3 --sea sea-state-3 --write trial.toml
              trainer run trial.toml --headless --speed max --record trial.trainer
              trainer identify trial.trainer --model 1 --vessel bb2
              trainer ship prbs bb2 --zigzag 10/10
              trainer ship prbs ship.toml --zigzag 20/20 --speed 15 --speed 15/8
              trainer ship prbs ship.toml --zigzag 20/20 --amplitude 20
    """
    from trainer.api.programs import ship_path
    from trainer.config.boat.vessel import load_vessel
    from trainer.config.extras import require_library

    require_library("scipy", "trainer ship prbs")
    if ships.is_ship(vessel):
        ships.design_trials(ship_path(vessel), options)
        return
    file = load_vessel(vessel)  # first, because its error is the most telling
    speed = _only_speed(vessel, options["speeds"])
    from trainer.identify.pages import experiment as page

    sensors = ships.sensors_asked(options)
    wishes = fill_record(
        page.ExperimentOptions, options, vessel=vessel, speed_kn=speed, sensors=sensors
    )
    design = page.design_experiment(file, wishes)
    if write is not None:
        write_text(write, design.exercise)
    show_report(design.report, page.render, lambda: page.panels(design), options)


def _only_speed(vessel: str, speeds: tuple[tuple[float, float], ...]) -> float | None:
    """Return the speed [kn] of a boat's experiment; UsageError for options of ships."""
    if len(speeds) > 1 or any(speed != held for speed, held in speeds):
        raise click.UsageError(f"--speed: {vessel} is a boat: give one speed, without a stroke")
    if "prior_strength" in options_given():
        raise click.UsageError(f"--prior-strength: {vessel} is a boat: no book is asked")
    return speeds[0][0] if speeds else None


@click.command()
@click.argument("vessel", type=VESSEL_NAME)
@click.option(
    "--speed", "speeds", type=AHEAD_SPEED_TYPE, multiple=True, metavar="KN", help="May be repeated."
)
@click.option(
    "--record",
    type=RECORD_FILE,
    metavar="FILE",
    help="A zig-zag or a turn: its K and T by the old methods, beside the ship's.",
)
@outputs
def steering(vessel: str, speeds: tuple[float, ...], record: Path | None, **options: Any) -> None:
    """Show gains, lever arms, and the spiral of a boat or a ship.

    VESSEL is a name, or the path of a vessel file, of a Nomoto file, or of a table of derivatives
    in the prime or bis system (schema = "derivatives/1").

    \b
    Example:  trainer ship steering bb2 --speed 5 --speed 10
              trainer ship steering ship.toml --plot spiral.png
              trainer ship steering ship.toml --record zigzag.csv

    The speed is the vessel's own unless it is given; that of a ship is in its file.
    """
    from trainer.config.boat.vessel import load_vessel
    from trainer.identify.pages import steering as page

    path = Path(vessel)
    report = page.of_ship(path) if path.suffix == ".toml" else None
    if report and speeds:
        raise click.UsageError(f"{vessel} is a ship at its own speed: --speed is for boats")
    if report is None:
        file = load_vessel(vessel)
        report = page.of_vessel(file, speeds or (file.run.start_speed_kn,))
    if record:
        report = page.with_record(report, record)
    show_report(report, page.render, lambda: page.panels(report), options)


@click.command()
@click.argument("file", type=TOML_FILE)
@click.option("--smooth", is_flag=True, help="Smooth the track by Spencer's 15 points first.")
@click.option("--csv", type=CSV_OUTPUT, metavar="FILE", help="Write the track as a record.")
@outputs
def decca(file: Path, csv: Path | None, smooth: bool, **options: Any) -> None:  # noqa: FBT001
    """Lanes to position to sway velocity (DECCON).

    FILE is a Decca study: the chain, the antenna, and the CSV file of lanes and heading.

    \b
    Example:  trainer ship decca run.toml --csv sway.csv --plot track.png
    """
    from trainer.identify.pages import decca as page

    sailed = page.solve_track(page.load_decca(file), smooth=smooth)
    if csv is not None:
        page.write_track(sailed, csv)
    report = page.report_of(sailed, smooth=smooth)
    show_report(report, page.render, lambda: page.panels(sailed), options)


@click.command(cls=ParentCommand)
@click.argument("files", type=RECORD_FILE, nargs=-1, metavar="FILE [RECORD]...")
@model_options
@of_ships
@kind_options(IDENTIFY_KEYWORDS, "simulate", "anyway", "data_only")
@click.option("--armax", is_flag=True, help="ARMAX models of rising order instead.")
@click.option("--most", type=click.IntRange(1, 10), help="Highest ARMAX order.")
@kind_option(IDENTIFY_KEYWORDS, "against")
@kind_option(IDENTIFY_KEYWORDS, "without", metavar="NAME")
@kind_options(IDENTIFY_KEYWORDS, "check", "kappa", "bech", "spiral", "joint", "matrices")
@click.option("--csv", type=CSV_OUTPUT, metavar="FILE", help="Write it sample by sample.")
@click.option("--checkpoint", type=Output(".json"), help="Keep the search in this file.")
@click.option("--write-nomoto", type=TOML_OUTPUT, help="Write the ship in few numbers.")
@click.option("--write-vessel", type=TOML_OUTPUT, help="Write the vessel file changed.")
@click.option("--html", type=HTML_OUTPUT, metavar="FILE", help="Write one HTML page.")
@click.option(
    "--example",
    is_flag=False,
    flag_value="",
    metavar="[FOLDER]",
    help="Fit the record shipped as an example; with FOLDER, a copy of it there.",
)
@outputs
def identify(files: tuple[Path, ...], example: str | None, **options: Any) -> None:
    """Identify a ship from a record of helm and motion (LISPID).

    FILE is a study (.toml), a recording, or a CSV file as `trainer run --csv` writes it.
    Further records are of the same ship, and are fitted together with the first. `trainer identify
    new RECORD` writes a study of any CSV file. The models linear, mavmm, abkowitz and mmg
    are of ships that are not linear, and read CSV files.

    \b
    Example:  trainer identify --example
              trainer identify study.toml --plot fit.png
              trainer identify trial.trainer --model 1 --vessel bb2 --write-vessel bb2-found.toml
              trainer identify trial.csv --armax --most 5
              trainer identify zz20.csv --model mmg --ship ship.toml --predict zz10.csv

    Exit code 1 when the fit does not settle.
    """
    from trainer.config.extras import require_library

    require_library("scipy", "trainer identify")
    if example is not None:
        files = (_example(files, example),)
    if not files:
        raise click.UsageError("identify what? give a study, a recording or a CSV file")
    for folder in filter(Path.is_dir, files):
        raise click.UsageError(f"{folder} is a folder; name a study, a recording or a CSV file")
    if options["model"] in SHIP_MODELS:
        sys.exit(ships.identify(files, options))
    ships.refuse_idle(options)
    from trainer.identify.options import IdentifyOptions, study_of

    wishes = fill_record(IdentifyOptions, options, further=files[1:])
    study = study_of(files[0], wishes)
    if wishes.data_only:
        sys.exit(_data(study, options))
    if wishes.armax:
        sys.exit(_armax(study, options))
    from trainer.api.programs import fit_ship

    sys.exit(_model(fit_ship(study, wishes), options))


@identify.below
@click.command()
@click.argument("record", type=File(".csv", ".trainer"))
@click.option("-o", "--output", type=TOML_OUTPUT, metavar="FILE", help="[default: beside]")
@kind_option(FIT_KINDS, "length", text="of the ship")
@kind_option(FIT_KINDS, "speed", "--at", "knots", text="speed")
@click.option("--ship", type=TOML_OUTPUT, metavar="FILE", help="A ship's file instead.")
@click.option(
    "--column",
    "named",
    multiple=True,
    metavar="CHANNEL=HEADING[:UNIT[*SCALE]]",
    help="What a column is, where its heading does not say so: rudder=Ruder:deg.",
)
@click.option("--anyway", is_flag=True, help="Even if its channels contradict each other.")
def new(
    record: Path,
    output: Path | None,
    length: float | None,
    ship: Path | None,
    **options: Any,
) -> None:
    """Write a study of a record with comments, to be corrected; never over another file.

    Columns are told by their names and units, the sign of the rudder by how the ship turns. With
    --ship it is the file of a ship for the models linear, mavmm, abkowitz and mmg.

    \b
    Example:  trainer identify new trial.csv --length 70.2 --at 10
              trainer identify new trial.csv -o study.toml
              trainer identify new zz20.csv --ship ship.toml
              trainer identify new fahrt.csv --column rudder=Ruder --column heading=Kurs
    """
    from trainer.config.files import as_typed
    from trainer.identify.record.proposal import write_proposal
    from trainer.identify.record.sources import column_said
    from trainer.identify.ships.proposal import fit_command, write_ship_file

    knots, anyway = options["knots"], options["anyway"]
    headings = {channel: column_said(text) for channel, text in map(_pair, options["named"])}
    if ship:
        if output or knots:
            raise click.UsageError("--ship takes the place of --output; the record tells the speed")
        path, proposal = ship, write_ship_file(record, ship, length, headings, anyway=anyway)
        last = f"fill in [dimensions]; fit it by: {fit_command(record, ship)}"
    else:
        path = output or record.parent / f"{record.stem or 'study'}.toml"
        proposal = write_proposal(record, path, length, knots, headings, anyway=anyway)
        lacking = "" if length else "fill in the length of [ship]; "
        last = f"{lacking}fit it by: trainer identify {as_typed(path)}"
    columns = ", ".join(f"{key} in {one.name}" for key, one in proposal.columns.items())
    guessed = "" if "t" in proposal.columns else " (guessed: there is no column of times)"
    click.echo(f"{path}: {proposal.rows} rows every {proposal.interval:.6g} s{guessed}: {columns}")
    for remark in proposal.remarks:
        click.echo(f"  {remark}")
    click.echo(last)


def _pair(text: str) -> tuple[str, str]:
    """Return the channel and the heading of an option such as rudder=Ruder."""
    channel, equals, heading = (part.strip() for part in text.partition("="))
    if not (channel and equals and heading):
        raise click.UsageError(f"--column {text}: expected CHANNEL=HEADING, such as rudder=Ruder")
    return channel, heading


def _example(files: tuple[Path, ...], folder: str) -> Path:
    """Return the study shipped as an example, copied to a folder if one is given."""
    from trainer.config.files import ConfigError, read_text, shipped_path, write_once

    if files:
        raise click.UsageError("--example has a record of its own: give no FILE")
    study = shipped_path("records", "example")
    if not folder:
        return study
    target = Path(folder)
    try:
        target.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise ConfigError(f"--example {folder}: cannot be made: {error.strerror}") from error
    for path in (study, study.with_suffix(".csv")):
        write_once(target / path.name, read_text(path))
        click.echo(f"{target / path.name} written", err=True)
    return target / study.name


def _data(study: "Study", options: dict[str, Any]) -> int:
    """Show a record without a fit; return the exit code."""
    from trainer.identify.pages import record as page

    report, screens = page.carry_out(study)
    show_report(report, page.render, lambda: screens, options)
    return 0


def _armax(study: "Study", options: dict[str, Any]) -> int:
    """Fit ARMAX models and show them; return the exit code."""
    from trainer.identify.pages import armax as page

    report, orders = page.carry_out(study)
    if options["html"]:
        from trainer.identify.sheet import sheet

        text = sheet(report.study, page.render(report), page.screens(orders), report)
        write_text(options["html"], text)
    show_report(report, page.render, lambda: page.screens(orders), options)
    return 0


def _model(found: "Identification", options: dict[str, Any]) -> int:
    """Show a ship model that was fitted; return the exit code."""
    from trainer.identify.pages import identify as page
    from trainer.identify.pages.series import write_series
    from trainer.identify.pages.ship_files import nomoto_text, vessel_text

    report = found.report
    if options["write_nomoto"]:
        write_text(options["write_nomoto"], nomoto_text(found.fitted, report.bend))
    if options["write_vessel"]:
        write_text(options["write_vessel"], vessel_text(found.fitted))
    if options["csv"]:
        write_series(found.fitted, options["csv"])
    if options["html"]:
        write_text(options["html"], page.sheet(found))
    show_report(report, page.render, lambda: page.screens(found), options)
    return 0 if report.converged else 1
