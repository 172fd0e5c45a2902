"""Marks of a run, from what was sailed.

Begin with ``judgement``, a run judged by the rules of its exercise. ``measures`` and ``gates`` give
``scoring`` its numbers; ``forms`` and ``changes`` are what assessors add. ``rehearsal`` flies an
exercise without a session, ``reference`` what a mark is compared with.
"""

# The modules that other rooms may use.
# fmt: off
__all__ = [
    "changes", "forms", "gates", "judgement", "measures", "reference", "rehearsal", "scoring",
    "station_marks",
]
# fmt: on
