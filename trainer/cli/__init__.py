"""The command line.

Begin with ``main``, the group of commands; each imports what it needs when it runs. A module holds
one command or a few; ``options`` and ``types`` are what several share. The Python face lies here
too: ``boat`` is a session run by calls, ``calls`` has manoeuvres, sweeps and fits.

Only the package itself uses this room, by ``main``, ``boat`` and ``calls``.
"""

# The modules that other rooms may use.
__all__ = ["boat", "calls", "main"]
