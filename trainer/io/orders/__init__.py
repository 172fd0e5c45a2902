"""Orders as lines of words: their table, their grammar, their help, their files.

Begin with ``table``: every wording, number and unit stands there once. ``words`` has what each
order is: who obeys it, who may give it, what it works. ``grammar`` reads a line by the one, and
rooms ask the other; ``help``, pages, completion and documents follow from both. ``sentences`` are
the lines of programs, with a checksum; ``schedule`` has orders with their times.

``phrases``, how a control room says an order, are read by the grammar alone.
"""

# The modules that other rooms may use.
__all__ = ["grammar", "help", "quantities", "schedule", "sentences", "table", "words"]
