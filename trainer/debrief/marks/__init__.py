"""Marks of a run, from what was sailed.

Begin with ``judgement``, a run judged by the rules of its exercise. These are rows of a
``tally_sheet``, by which ``tallies`` counts each tick; ``tallied_record`` has what each rule made
of a record, for ``scoring`` and ``gates``. ``forms`` and ``changes`` are what assessors add.
``rehearsal`` flies an exercise without a session, ``reference`` what a mark is compared with.
"""

# The modules that other rooms may use.
# fmt: off
__all__ = [
    "changes",
    "forms",
    "judgement",
    "mark_numbers",
    "measures",
    "reference",
    "rehearsal",
    "scoring",
    "station_marks",
    "tallies",
    "tally_sheet",
]
# fmt: on
