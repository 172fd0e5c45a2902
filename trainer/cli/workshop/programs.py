"""The engineer's programs of 1969, on a vessel file or on recorded runs.

Each command has the name of its predecessor in its help, such as EC470. The programs themselves are
in ``analysis/programs``; here are their options.
"""

import sys
from functools import partial
from pathlib import Path
from typing import Any, Final

import click

from trainer.cli.answers import outputs, show_report
from trainer.cli.options import CSV_FILE, VESSEL_NAME, combine_options
from trainer.cli.types import AHEAD_SPEED_TYPE, SPEED_TYPE, Number

COMMAND_SPEED_TYPE: Final = Number(-60.0, 60.0)
MEAN_MOTION_TYPE: Final = Number(0.0, 50.0)
SPEEDS_OPTION: Final = click.option(
    "--speed",
    "speeds",
    type=AHEAD_SPEED_TYPE,
    multiple=True,
    metavar="KN",
    help="Speed in knots, may be repeated. [default: about six over the boat's range]",
)
DEPTH_OPTION: Final = click.option(
    "--depth",
    type=Number(0.0, 12000.0),
    metavar="M",
    help="Depth of the origin under a calm surface. [default: deep water]",
)
mean_options = combine_options(  # which average motions into the linear coefficients
    *(
        click.option(
            f"--mean-{name}",
            type=MEAN_MOTION_TYPE,
            default=0.0,
            help=f"Mean |{name}| [{unit}], for the quasi-linear coefficients.",
        )
        for name, unit in {"v": "m/s", "w": "m/s", "p": "rad/s", "q": "rad/s", "r": "rad/s"}.items()
    )
)


@click.command()
@click.argument("full", type=CSV_FILE)
@click.argument("other", type=CSV_FILE)
@click.option("--column", "columns", multiple=True, metavar="NAME", help="[default: u z r, angles]")
@click.option(
    "--until",
    type=Number(0.0, min_open=True),
    default=120.0,
    help="Seconds looked at, from the start.",
)
@click.option(
    "--allow", type=Number(0.0, 1000.0), default=5.0, help="Percent change of change that passes."
)
@outputs
def compare(full: Path, other: Path, columns: tuple[str, ...], **options: Any) -> None:
    """Percent change of change of two runs (ZC590, ZC691).

    Both are CSV files, as `trainer run --csv` writes them: FULL is taken as true, OTHER is
    judged.

    \b
    Example:  trainer report-1969 compare full.csv modified.csv --column theta --column z

    Where rudder or planes are thrown over a step apart, which is how well the time of an event is
    known, what that is worth is no failure.

    Exit code 1 when a change of change is beyond what is allowed.
    """
    from trainer.analysis.programs import compare as program
    from trainer.config.ship.series import load_series

    runs = load_series(full), load_series(other)
    event = program.event_apart(*runs)
    report = program.compare_runs(*runs, columns, options["until"], options["allow"], event)
    show_report(report, program.render, lambda: program.panels(report, *runs), options)
    sys.exit(0 if report.passed else 1)


@click.command()
@click.argument("run", type=CSV_FILE)
@click.option("--column", default="theta", metavar="NAME", help="What to fit.")
@click.option("--from", "begin", type=Number(), default=0.0, help="First second.")
@click.option(
    "--to",
    "end",
    type=Number(),
    default=1e9,
    show_default=False,
    help="Last second. [default: the run's]",
)
@click.option("--about", type=Number(), help="Rest value. [default: the first row's]")
@click.option(
    "--vessel", type=VESSEL_NAME, metavar="VESSEL", help="Start from this boat's roots ..."
)
@click.option("--speed", type=AHEAD_SPEED_TYPE, metavar="KN", help="... at this speed.")
@click.option(
    "--plane",
    type=click.Choice(("vertical", "horizontal")),
    default="vertical",
    help="A cubic's roots (w, q, theta, z, u) or a quartic's (v, p, r, phi).",
)
@click.option(
    "--order",
    type=click.IntRange(1, 8),
    help="Number of roots without a vessel. [default: 3 vertical, 4 horizontal]",
)
@outputs
def fit(run: Path, column: str, **options: Any) -> None:
    """Fit damped sinusoids to a response (EC310).

    \b
    Example:  trainer report-1969 fit impulse.csv --column theta --from 20 --vessel bb2 --speed 10

    The starting roots are those of a vessel, or else of the response itself (EC120, EC150,
    EC330). Exit code 1 when the fit does not settle.
    """
    from trainer.analysis.programs import fit as program
    from trainer.config.ship.series import load_series

    span = options["begin"], options["end"]
    t, y, level = program.response_in(load_series(run), column, span, options["about"])
    starts, origin = starting_roots(t, y, options)
    report = program.FitReport(
        file=str(run),
        column=column,
        begin_s=float(t[0]),
        end_s=float(t[-1]),
        samples=len(t),
        about=level,
        roots_from=origin,
        fit=program.fit_modes(t, y, starts),
    )
    show_report(report, program.render, lambda: program.panels(report, t, y), options)
    sys.exit(0 if report.fit.converged else 1)


def starting_roots(t: Any, y: Any, options: dict[str, Any]) -> tuple[list[complex], str]:
    """Return the roots [1/s] to start from, and their source; UsageError if half is given."""
    from trainer.analysis.programs.characteristic import horizontal_system, vertical_system
    from trainer.analysis.programs.fit import one_of_each, pencil_roots
    from trainer.config.boat.vessel import load_vessel
    from trainer.units import KNOT

    vessel, speed, plane = options["vessel"], options["speed"], options["plane"]
    if (vessel is None) != (speed is None):
        raise click.UsageError("--vessel and --speed go together: a boat's roots are at a speed")
    if vessel is None:
        order = options["order"] or {"vertical": 3, "horizontal": 4}[plane]
        return one_of_each(pencil_roots(t, y, order)), "the response itself"
    system_of = {"vertical": vertical_system, "horizontal": horizontal_system}[plane]
    linear = system_of(load_vessel(vessel), speed * KNOT)
    program = {"vertical": "EC140", "horizontal": "EC200"}[plane]
    roots = [complex(root) for root in linear.eigenvalues]
    return one_of_each(roots), f"{program}, {vessel} at {speed:g} kn"


def speeds_of(file: Any, given: tuple[float, ...]) -> tuple[float, ...]:
    """Return the speeds [kn] given, or round ones over the vessel's range."""
    from trainer.analysis.check import round_speeds

    return tuple(dict.fromkeys(given)) or round_speeds(*file.run.speed_range_kn)


@click.command()
@click.argument("vessel", type=VESSEL_NAME)
@SPEEDS_OPTION
@DEPTH_OPTION
@outputs
def neutral(vessel: str, speeds: tuple[float, ...], depth: float | None, **how: Any) -> None:
    """Plane angles for level flight, critical speeds (EC470).

    \b
    Example:  trainer report-1969 neutral bb2 --speed 5 --speed 10 --plot neutral.png
              trainer report-1969 neutral bb2 --depth 15

    With --depth the force and moment of a calm surface act, by the vessel's [free_surface].
    """
    from trainer.analysis.programs import neutral as program
    from trainer.config.boat.vessel import load_vessel

    file = load_vessel(vessel)
    report = program.report_neutral(file, speeds_of(file, speeds), depth)
    show_report(report, program.render, lambda: program.panels(file, report), how)


@click.command()
@click.argument("vessel", type=VESSEL_NAME)
@click.option(
    "--speed",
    "speeds",
    type=SPEED_TYPE,
    multiple=True,
    metavar="KN",
    help="Speed in knots, 0 at rest, may be repeated. [default: rest, and about six speeds]",
)
@click.option(
    "--command",
    "commands",
    type=COMMAND_SPEED_TYPE,
    multiple=True,
    metavar="KN",
    help="Command speed in knots, astern negative, may be repeated. [default: the bells]",
)
@outputs
def thrust(vessel: str, speeds: tuple[float, ...], commands: tuple[float, ...], **how: Any) -> None:
    """Thrust less drag, and acceleration, by speed (ZC300).

    \b
    Example:  trainer report-1969 thrust bb2 --speed 0 --speed 10 --command 15 --command -5
    """
    from trainer.analysis.programs import thrust as program
    from trainer.config.boat.vessel import load_vessel

    file = load_vessel(vessel)
    ahead = speeds or (0.0, *speeds_of(file, ()))
    ordered = tuple(dict.fromkeys(commands)) or program.command_speeds(file)
    report = program.survey_thrust(file, ahead, ordered)
    show_report(report, program.render, lambda: program.panels(file, report), how)


class TankFill(click.ParamType[tuple[str, float]]):
    """A tank and how full it is: NAME=SHARE."""

    name = "fill"

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        """Return name and share [-]."""
        name, _, share = str(value).partition("=")
        try:
            return name.strip(), float(share)
        except ValueError:
            self.fail(f"{value!r} is not a tank and its filling, such as auxiliary=0.5", param, ctx)


@click.command()
@click.argument("vessel", type=VESSEL_NAME)
@click.option(
    "--fill",
    "fills",
    type=TankFill(),
    multiple=True,
    metavar="TANK=SHARE",
    help="How full a tank is, 0 to 1, may be repeated. [default: the vessel file's]",
)
@click.option("--overshoots", is_flag=True, help="What x_G and z_G do to an overshoot.")
@outputs
def tanks(
    vessel: str, fills: tuple[tuple[str, float], ...], *, overshoots: bool, **how: Any
) -> None:
    """Weight and balance over all fillings (EC430).

    \b
    Example:  trainer report-1969 tanks bb2 --fill auxiliary=1 --plot polygon.svg
              trainer report-1969 tanks bb2 --overshoots --plot overshoots.svg

    With --overshoots the table of 1969 instead: the same overshoot slow and fast, x_G and z_G
    alone moved as far as the tanks do, or by 2 % of BG where there are none.
    """
    from trainer.analysis.programs import tanks as program
    from trainer.config.boat.vessel import load_vessel

    names = [name for name, _ in fills]
    twice = [name for name in dict.fromkeys(names) if names.count(name) > 1]
    if twice:
        raise click.UsageError(f"--fill {twice[0]} is given twice")
    file = load_vessel(vessel)
    if overshoots:
        changes, flights = program.survey_tankage(file, dict(fills))
        drawn = partial(program.overshoot_panels, changes, flights)
        show_report(changes, program.render_overshoots, drawn, how)
        return
    report = program.report_fillings(file, dict(fills))
    show_report(report, program.render, lambda: program.panels(report), how)


@click.command()
@click.argument("vessel", type=VESSEL_NAME)
@SPEEDS_OPTION
@DEPTH_OPTION
@mean_options
@outputs
def modes(vessel: str, speeds: tuple[float, ...], depth: float | None, **options: Any) -> None:
    """Roots, frequencies, damping (EC140, EC200, EC320).

    \b
    Example:  trainer report-1969 modes bb2 --speed 10 --mean-w 0.2
              trainer report-1969 modes bb2 --speed 6 --depth 16

    With --depth the vertical plane feels how the force of a calm surface changes with depth.
    """
    from trainer.analysis.programs import characteristic as program
    from trainer.config.boat.vessel import load_vessel

    file = load_vessel(vessel)
    means = program.MeanMotions(
        **{name: options[f"mean_{name}"] for name in program.MeanMotions._fields}
    )
    report = program.report_modes(file, speeds_of(file, speeds), means, depth)
    show_report(report, program.render, lambda: program.panels(report), options)
