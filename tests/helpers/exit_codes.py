"""docs/exit-codes.md, made of the help of every command.

python -m helpers.exit_codes > ../docs/exit-codes.md
"""

import inspect
import re
from collections.abc import Iterator
from typing import Final

import click

from trainer.cli.main import cli

HEAD: Final = """\
# Exit codes

<!-- Made by tests/helpers/exit_codes.py of the help of the commands; a test compares them. -->

After this page a script can tell what became of a command. `trainer COMMAND --help` says the same.

| code | of every command |
|---|---|
| 0 | done |
| 1 | done, but the answer is no; the table below says what that means. Or the program failed |
| 2 | wrong input: one line on stderr names the file or option, the value and what would be right |
| 130 | interrupted by Ctrl-C |

| command | its own codes |
|---|---|
"""
SENTENCE: Final = re.compile(r"Exit codes?:? (.*?\.)(?:\s|$)")


def commands(group: click.Group, path: str = "trainer") -> Iterator[tuple[str, click.Command]]:
    """Yield every command that does something, by what is typed for it."""
    for name, command in group.commands.items():
        typed = f"{path} {name}"
        if isinstance(command, click.Group):
            yield from commands(command, typed)
        else:
            yield typed, command


def told(command: click.Command) -> str:
    """Return what the help of a command says of its exit codes; "" if nothing."""
    text = " ".join(inspect.cleandoc(command.help or "").split())
    return " ".join(SENTENCE.findall(text))


def page() -> str:
    """Return docs/exit-codes.md."""
    by_command = {command: typed for typed, command in reversed([*commands(cli)])}
    rows = [f"| `{typed}` | {told(command)} |\n" for command, typed in reversed(by_command.items())]
    return HEAD + "".join(row for row in rows if not row.endswith("|  |\n"))


if __name__ == "__main__":
    print(page(), end="")
