"""The engineer's programs: 1969's, manoeuvres, the guide, reduction, sweeps.

Makers of boats: ``estimate`` from the drawing of a hull, ``gains``, ``reduce``. Flyers:
``manoeuvres``, ``sweep``, ``fleet``. Judges: ``guide``, ``check``, ``check_cases``. ``programs``
are those of 1969, ``plant_page`` says what feeds what, ``bench`` measures this machine.

Begin with ``manoeuvres``: most others fly them. A program and its page are what commands use; a
``fleet`` of boats side by side stays here. The trainer runs without this room.
"""

# The modules that other rooms may use.
# fmt: off
__all__ = [
    "bench", "check", "check_cases", "check_page", "estimate", "gains", "guide", "learning",
    "manoeuvres", "plant_page", "programs", "reduce", "seaway", "sweep",
]
# fmt: on
