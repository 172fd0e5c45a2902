"""The Python face: what ``import trainer`` offers.

``boat`` is a session run by calls; ``by_number`` orders it by numbers, ``fleet`` orders many,
``exercise_fleet`` many in an exercise.
``calls`` has manoeuvres, sweeps and fits, ``keywords`` reads what a call is given as the command's
options of the same names, so that both accept and say the same. Only the package itself uses this
room.
"""

# The modules that other rooms may use.
__all__ = ["boat", "by_number", "calls", "exercise_fleet", "fleet"]
