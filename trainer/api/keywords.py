"""Keywords of the Python face, read as the options of the same command.

``trainer.manoeuvre(step_speed=5)`` and its like come here, so that a call and a command accept the
same and say the same. Each keyword is the name of an option, such as ``step_speed`` for
``--step-speed``. The command's own parser checks it: limits, choices, defaults and messages are
those of the command line.
"""

from collections.abc import Collection, Hashable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from typing import Any

import click

from trainer.config.files import ConfigError, nearest


@contextmanager
def parse_options(
    command: click.Command,
    arguments: Sequence[object],
    keywords: Mapping[str, Any],
    known: Collection[str],
) -> Iterator[dict[str, Any]]:
    """Yield a command's options inside the block, as if they had been typed.

    ``known`` are all keywords. One with None counts as not given. It is a block, because a command
    reads more from click's context. ConfigError with the command's own words if something is wrong.
    """
    for name in keywords:
        if name not in known:
            known_names = ", ".join(sorted(known))
            raise ConfigError(f"no keyword {name!r}{nearest(name, known)}; there are {known_names}")
    words = [word for name, value in keywords.items() for word in _words(command, name, value)]
    texts = [str(each) for each in arguments]
    try:
        # After "--" a path that begins with a dash is no option.
        with command.make_context(command.name, [*words, "--", *texts]) as context:
            yield dict(context.params)
    except click.UsageError as wrong:
        raise ConfigError(wrong.format_message()) from None


def _words(command: click.Command, name: str, value: object) -> list[str]:
    """Return the words typed for a keyword: none for None and for a flag not set."""
    options = [each for each in command.params if isinstance(each, click.Option)]
    named = [each for each in options if name in _names(each)]
    if not named or value is None:
        return []
    option = named[0]
    if option.is_flag:
        # Several flags may set one option, each to a value of its own.
        flags: dict[object, list[str]] = {each.flag_value: [each.opts[0]] for each in named}
        if named[0].is_bool_flag:
            flags = {False: [], True: [named[0].opts[0]]}
        if not isinstance(value, Hashable) or value not in flags:
            known = ", ".join(map(repr, flags))
            raise ConfigError(f"Invalid value for {name!r}: {value!r} is not one of {known}.")
        return flags[value]
    values = value if option.multiple and isinstance(value, list | tuple) else [value]
    whole = max(option.opts, key=len)  # of "-o" alone the sign of equality would be a value's
    return [f"{whole}={each}" for each in values]


def _names(option: click.Option) -> set[str]:
    """Return the keywords of an option: its name in Python, and the names typed."""
    typed = {each.lstrip("-").replace("-", "_") for each in option.opts}
    return {option.name or "", *typed}
