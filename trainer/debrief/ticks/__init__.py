"""Marks counted tick by tick, while a run is flown.

Begin with ``judge``. A ``tally_sheet`` says what ``tallies`` count for an exercise; ``ground`` and
``ships`` are what is near.
"""

# The modules that other rooms may use.
__all__ = ["judge", "tally_sheet"]
