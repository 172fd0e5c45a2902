"""NMEA 0183: sentences to instruments, and orders from controllers.

Begin with ``page``, which lists all sentences, or ``outlets``, which opens what the command line
asks for. ``sentences`` makes those of one tick from ``readings``; ``transponders`` are the ships
near, ``orders`` what a controller sends. Only ``outlets`` and ``page`` are used from outside.
"""

# The modules that other rooms may use.
__all__ = ["outlets", "page"]
