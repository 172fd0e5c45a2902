"""The engineer's programs of 1969 that read a vessel file.

Those that read runs are in responses.
"""

from typing import Any, Final

import click

from trainer.cli.answers import AHEAD, SPEED, Number, outputs, show
from trainer.cli.responses import compare, fit
from trainer.cli.shared_options import VESSEL

COMMAND: Final = Number(-60.0, 60.0)
MEAN: Final = Number(0.0, 50.0)

SPEEDS: Final = click.option(
    "--speed",
    "speeds",
    type=AHEAD,
    multiple=True,
    metavar="KN",
    help="Speed in knots, may be repeated. [default: about six over the boat's range]",
)

DEPTH: Final = click.option(
    "--depth",
    type=Number(0.0, 12000.0),
    default=None,
    metavar="M",
    help="Depth of the origin under a calm surface. [default: deep water]",
)


def speeds_of(file: Any, given: tuple[float, ...]) -> tuple[float, ...]:
    """Return the speeds [kn] given, or round ones over the vessel's range."""
    from trainer.analysis.check import round_speeds  # noqa: PLC0415

    return tuple(dict.fromkeys(given)) or round_speeds(*file.run.speed_range_kn)


@click.command()
@click.argument("vessel", type=VESSEL)
@SPEEDS
@DEPTH
@outputs
def neutral(vessel: str, speeds: tuple[float, ...], depth: float | None, **how: Any) -> None:
    """Plane angles for level flight, critical speeds (EC470).

    \b
    Example:  trainer neutral bb2 --speed 5 --speed 10 --plot neutral.png
              trainer neutral bb2 --depth 15

    With --depth the force and moment of a calm surface act, by the vessel's [free_surface].
    """
    from trainer.analysis import neutral as program  # noqa: PLC0415
    from trainer.config.vessel import load_vessel  # noqa: PLC0415

    file = load_vessel(vessel)
    report = program.neutral(file, speeds_of(file, speeds), depth)
    show(report, program.render, lambda: program.panels(file, report), how)


@click.command()
@click.argument("vessel", type=VESSEL)
@click.option(
    "--speed",
    "speeds",
    type=SPEED,
    multiple=True,
    metavar="KN",
    help="Speed in knots, 0 at rest, may be repeated. [default: rest, and about six speeds]",
)
@click.option(
    "--command",
    "commands",
    type=COMMAND,
    multiple=True,
    metavar="KN",
    help="Command speed in knots, astern negative, may be repeated. [default: the bells]",
)
@outputs
def thrust(vessel: str, speeds: tuple[float, ...], commands: tuple[float, ...], **how: Any) -> None:
    """Thrust less drag, and acceleration, by speed (ZC300).

    \b
    Example:  trainer thrust bb2 --speed 0 --speed 10 --command 15 --command -5
    """
    from trainer.analysis import thrust as program  # noqa: PLC0415
    from trainer.config.vessel import load_vessel  # noqa: PLC0415

    file = load_vessel(vessel)
    ahead = speeds or (0.0, *speeds_of(file, ()))
    ordered = tuple(dict.fromkeys(commands)) or program.command_speeds(file)
    report = program.survey(file, ahead, ordered)
    show(report, program.render, lambda: program.panels(file, report), how)


class Fill(click.ParamType[tuple[str, float]]):
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
@click.argument("vessel", type=VESSEL)
@click.option(
    "--fill",
    "fills",
    type=Fill(),
    multiple=True,
    metavar="TANK=SHARE",
    help="How full a tank is, 0 to 1, may be repeated. [default: the vessel file's]",
)
@outputs
def tanks(vessel: str, fills: tuple[tuple[str, float], ...], **how: Any) -> None:
    """Weight and balance over all fillings (EC430).

    \b
    Example:  trainer tanks bb2 --fill auxiliary=1 --plot polygon.svg
    """
    from trainer.analysis import tanks as program  # noqa: PLC0415
    from trainer.config.vessel import load_vessel  # noqa: PLC0415

    names = [name for name, _ in fills]
    twice = [name for name in dict.fromkeys(names) if names.count(name) > 1]
    if twice:
        raise click.UsageError(f"--fill {twice[0]} is given twice")
    report = program.fillings(load_vessel(vessel), dict(fills))
    show(report, program.render, lambda: program.panels(report), how)


MEANS: Final = [
    click.option(
        f"--mean-{name}",
        type=MEAN,
        default=0.0,
        show_default=True,
        help=f"Mean |{name}| [{unit}], for the quasi-linear coefficients.",
    )
    for name, unit in {"v": "m/s", "w": "m/s", "p": "rad/s", "q": "rad/s", "r": "rad/s"}.items()
]


def mean_options(command: Any) -> Any:
    """Add the options that average motions into the linear coefficients."""
    for option in reversed(MEANS):
        command = option(command)
    return command


@click.command()
@click.argument("vessel", type=VESSEL)
@SPEEDS
@DEPTH
@mean_options
@outputs
def modes(vessel: str, speeds: tuple[float, ...], depth: float | None, **options: Any) -> None:
    """Roots, frequencies, damping (EC140, EC200, EC320).

    \b
    Example:  trainer modes bb2 --speed 10 --mean-w 0.2
              trainer modes bb2 --speed 6 --depth 16

    With --depth the vertical plane feels how the force of a calm surface changes with depth.
    """
    from trainer.analysis import characteristic as program  # noqa: PLC0415
    from trainer.config.vessel import load_vessel  # noqa: PLC0415

    file = load_vessel(vessel)
    means = program.Means(**{name: options[f"mean_{name}"] for name in program.Means._fields})
    report = program.characteristic(file, speeds_of(file, speeds), means, depth)
    show(report, program.render, lambda: program.panels(report), options)


PROGRAMS: Final = [neutral, thrust, tanks, modes, compare, fit]
