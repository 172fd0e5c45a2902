"""Manoeuvres, and what is measured in them.

Begin with ``vehicle``, what a manoeuvre needs of whatever sails it, and ``flight``, which flies
one. Two kinds of vehicle stand here, ``submarine`` and ``nomoto_ship``; manoeuvres know neither.
They are found by name in ``catalogue``, and lie in a module a kind: ``turns``, ``zigzag``,
``vertical``, ... ``page`` is the command's report.
"""

# The modules that other rooms may use.
# fmt: off
__all__ = [
    "casualties", "catalogue", "flight", "nomoto_ship", "page", "seakeeping", "speeds", "submarine",
    "turns", "vehicle", "vertical", "zigzag",
]
# fmt: on
