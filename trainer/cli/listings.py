"""Commands that list what is shipped and what is sent to instruments."""

from pathlib import Path

import click

from trainer.cli.shared_options import FILE
from trainer.cli.types import Commands


@click.command()
@click.option("--json", "as_json", is_flag=True, help="Print the list as JSON.")
def exercises(*, as_json: bool) -> None:
    """List the shipped exercises, in the order of the course.

    \b
    Example:  trainer exercises
    """
    import json  # noqa: PLC0415

    from trainer.config.course import course  # noqa: PLC0415

    found = {lesson.name: lesson.title for lesson in course()}
    lines = [f"{name:24}{title}" for name, title in found.items()]
    click.echo(json.dumps(found, indent=1) if as_json else "\n".join(lines))


@click.group(cls=Commands)
def exercise() -> None:
    """Make an exercise of your own: a file to begin with, and its check."""


@exercise.command()
@click.argument("file", type=FILE)
@click.option("--name", default=None, help="One line for the list.")
@click.option("--from", "source", default=None, metavar="EXERCISE", help="Copy a shipped one.")
def new(file: Path, name: str | None, source: str | None) -> None:
    """Write a valid exercise with comments, to be changed; never over another file.

    \b
    Example:  trainer exercise new drill.toml --name "Lost in the fog"
              trainer exercise new drill.toml --from stern-plane-jam
    """
    from trainer.analysis.exercise_page import write_new  # noqa: PLC0415

    write_new(file, name, source)


@exercise.command()
@click.argument("file")
def check(file: str) -> None:
    """Say what is wrong with an exercise, or else what it is.

    \b
    Example:  trainer exercise check drill.toml

    FILE is a path, or the name of a shipped exercise. It is flown with nobody aboard and with its
    reference crew. Exit code 2 when something is wrong, each mistake with its line.
    """
    from trainer.analysis import exercise_page  # noqa: PLC0415

    click.echo("\n".join(exercise_page.check(file)))


@exercise.command()
@click.argument("file")
@click.option("--seeds", type=click.IntRange(1, 1000), default=20, show_default=True)
def baseline(file: str, seeds: int) -> None:
    """Fly an exercise with nobody aboard and with its reference crew; keep their marks beside it.

    \b
    Example:  trainer exercise baseline depth-changes
              trainer exercise baseline drill.toml --seeds 5

    FILE is a path, or the name of a shipped exercise. The debrief takes from each task what it
    gives with nobody aboard. What is kept is drill.baseline.toml, beside drill.toml.
    """
    from trainer.analysis import baseline as baseline_module  # noqa: PLC0415

    found = baseline_module.study(file, seeds)
    click.echo("\n".join(baseline_module.table(found)))
    click.echo(f"kept in {baseline_module.keep(found)}")


@click.command()
@click.argument("tables", nargs=-1, metavar="[FILE]...")
@click.option("--json", "as_json", is_flag=True, help="Print the list as JSON.")
def casualties(tables: tuple[str, ...], *, as_json: bool) -> None:
    """List what can break, from the shipped table and from files of your own.

    \b
    Example:  trainer casualties
    """
    import json  # noqa: PLC0415

    from trainer.config import casualties as casualties_module  # noqa: PLC0415

    found = casualties_module.load_casualties(*tables)
    listing = casualties_module.listing(found)
    click.echo(json.dumps(casualties_module.as_json(found), indent=1) if as_json else listing)


@click.command()
@click.option("--sample", is_flag=True, help="Print one set, of the bb2 in trim.")
@click.option("--json", "as_json", is_flag=True, help="Print it as JSON.")
def instruments(*, sample: bool, as_json: bool) -> None:
    """List the NMEA 0183 sentences sent by `--nmea`: their fields, units and sources.

    \b
    Example:  trainer instruments --sample
              trainer run --nmea udp://127.0.0.1:10110
              trainer serve --nmea /dev/ttyUSB0 --nmea-baud 4800 --nmea-sentences HDT,DPT,ROT
    """
    import json  # noqa: PLC0415

    from trainer.config.vessel import load_vessel  # noqa: PLC0415
    from trainer.session.nmea import page as nmea_page  # noqa: PLC0415

    if sample:
        lines = nmea_page.sample(load_vessel("bb2"))
        click.echo(json.dumps(lines, indent=1) if as_json else "\n".join(lines))
        return
    click.echo(json.dumps(nmea_page.as_json(), indent=1) if as_json else nmea_page.page())
