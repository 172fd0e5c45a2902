"""Commands that list what is shipped."""

from pathlib import Path
from typing import Any

import click

from trainer.arguments import Commands
from trainer.commands.options import FILE


@click.command()
@click.option("--json", "as_json", is_flag=True, help="Print the list as JSON.")
def exercises(*, as_json: bool) -> None:
    """List the shipped exercises.

    \b
    Example:  trainer exercises
    """
    import json  # noqa: PLC0415

    from trainer.config import shipped_names  # noqa: PLC0415
    from trainer.files.exercise_file import load_exercise  # noqa: PLC0415

    found = {name: load_exercise(name).heading.name for name in shipped_names("exercises")}
    lines = [f"{name:24}{title}" for name, title in found.items()]
    click.echo(json.dumps(found, indent=1) if as_json else "\n".join(lines))


@click.group(cls=Commands)
def exercise() -> None:
    """Make an exercise of your own: a file to begin with, and its check."""


@exercise.command()
@click.argument("file", type=FILE)
@click.option("--name", default=None, help="One line for the list.")
def new(file: Path, name: str | None) -> None:
    """Write a valid exercise with comments, to be changed; never over another file.

    \b
    Example:  trainer exercise new drill.toml --name "Lost in the fog"
    """
    from trainer.exercise_page import write_new  # noqa: PLC0415

    write_new(file, name)


@exercise.command()
@click.argument("file")
def check(file: str) -> None:
    """Say what is wrong with an exercise, or else what it is.

    \b
    Example:  trainer exercise check drill.toml

    FILE is a path, or the name of a shipped exercise. Exit code 2 when something is wrong.
    """
    from trainer.commands.running import run  # noqa: PLC0415
    from trainer.exercise_page import summary  # noqa: PLC0415
    from trainer.plan import plan_run  # noqa: PLC0415

    options: dict[str, Any] = {each.name or "": each.default for each in run.params}
    click.echo("\n".join(summary(plan_run({**options, "exercise": file, "given": frozenset()}))))


@click.command()
@click.argument("tables", nargs=-1, metavar="[FILE]...")
@click.option("--json", "as_json", is_flag=True, help="Print the list as JSON.")
def casualties(tables: tuple[str, ...], *, as_json: bool) -> None:
    """List what can break, from the shipped table and from files of your own.

    \b
    Example:  trainer casualties
    """
    import json  # noqa: PLC0415

    from trainer.files import casualty_file  # noqa: PLC0415

    found = casualty_file.load_casualties(*tables)
    listing = casualty_file.listing(found)
    click.echo(json.dumps(casualty_file.as_json(found), indent=1) if as_json else listing)
