"""The engineer's programs of 1969 that ask recorded runs."""

import sys
from pathlib import Path
from typing import Any

import click

from trainer.cli.answers import AHEAD, Number, outputs, show
from trainer.cli.shared_options import CSV, VESSEL


@click.command()
@click.argument("full", type=CSV)
@click.argument("other", type=CSV)
@click.option("--column", "columns", multiple=True, metavar="NAME", help="[default: u z r, angles]")
@click.option(
    "--until",
    type=Number(0.0, min_open=True),
    default=120.0,
    show_default=True,
    help="Seconds looked at, from the start.",
)
@click.option(
    "--allow",
    type=Number(0.0, 1000.0),
    default=5.0,
    show_default=True,
    help="Percent change of change that passes.",
)
@outputs
def compare(full: Path, other: Path, columns: tuple[str, ...], **options: Any) -> None:
    """Percent change of change of two runs (ZC590, ZC691).

    Both are CSV files, as `trainer run --csv` writes them: FULL is taken as true, OTHER is
    judged.

    \b
    Example:  trainer compare full.csv modified.csv --column theta --column z

    Where rudder or planes are thrown over a step apart, which is how well the time of an event is
    known, what that is worth is no failure.

    Exit code 1 when a change of change is beyond what is allowed.
    """
    from trainer.analysis import compare as page  # noqa: PLC0415
    from trainer.analysis import compare as program  # noqa: PLC0415
    from trainer.analysis.series import load_series  # noqa: PLC0415

    runs = load_series(full), load_series(other)
    event = program.event_apart(*runs)
    report = program.compare(*runs, columns, options["until"], options["allow"], event)
    show(report, page.render, lambda: page.panels(report, *runs), options)
    sys.exit(0 if report.passed else 1)


@click.command()
@click.argument("run", type=CSV)
@click.option("--column", default="theta", show_default=True, metavar="NAME", help="What to fit.")
@click.option(
    "--from", "begin", type=Number(), default=0.0, show_default=True, help="First second."
)
@click.option("--to", "end", type=Number(), default=1e9, help="Last second. [default: the run's]")
@click.option("--about", type=Number(), default=None, help="Rest value. [default: the first row's]")
@click.option(
    "--vessel", type=VESSEL, default=None, metavar="VESSEL", help="Start from this boat's roots ..."
)
@click.option("--speed", type=AHEAD, default=None, metavar="KN", help="... at this speed.")
@click.option(
    "--plane",
    type=click.Choice(("vertical", "horizontal")),
    default="vertical",
    show_default=True,
    help="A cubic's roots (w, q, theta, z, u) or a quartic's (v, p, r, phi).",
)
@click.option(
    "--order",
    type=click.IntRange(1, 8),
    default=None,
    help="Number of roots without a vessel. [default: 3 vertical, 4 horizontal]",
)
@outputs
def fit(run: Path, column: str, **options: Any) -> None:
    """Fit damped sinusoids to a response (EC310).

    \b
    Example:  trainer fit impulse.csv --column theta --from 20 --vessel bb2 --speed 10

    The starting roots are those of a vessel, or else of the response itself (EC120, EC150,
    EC330). Exit code 1 when the fit does not settle.
    """
    from trainer.analysis import fit as page  # noqa: PLC0415
    from trainer.analysis import fit as program  # noqa: PLC0415
    from trainer.analysis.series import load_series  # noqa: PLC0415

    span = options["begin"], options["end"]
    t, y, level = program.response_in(load_series(run), column, span, options["about"])
    starts, origin = starting_roots(t, y, options)
    report = program.Report(
        file=str(run),
        column=column,
        begin_s=float(t[0]),
        end_s=float(t[-1]),
        samples=len(t),
        about=level,
        roots_from=origin,
        fit=program.fit(t, y, starts),
    )
    show(report, page.render, lambda: page.panels(report, t, y), options)
    sys.exit(0 if report.fit.converged else 1)


def starting_roots(t: Any, y: Any, options: dict[str, Any]) -> tuple[list[complex], str]:
    """Return the roots [1/s] to start from, and their source; UsageError if half is given."""
    from trainer.analysis import characteristic  # noqa: PLC0415
    from trainer.analysis.fit import one_of_each, pencil_roots  # noqa: PLC0415
    from trainer.config.vessel import load_vessel  # noqa: PLC0415
    from trainer.units import KNOT  # noqa: PLC0415

    vessel, speed, plane = options["vessel"], options["speed"], options["plane"]
    if (vessel is None) != (speed is None):
        raise click.UsageError("--vessel and --speed go together: a boat's roots are at a speed")
    if vessel is None:
        order = options["order"] or {"vertical": 3, "horizontal": 4}[plane]
        return one_of_each(pencil_roots(t, y, order)), "the response itself"
    linear = getattr(characteristic, plane)(load_vessel(vessel), speed * KNOT)
    program = {"vertical": "EC140", "horizontal": "EC200"}[plane]
    return one_of_each(linear.eigenvalues), f"{program}, {vessel} at {speed:g} kn"
