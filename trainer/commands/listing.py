"""Commands that list what is shipped."""

import click


@click.command()
@click.option("--json", "as_json", is_flag=True, help="Print the list as JSON.")
def exercises(*, as_json: bool) -> None:
    """List the shipped exercises.

    \b
    Example:  trainer exercises
    """
    import json  # noqa: PLC0415

    from trainer.config import shipped_names  # noqa: PLC0415
    from trainer.exercise_file import load_exercise  # noqa: PLC0415

    found = {name: load_exercise(name).heading.name for name in shipped_names("exercises")}
    lines = [f"{name:24}{title}" for name, title in found.items()]
    click.echo(json.dumps(found, indent=1) if as_json else "\n".join(lines))


@click.command()
@click.argument("tables", nargs=-1, metavar="[FILE]...")
@click.option("--json", "as_json", is_flag=True, help="Print the list as JSON.")
def casualties(tables: tuple[str, ...], *, as_json: bool) -> None:
    """List what can break, from the shipped table and from files of your own.

    \b
    Example:  trainer casualties
    """
    import json  # noqa: PLC0415

    from trainer import casualty_file  # noqa: PLC0415

    found = casualty_file.load_casualties(*tables)
    listing = casualty_file.listing(found)
    click.echo(json.dumps(casualty_file.as_json(found), indent=1) if as_json else listing)
