"""Studies of many runs that differ in known ways.

Begin with ``study``, what a file asks for (its keys in ``records``), and ``draws``, the numbers of
each member. ``job`` has what every process needs to fly members; ``manoeuvres`` and ``exercises``
are two kinds of them, others lie with those who fly them. ``sweep`` carries it out, ``report`` is
what comes of it. ``fleets`` in memory stay here.
"""

# The modules that other rooms may use.
# fmt: off
__all__ = [
    "draws", "exercises", "job", "manoeuvres", "records", "report", "study", "sweep",
]
# fmt: on
