"""Texts of identification studies, and what the command makes of them."""

import json
from typing import Any

from click.testing import CliRunner

from trainer.cli.identify import identify


def columns(**named: str) -> str:
    """Return the tables of columns, each channel's column and unit in a word each."""
    parts = ((channel, *said.rsplit(" ", 1)) for channel, said in named.items())
    return "".join(
        f'[[columns]]\nchannel = "{channel}"\ncolumn = "{column}"\nunit = "{unit}"\n\n'
        for channel, column, unit in parts
    )


def identified(*arguments: Any) -> Any:
    """Return the report of the command."""
    result = CliRunner().invoke(identify, [*map(str, arguments), "--json"])
    if result.exception and not isinstance(result.exception, SystemExit):
        raise result.exception
    assert result.exit_code == 0, result.output[:500]
    return json.loads(result.stdout)


def numbers(report: Any) -> Any:
    """Return value and deviation of each parameter."""
    return {one["name"]: (one["value"], one["deviation"]) for one in report["parameters"]}
