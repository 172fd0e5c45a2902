"""The options of a run, made from what click has read."""

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import click
from click.core import ParameterSource

from trainer.session.options import RunOptions


def run_options(options: Mapping[str, Any]) -> RunOptions:
    """Return the options of the command under way, and which of them were given."""
    return RunOptions(**options, given=options_given())


def options_given() -> frozenset[str]:
    """Return the names of the options given to the command under way."""
    context = click.get_current_context()
    source = context.get_parameter_source
    return frozenset(name for name in context.params if source(name) is not ParameterSource.DEFAULT)


def without_console(options: RunOptions) -> RunOptions:
    """Return the options for a session without a console of its own."""
    return replace(options, headless=True, url=None, serve=True)
