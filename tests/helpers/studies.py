"""Texts of identification studies, and what the command makes of them."""

import json
from typing import Any

from click.testing import Result

from helpers.typed import type_command
from trainer.cli.workshop.identify import identify


def columns(**named: str) -> str:
    """Return the tables of columns, each channel's column and unit in a word each."""
    parts = ((channel, *said.rsplit(" ", 1)) for channel, said in named.items())
    return "".join(
        f'[[columns]]\nchannel = "{channel}"\ncolumn = "{column}"\nunit = "{unit}"\n\n'
        for channel, column, unit in parts
    )


def answered(*arguments: object, code: int = 0) -> Result:
    """Return what `trainer identify` with these words did; it must end with that exit code."""
    return type_command(identify, *arguments, code=code)


def identified(*arguments: object) -> Any:
    """Return the report of the command."""
    return json.loads(answered(*arguments, "--json").stdout)


def numbers(report: Any) -> Any:
    """Return value and deviation of each parameter."""
    return {one["name"]: (one["value"], one["deviation"]) for one in report["parameters"]}
