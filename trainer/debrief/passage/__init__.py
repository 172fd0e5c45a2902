"""What was sailed, read from a recording to the end of a branch.

Begin with ``trajectory``. ``episodes``, ``groundings``, ``ships_met``, ``watches``, ``controls``
and ``crew_work`` are found in it; ``recording_export`` gives it as columns.
"""

# The modules that other rooms may use.
# fmt: off
__all__ = [
    "class_places", "controls", "crew_work", "episodes", "groundings", "recording_export",
    "ships_met", "trajectory", "watches",
]
# fmt: on
