"""The run in Rerun's viewer or file: the boat, its sea, charts, states and log.

Rerun (rerun.io) is a library and a viewer of its own for scenes and numbers over time. Begin with
``request``, which opens what a user asks for, and ``batch``, which gathers a run for it; these two
are used from outside. Only ``sdk`` imports the library. Modules that need ``sdk`` are imported when
a user asks for Rerun.
"""

# The modules that other rooms may use.
__all__ = ["batch", "request"]
