"""Commands that examine a vessel file."""

import sys

import click

from trainer.commands.options import method_options


@click.command()
@click.argument("vessel")
@method_options
def evaluate(vessel: str, equations: str, rates: str | None, trig: str) -> None:
    """Accelerations for states read as JSON lines: the check interface.

    \b
    Example:  trainer evaluate bb2 --equations full --rates exact < states.jsonl

    Each line of input is an object with u v w p q r phi theta psi delta_r delta_s delta_b u_c
    (SI, rad), optionally x_g y_g z_g weight and last_udot ... last_rdot; each line of output
    the twelve rates.
    """
    from trainer.files.vessel_file import load_vessel  # noqa: PLC0415
    from trainer.study.evaluate import evaluate as rates_of  # noqa: PLC0415

    file = load_vessel(vessel)
    for line in rates_of(file, equations, rates or "exact", trig, sys.stdin or ()):
        click.echo(line)


@click.command()
@click.argument("vessel")
@click.option("--json", "as_json", is_flag=True, help="Print the figures as JSON.")
def check(vessel: str, *, as_json: bool) -> None:
    """Say what a vessel file lacks, how the boat behaves, and which step is stable.

    \b
    Example:  trainer check bb2

    Exit code 1 when a step of 0.5 s or 1 s makes a boat unstable that is stable by nature.
    """
    import json  # noqa: PLC0415
    from dataclasses import asdict  # noqa: PLC0415

    from trainer.files.vessel_file import load_vessel  # noqa: PLC0415
    from trainer.study.check import check as examine  # noqa: PLC0415
    from trainer.study.check_page import render  # noqa: PLC0415

    report = examine(load_vessel(vessel))
    click.echo(json.dumps(asdict(report), indent=1) if as_json else render(report))
    sys.exit(0 if report.stable else 1)


@click.command()
@click.argument("vessel")
def gains(vessel: str) -> None:
    """Design the autopilot of a boat and print the table for its vessel file.

    \b
    Example:  trainer gains my-boat.toml >> my-boat.toml
    """
    from trainer.files.vessel_file import load_vessel  # noqa: PLC0415
    from trainer.study.gains import design_text  # noqa: PLC0415

    click.echo(design_text(load_vessel(vessel)))
