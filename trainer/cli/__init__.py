"""The command line.

Begin with ``main``, the group of commands: it knows each by its place, and imports it when it is
typed. A module holds one command or a few; ``options`` and ``types`` are what several share.
Commands here are the trainer's, those in ``workshop`` the engineer's and of identification.

The package itself uses this room, by ``main``.
"""

# The modules that other rooms may use.
__all__ = ["main"]
