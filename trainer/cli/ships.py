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
