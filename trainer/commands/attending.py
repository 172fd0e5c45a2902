"""Commands that attach to a running session."""

import sys

import click

from trainer.commands.options import connect_options

ROLES = ("instructor", "helm", "planes", "ballast", "diving", "observer")  # as in trainer.roles


@click.command()
@connect_options
def attach(url: str | None, token: str | None) -> None:
    """Attach to a session as its instructor.

    \b
    Example:  trainer attach
              trainer attach --connect tcp://bridge:17800 --token WORD
              printf 'casualty stern-stuck\\n' | trainer attach

    `detach` or Ctrl-C leaves the session running, `quit` ends it.
    """
    from trainer.attach import attach_to  # noqa: PLC0415

    sys.exit(attach_to(url, "instructor", token))


@click.command()
@click.argument("role", type=click.Choice(ROLES))
@connect_options
def station(role: str, url: str | None, token: str | None) -> None:
    """Attach to a session as one of its crew: own instruments, own controls.

    \b
    Example:  trainer station helm
              trainer station ballast --connect tcp://192.168.1.10:17800 --token WORD
    """
    from trainer.attach import attach_to  # noqa: PLC0415

    sys.exit(attach_to(url, role, token))
