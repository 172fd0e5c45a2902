"""Whether this terminal can show a screen, tested before the screen's library is loaded.

``run`` asks, and takes plain lines where it cannot. Loading Textual takes a noticeable time, which
a run without a screen need not spend.
"""

import os
import sys
from collections.abc import Mapping
from typing import Final

DUMB_TERMINALS: Final = ("dumb", "unknown")
# by it a console gives the session beside it an address and a token
OWN_SESSION_VARIABLE: Final = "TRAINER_OWN_SESSION"
ASCII_ONLY: Final = ("C", "POSIX")  # the locales that promise no more


def has_terminal() -> bool:
    """Return whether all standard streams are a terminal. A closed stream is none.

    The screen is drawn on stderr: sent elsewhere, it would leave the terminal blank.
    """
    streams = (sys.stdin, sys.stdout, sys.stderr)
    if not all(stream and stream.isatty() for stream in streams):
        return False
    return draws(os.environ, sys.stdout.encoding or "")


def draws(environment: Mapping[str, str], encoding: str) -> bool:
    """Return whether a terminal moves its cursor and has more than ASCII. Else lines are plain.

    LC_ALL is looked at apart, because Python writes UTF-8 even where it asks for plain C.
    """
    if environment.get("TERM", "") in DUMB_TERMINALS:
        return False
    locale = environment.get("LC_ALL") or environment.get("LC_CTYPE") or ""
    return locale not in ASCII_ONLY and encoding.lower().replace("-", "").startswith("utf")


def asked_beside() -> tuple[str, str]:
    """Return address and token of a console beside this session, else "" and ""."""
    address, _, word = os.environ.get(OWN_SESSION_VARIABLE, "").partition(" ")
    return address, word
