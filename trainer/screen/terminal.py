"""Whether a screen can be shown, asked before what draws it is loaded."""

import os
import sys


def has_terminal() -> bool:
    """Return whether there is somebody to show a screen to."""
    return os.name == "posix" and sys.stdin.isatty() and sys.stdout.isatty()
