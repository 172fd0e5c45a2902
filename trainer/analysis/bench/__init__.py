"""The cost of the trainer on this machine.

Begin with ``sections``, the parts of ``trainer dev bench``: each is a module here, and asked for by
an option. ``bench`` has the cost of a boat's tick. Only these two are used from outside. Some
modules are started as processes, so that one measure does not warm the next.
"""

# The modules that other rooms may use.
__all__ = ["bench", "sections"]
