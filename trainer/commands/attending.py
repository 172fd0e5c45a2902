"""Commands that attach to a running session."""

import sys

import click

from trainer.commands.options import connect_options, teletype_option

ROLES = (
    "instructor",
    "helm",
    "planes",
    "ballast",
    "diving",
    "observer",
)  # see stations.roles


@click.command()
@connect_options
@teletype_option
def attach(url: str | None, token: str | None, *, teletype: bool) -> None:
    """Attach to a session as its instructor.

    \b
    Example:  trainer attach
              trainer attach --connect tcp://bridge:17800 --token WORD
              printf 'casualty stern-stuck\\n' | trainer attach

    On a terminal it shows the instructor's console, F1 its help. `detach` leaves the session
    running, `quit` ends it.
    """
    sys.exit(be(url, "instructor", token, teletype=teletype))


@click.command()
@click.argument("role", type=click.Choice(ROLES))
@connect_options
@teletype_option
def station(role: str, url: str | None, token: str | None, *, teletype: bool) -> None:
    """Attach to a session as one of its crew: own instruments, own controls.

    \b
    Example:  trainer station helm
              trainer station ballast --connect tcp://192.168.1.10:17800 --token WORD

    On a terminal it shows the panel of that role; its keys move the controls, F1 lists them.
    """
    sys.exit(be(url, role, token, teletype=teletype))


def be(url: str | None, role: str, token: str | None, *, teletype: bool) -> int:
    """Be a station of that role, on a screen or as a teletype; return the exit code."""
    from trainer.screen.terminal import has_terminal  # noqa: PLC0415

    if has_terminal() and not teletype:
        from trainer.screen.launch import attend  # noqa: PLC0415

        return attend(url, role, token)
    from trainer.attach import attach_to  # noqa: PLC0415

    return attach_to(url, role, token)
