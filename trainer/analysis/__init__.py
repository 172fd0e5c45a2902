"""The engineer's programs: 1969's, manoeuvres, the guide, reduction, sweeps.

Makers of boats: ``estimate`` from the drawing of a hull, ``gains``, ``reduce``. Flyers:
``manoeuvres``, ``sweep``, ``fleet``. Judges: ``guide``, ``check``, ``check_cases``, ``validation``
(do an exercise's marks order skill?). ``programs`` are those of 1969, ``bench`` measures this
machine.

Begin with ``manoeuvres``: most others fly them. A program and its page are what commands use; a
``fleet`` of boats side by side, crews for validation (``trainees``, ``lateness``) and what an
exercise's texts say (``stated``) stay here. ``workers`` are the processes that all fly in.
"""

# The modules that other rooms may use.
# fmt: off
__all__ = [
    "bench", "boat_page", "check", "check_cases", "check_page", "estimate", "exercise_page",
    "gains", "guide", "manoeuvres", "programs", "recording_export", "reduce", "seaway",
    "series", "sweep", "validation", "workers",
]
# fmt: on
