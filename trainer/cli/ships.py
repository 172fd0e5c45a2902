"""Ships that are not linear, for the commands that identify and sail them."""

import contextlib
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any, Final

import click

from trainer.cli.answers import show
from trainer.cli.options import options_given
from trainer.config.files import ConfigError

MODELS: Final = ("linear", "mavmm", "abkowitz", "mmg")
FOR_OTHERS: Final = (  # options that these models do not know
    *("vessel", "length", "knots", "channels", "noise", "method", "exact", "armax", "most"),
    *("against", "check", "kappa", "checkpoint", "write_nomoto", "write_vessel"),
    *("simulate", "data_only", "bech", "spiral", "joint", "matrices", "csv", "system", "reject"),
)
FOR_BOATS: Final = (  # options of experiments that ships do not know
    *("depth", "amplitude", "bits", "hold", "periods", "seed", "by", "sea", "write"),
)


def is_ship(vessel: str) -> bool:
    """Return whether a vessel is the file of a ship that is not linear."""
    from trainer.identify.ships import ship_file  # noqa: PLC0415

    path = Path(vessel)
    return path.suffix == ".toml" and path.is_file() and ship_file.is_ship(path)


def design_trials(path: Path, options: dict[str, Any]) -> None:
    """Design trials of a ship and show what they would tell."""
    given = options_given()
    unknown = [f"--{option}" for option in FOR_BOATS if option in given]
    if unknown:
        raise click.UsageError(f"{', '.join(unknown)}: not with a ship, {path.name}")
    if options["zigzag"] is None:
        raise click.UsageError(f"{path.name} is a ship: say its --zigzag, such as 20/20")
    from trainer.identify.ships import trials  # noqa: PLC0415
    from trainer.identify.ships.ship_file import load_ship  # noqa: PLC0415

    ship = load_ship(path)
    sensors = trials.sensors_of(ship, options, given)
    with _announcing():
        found = trials.design(ship, {**options, "sensors": sensors})
    show(found.report, trials.render, lambda: trials.panels(found), options)


def identify(files: tuple[Path, ...], options: dict[str, Any]) -> int:
    """Fit a ship to its records and show it; return the exit code."""
    unknown = [f"--{option}" for option in FOR_OTHERS if option in options_given()]
    if unknown:
        known = ", ".join(MODELS)
        raise click.UsageError(f"{', '.join(unknown)}: not with the models {known}")
    from trainer.identify.ships import page  # noqa: PLC0415
    from trainer.identify.ships.results import carry_out  # noqa: PLC0415
    from trainer.identify.ships.ship_file import ship_text  # noqa: PLC0415

    with _announcing():
        found = carry_out(files, options, _progress)
    if options["write_ship"]:
        sources = ", ".join(Path(source).name for source in found.report.sources)
        _write(options["write_ship"], ship_text(found.ship, f"trainer identify, {sources}"))
    if options["coefficients"]:
        page.write_coefficients(found.report, options["coefficients"])
    if options["html"]:
        _write(options["html"], page.sheet(found))
    show(found.report, page.render, lambda: page.panels(found), options)
    return 0 if found.report.settled else 1


@contextlib.contextmanager
def _announcing() -> Iterator[None]:
    """Say that the kernels are compiled in the block, where they have not been before."""
    from trainer.boat import compilation  # noqa: PLC0415

    compiled = compilation.mark("ships", "identify/kernels")
    if not compiled.exists() and not compilation.is_interpreted():
        click.echo("compiling the kernels of ships, once (some 20 s) ...", err=True)
    yield
    with contextlib.suppress(OSError):
        compiled.touch()


def _progress(step: int, cost: float) -> None:
    """Show how far a fit is, on a terminal."""
    if sys.stderr.isatty():
        click.echo(f"\rstep {step}, -log L {cost:.4f}  ", nl=False, err=True)


def _write(path: Path, text: str) -> None:
    """Write a text; ConfigError if it cannot be."""
    from trainer.io.atomic_write import write_whole  # noqa: PLC0415

    try:
        write_whole(path, text)
    except OSError as error:
        raise ConfigError(f"{path}: cannot be written: {error.strerror}") from error
