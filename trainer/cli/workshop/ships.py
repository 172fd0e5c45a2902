"""What the commands ``identify`` and ``manoeuvre`` do with ships that are not linear.

Both commands take a boat or such a ship as the same argument; they ask ``is_ship``, and leave a
ship to this module.
"""

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

import click

from trainer.cli.answers import show_report
from trainer.cli.options import flags_given, options_given
from trainer.config.keywords import fill_record
from trainer.config.ship.fit_options import SHIP_MODELS
from trainer.report.progress import print_note, show_step, write_text

if TYPE_CHECKING:
    from trainer.config.ship.sensors import Sensors

SHIP_KERNELS: Final = "boat/ship", "identify/kernels"
SHIP_KERNELS_TEXT: Final = "the kernels of ships, once (some 20 s)"
# fmt: off
LINEAR_FIT_OPTIONS: Final = (  # options that these models do not know
    "vessel", "length", "knots", "channels", "noise", "method", "exact", "armax", "most",
    "against", "check", "kappa", "checkpoint", "write_nomoto", "write_vessel",
    "simulate", "data_only", "bech", "spiral", "joint", "matrices", "csv", "system", "reject",
)
# Options of a linear ship's fit, which no other page than its own carries out.
MODEL_PAGE_OPTIONS: Final = (
    "csv", "write_nomoto", "write_vessel", "matrices", "check", "checkpoint", "against", "without",
    "kappa", "bech", "spiral", "joint",
)
NONLINEAR_FIT_OPTIONS: Final = ("ship", "prior_strength", "predict", "write_ship", "coefficients")
# fmt: on
# Options of experiments that ships do not know.
BOAT_TRIAL_OPTIONS: Final = ("depth", "periods", "by", "sea", "write")
SEQUENCE_OPTIONS: Final = ("bits", "hold", "seed")  # options that need an amplitude


def is_ship(vessel: str) -> bool:
    """Return whether a name or path is that of a ship that is not linear."""
    from trainer.api.programs import ship_path
    from trainer.config.ship.ship import is_ship as is_ships_file

    path = ship_path(vessel)
    return path.suffix == ".toml" and path.is_file() and is_ships_file(path)


def design_trials(path: Path, options: dict[str, Any]) -> None:
    """Design trials of a ship and show what they would tell."""
    if unknown := flags_given(BOAT_TRIAL_OPTIONS):
        raise click.UsageError(f"{unknown}: not with a ship, {path.name}")
    typed_options = options_given()
    # Only a boat's experiment has a default amplitude: a ship may sail a zig-zag alone.
    if "amplitude" not in typed_options:
        options = {**options, "amplitude": None}
        if lone := flags_given(SEQUENCE_OPTIONS):
            raise click.UsageError(f"{lone}: of a sequence: say its --amplitude")
    if options["zigzag"] is None and options["amplitude"] is None:
        raise click.UsageError(
            f"{path.name} is a ship: say its --zigzag, such as 20/20, or the --amplitude of a "
            "binary sequence"
        )
    from trainer.boat import compilation
    from trainer.config.ship.ship import load_ship
    from trainer.identify.ships import trials

    ship = load_ship(path)
    sensors = trials.sensors_of(ship, sensors_asked(options), typed_options)
    wishes = fill_record(trials.TrialOptions, options, sensors=sensors)
    with compilation.announce_compiling(SHIP_KERNELS_TEXT, print_note, "ships", *SHIP_KERNELS):
        design = trials.design_trials(ship, wishes)
    show_report(design.report, trials.render, lambda: trials.panels(design), options)


def sensors_asked(options: dict[str, Any]) -> "Sensors":
    """Return the errors of the instruments, from an experiment's options."""
    from trainer.config.ship.sensors import Sensors

    return Sensors(
        sway_kn=options["sway"], yaw_rate_deg_s=options["yaw_rate"], heading_deg=options["heading"]
    )


def refuse_idle(options: Mapping[str, Any]) -> None:
    """Refuse options that the page of a linear ship or a record would leave out."""
    if idle := flags_given(NONLINEAR_FIT_OPTIONS):
        instead = "; --write-nomoto writes this ship" if options["write_ship"] else ""
        known = ", ".join(SHIP_MODELS)
        raise click.UsageError(f"{idle}: with --model {known} alone{instead}")
    pages = {"data_only": ("html", *MODEL_PAGE_OPTIONS), "armax": MODEL_PAGE_OPTIONS}
    for page, unused in pages.items():
        if options[page] and (idle := flags_given(unused)):
            raise click.UsageError(f"{idle}: not with --{page.replace('_', '-')}")


def identify(files: tuple[Path, ...], options: dict[str, Any]) -> int:
    """Fit a ship to its records and show it; return the exit code."""
    if unknown := flags_given(LINEAR_FIT_OPTIONS):
        raise click.UsageError(f"{unknown}: not with the models {', '.join(SHIP_MODELS)}")
    from trainer.boat import compilation
    from trainer.config.files import path_named
    from trainer.config.ship.ship import ship_text
    from trainer.identify.options import IdentifyOptions
    from trainer.identify.ships import page
    from trainer.identify.ships.results import fit_trials, read_trials

    if options["ship"] is not None:
        options = {**options, "ship": path_named(options["ship"], "ships")}
    wishes = fill_record(IdentifyOptions, options)
    ship, trials, held = read_trials(files, wishes)
    with compilation.announce_compiling(SHIP_KERNELS_TEXT, print_note, "ships", *SHIP_KERNELS):
        result = fit_trials(ship, trials, held, wishes, show_step)
    if options["write_ship"]:
        sources = ", ".join(Path(source).name for source in result.report.sources)
        write_text(options["write_ship"], ship_text(result.ship, f"trainer identify, {sources}"))
    if options["coefficients"]:
        write_text(options["coefficients"], page.coefficients_text(result.report))
    if options["html"]:
        write_text(options["html"], page.sheet(result))
    show_report(result.report, page.render, lambda: page.panels(result), options)
    return 0 if result.report.settled else 1


def print_figures(vessel: str, *, as_json: bool) -> None:
    """Print the published figures of a ship beside ours; UsageError for options of boats."""
    if boats := flags_given(options_given() - {"vessel", "as_json"}):
        raise click.UsageError(f"{vessel} is a ship, and {boats} of boats' guides")
    from trainer.analysis.guide.trials import load_published
    from trainer.api.programs import ship_path
    from trainer.boat import compilation
    from trainer.cli.answers import json_of
    from trainer.config.ship.ship import load_ship
    from trainer.identify.ships import published

    ship = load_ship(ship_path(vessel))
    figures = load_published(published.figures_path(ship))
    with compilation.announce_compiling(SHIP_KERNELS_TEXT, print_note, "ships", *SHIP_KERNELS):
        compared = published.compare_ship(ship, figures)
    text = published.render(ship, figures, compared)
    click.echo(json_of(list(published.figures_of(compared))) if as_json else text)
