"""The first sentence of each command's help, which lists show without importing the command.

python -m helpers.help_lines > ../trainer/cli/help-lines.txt        in tests/
"""

from collections.abc import Iterator

import click

from trainer.cli.main import cli
from trainer.cli.types import Commands


def rows(group: Commands) -> Iterator[str]:
    """Yield the place of each command below a group, and what it says of itself first."""
    for name, command in group.commands.items():
        if place := group.found.places[name]:
            yield f"{place} {command.get_short_help_str(200)}\n"
        if isinstance(command, Commands):
            yield from rows(command)


def text() -> str:
    """Return trainer/cli/help-lines.txt."""
    return "".join(dict.fromkeys(rows(cli)))


if __name__ == "__main__":
    click.echo(text(), nl=False)
