"""The Python face: what ``import trainer`` offers.

``boat`` is a session run by calls; ``by_number`` orders it by numbers, ``fleet`` orders many,
``exercise_fleet`` many in an exercise.
``calls`` has manoeuvres, sweeps and fits; ``programs`` carries them out, for a call as for the
command, and ``subjects`` tells a study's kind. What a call is given is read by ``config.keywords``.
"""

# The modules that other rooms may use.
__all__ = ["boat", "by_number", "calls", "exercise_fleet", "fleet", "programs", "subjects"]
