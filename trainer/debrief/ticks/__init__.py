"""Marks counted tick by tick, while a run is flown.

Begin with ``judge``, which takes ticks into account as ``marks/tallies`` does; ``ground`` and
``ships`` are what is near.
"""

# The modules that other rooms may use.
__all__ = ["judge"]
