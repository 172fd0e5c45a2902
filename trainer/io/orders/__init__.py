"""Orders as lines of words: their table, their grammar, their help, their files.

Begin with ``table``: every word, number and unit stands there once. ``grammar`` reads a line by it,
``help`` explains it, and pages, completion and documents follow from it. ``sentences`` are the
lines of programs, with a checksum; ``schedule`` has orders with their times.

``phrases``, how a control room says an order, are read by the grammar alone.
"""

# The modules that other rooms may use.
__all__ = ["grammar", "help", "quantities", "schedule", "sentences", "table"]
