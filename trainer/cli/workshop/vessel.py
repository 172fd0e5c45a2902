"""The commands that examine a vessel file, and that find its compact set of coefficients.

``main`` has them: ``new``, ``check``, ``plant``, ``gains``, ``reduce``, ``sea`` and ``evaluate``.
The figures come from ``analysis``; here options are read and answers shown.
"""

import sys
from dataclasses import asdict
from pathlib import Path
from typing import Any

import click

from trainer.cli.answers import json_of, outputs, show_report
from trainer.cli.options import (
    SEA_NAME,
    SVG_OUTPUT,
    TOML_OUTPUT,
    VESSEL_HELP,
    VESSEL_NAME,
    cores_option,
    method_options,
)
from trainer.cli.types import Number
from trainer.report.progress import show_progress, write_text


@click.command()
@click.argument("file", type=TOML_OUTPUT)
@click.option("--from", "source", type=VESSEL_NAME, default="bb2", help=VESSEL_HELP)
@click.option(
    "--length",
    type=Number(0.3, 400.0),
    metavar="M",
    help="Of the new boat. [default: that of the source, a copy]",
)
@click.option("--name", help="Of the new boat.")
def new(file: Path, source: str, length: float | None, name: str | None) -> None:
    """Write a complete vessel file with comments, to be changed; never over another file.

    \b
    Example:  trainer boat new boat.toml --from bb2 --length 60
              trainer boat new twin.toml --from sdv-mk9 --name "My boat"

    With --length every number follows the length by Froude's law; each law stands in the file.
    """
    from trainer.config.boat.vessel_template import write_new

    click.echo(write_new(file, source, length, name))


@click.command()
@click.argument("vessel", type=VESSEL_NAME)
@method_options
@click.option("--wide", is_flag=True, help="Beyond the coefficients' range and at the surface too.")
def evaluate(
    vessel: str, equations: str | None, rates: str | None, trig: str, *, wide: bool
) -> None:
    """Accelerations for states read as JSON lines: the check interface.

    \b
    Example:  trainer boat evaluate bb2 --equations full --rates exact < states.jsonl
              trainer boat evaluate bb2 --wide < states.jsonl

    Each line of input is an object with u v w p q r phi theta psi delta_r delta_s delta_b u_c
    (SI, rad), optionally x_g y_g z_g weight and last_udot ... last_rdot; each line of output
    the twelve rates. Without --wide they are the equations of 1969 alone, in deep water, whatever
    the state is. With it any state may be given, going astern, at any attitude or surfaced: each
    line has z as well, and the water is calm.
    """
    from trainer.analysis.programs.evaluate import evaluate_lines as rates_of
    from trainer.config.boat.vessel import load_vessel

    file = load_vessel(vessel)
    for line in rates_of(
        file,
        equations or file.own_equations,
        rates or "exact",
        trig,
        sys.stdin or (),
        wide=wide,
    ):
        click.echo(line)


@click.command()
@click.argument("vessel", type=VESSEL_NAME)
@click.option("--constants", is_flag=True, help="List every constant, and where it comes from.")
@click.option("--json", "as_json", is_flag=True, help="Print the figures as JSON.")
def check(vessel: str, *, constants: bool, as_json: bool) -> None:
    """Say what a vessel file lacks, how the boat behaves, and which step is stable.

    \b
    Example:  trainer boat check bb2
              trainer boat check bb2 --constants

    Exit code 1 when the boat's own step makes it unstable though it is stable by nature, or when
    the compact set is not within tolerance of the full one. The page ends with what the file lacks
    and the command that makes it. With --constants nothing is judged: all that the core is given
    is listed, in SI units and radians.
    """
    if constants:
        list_constants(vessel, as_json=as_json)
        return
    from trainer.analysis.check import check_vessel as examine
    from trainer.analysis.check_page import examine_boat, render, render_readiness
    from trainer.config.boat.vessel import load_vessel

    file = load_vessel(vessel)
    report, ready = examine(file), examine_boat(file)
    if as_json:
        click.echo(json_of({**asdict(report), "readiness": asdict(ready)}))
    else:
        click.echo(f"{render(report)}\n{render_readiness(ready)}")
    sys.exit(0 if report.own_step_stable and ready.passed else 1)


def list_constants(vessel: str, *, as_json: bool) -> None:
    """Print every constant of a vessel; ConfigError if there is no such vessel."""
    from trainer.analysis.programs.constants import list_vessel_constants, render
    from trainer.config.boat.vessel import load_vessel

    report = list_vessel_constants(load_vessel(vessel))
    click.echo(json_of(asdict(report)) if as_json else render(report))


@click.command()
@click.argument("vessel", type=VESSEL_NAME)
@click.option("--svg", type=SVG_OUTPUT, metavar="FILE", help="Draw it too.")
def plant(vessel: str, svg: Path | None) -> None:
    """Say what feeds what in a boat: battery, buses, oil, surfaces, fire.

    \b
    Example:  trainer boat plant bb2
              trainer boat plant bb2 --svg plant.svg

    It is made from the table [plant] of the vessel file. Exit code 2 for a boat without one.
    """
    from trainer.analysis.plant_page import draw_feeds, feed_page
    from trainer.config.boat.vessel import load_vessel

    file = load_vessel(vessel)
    click.echo(feed_page(file))
    if svg:
        write_text(svg, draw_feeds(file), "--svg")


@click.command()
@click.argument("vessel", type=VESSEL_NAME)
def gains(vessel: str) -> None:
    """Design the autopilot of a boat and print the table for its vessel file.

    \b
    Example:  trainer boat gains my-boat.toml >> my-boat.toml
    """
    from trainer.analysis.gains import design_text
    from trainer.config.boat.vessel import load_vessel

    click.echo(design_text(load_vessel(vessel)))


@click.command()
@click.argument("name", type=SEA_NAME, metavar="SEA")
@click.option("--vessel", type=VESSEL_NAME, default="bb2", help="The boat in it.")
@click.option(
    "--depth",
    "depths",
    type=Number(0.0, 1000.0, min_open=True),
    multiple=True,
    metavar="M",
    help="Depth in metres, may be repeated. [default: some, periscope depth among them]",
)
@click.option("--step", type=Number(1e-3, 2.0), help="[default: the boat's]")
@outputs
def sea(name: str, vessel: str, depths: tuple[float, ...], step: float | None, **how: Any) -> None:
    """Show a sea: its waves, their energy by band, the suction on a boat.

    \b
    Example:  trainer boat sea sea-state-5 --plot sea.svg

    SEA is calm, sea-state-1 to sea-state-6, or a file. The suction is that of a
    Pierson-Moskowitz sea on a boat held still.
    """
    from trainer.analysis import seaway
    from trainer.config.boat.vessel import load_vessel
    from trainer.config.world.sea import load_sea

    file, boat = load_sea(name), load_vessel(vessel)
    at = tuple(dict.fromkeys(depths)) or seaway.usual_depths(boat)
    report = seaway.survey(file, boat, at, boat.run.step_s if step is None else step)
    show_report(report, seaway.render, lambda: seaway.panels(file, boat, report), how)


@click.command()
@click.argument("vessel", type=VESSEL_NAME)
@click.option("-o", "--output", type=TOML_OUTPUT, metavar="FILE", help="Write the boat so.")
@click.option("--write", is_flag=True, help="Write it into the vessel file itself.")
@click.option("--check", is_flag=True, help="Judge the set that the file has; no search.")
@click.option("--table", is_flag=True, help="Only the table of sensitivities.")
@click.option("--quick", is_flag=True, help="Keep a term whose loss takes long to make up for.")
@click.option("--json", "as_json", is_flag=True, help="Print the figures as JSON.")
@cores_option
def reduce(vessel: str, **options: Any) -> None:
    """Find the compact set of a boat: the fewest terms that pass the guide.

    Each coefficient put to zero, then terms dropped one after the other and the factors of the rest
    fitted, down to where the guide would fail; judged by the guide, by steady turns, and at 10 % by
    manoeuvres that neither the fit nor the choice has seen.

    \b
    Example:  trainer boat reduce bb2 --check
              trainer boat reduce ./boat.toml -o boat-compact.toml

    VESSEL is bb2, sdv-mk9, remus100, or the path of a vessel file. With -o or --write an
    interrupted search goes on where it was. Nothing in it is random. Exit code 1 when the set is
    out of tolerance.
    """
    from trainer.analysis.reduce import page, reduction
    from trainer.config.boat.vessel import load_vessel
    from trainer.workers import processor_count

    chosen = [name for name in ("check", "table", "write", "output") if options[name]]
    if len(chosen) > 1:
        flags = " and ".join(f"--{name}" for name in chosen)
        raise click.UsageError(f"{flags} exclude one another; give one of them")
    file = load_vessel(vessel)
    cores = options["cores"] or processor_count()
    result = file.path if options["write"] else options["output"]
    if options["check"]:
        reduction_report = reduction.report_reduction(file, reduction.as_filed(file), (), ())
    else:
        with show_progress(reduction.flight_count(file), "putting to zero") as step:
            drops = reduction.effect_table(file, cores, lambda: step(1))
        if options["table"]:
            lines = page.sensitivity(drops)
            json_lines = json_of([asdict(one) for one in drops])
            click.echo(json_lines if options["as_json"] else "\n".join(lines))
            return
        reduction_report = _search_reduction(file, cores, result, drops, quick=options["quick"])
    click.echo(
        json_of(asdict(reduction_report)) if options["as_json"] else page.render(reduction_report)
    )
    sys.exit(0 if reduction_report.passed else 1)


def _search_reduction(
    file: Any, cores: int, result: Path | None, drops: Any, *, quick: bool
) -> Any:
    """Return the reduction that a search finds, written to ``result`` if there is one."""
    from trainer.analysis.reduce import page, reduction
    from trainer.analysis.reduce.objective import compact_terms
    from trainer.config.files import renew_file, write_over

    partial = reduction.checkpoint_of(result) if result else None
    length = reduction.MAX_SEARCHES * len(compact_terms(file, "modified"))
    with show_progress(length, "dropping terms") as step:
        reduced = reduction.search(file, cores, partial, step, quick=quick)
    report = reduction.report_reduction(file, reduced.factors["modified"], reduced.needs, drops)
    if result is None:
        return report
    notes = {"kept": len(report.kept), "of": report.hull_terms}
    tables = page.factor_tables(reduced.factors, reduced.needs, notes)
    write = renew_file if result == file.path else write_over
    write(result, page.rewrite_vessel(file.text, tables))
    reduction.discard_checkpoint(reduction.checkpoint_of(result))
    return report
