"""Whether a screen can be shown, asked before what draws it is loaded."""

import os
import sys


def has_terminal() -> bool:
    """Return whether there is somebody to show a screen to; a closed stream is nobody."""
    streams = (sys.stdin, sys.stdout)
    return os.name == "posix" and all(stream and stream.isatty() for stream in streams)
