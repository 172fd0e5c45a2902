"""The recording of a run: its file, how it is written, how it is queried.

One SQLite file holds orders, states and events, with the branches that jumps in time begin. Begin
with ``recording``, which is the face: it hands out the records of the past and the errors too.
``facts`` are what programs decide on, ``absence`` is what stands in where nothing is recorded.

The rest stays here: the ``file``, its ``queries``, the threads of ``checkpoint`` and
``durability``, and ``format_1``, which told in words what later files hold as facts.
"""

# The modules that other rooms may use.
__all__ = ["absence", "facts", "recording"]
