"""Commands as they are typed, in the process of the test."""

import click
from click.testing import CliRunner, Result


def type_command(command: click.Command, *words: object, code: int = 0) -> Result:
    """Return what a command with these words did; it must end with that exit code."""
    result = CliRunner().invoke(command, [str(word) for word in words])
    if result.exception and not isinstance(result.exception, SystemExit):
        raise result.exception
    assert result.exit_code == code, result.output[:500]
    return result
