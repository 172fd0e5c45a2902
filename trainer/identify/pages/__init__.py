"""The findings of identification, for terminal, plot and browser.

A module a command: ``identify``, ``armax``, ``record``, ``experiment``, ``steering``, ``decca``.
Begin with ``results``, a study carried out as one record, from which text, JSON and HTML are
written. ``series`` and ``ship_files`` write a fit by samples, or as a file that sails. All modules
are open.
"""

# The modules that other rooms may use.
# fmt: off
__all__ = [
    "armax", "decca", "experiment", "identify", "record", "results", "series", "ship_files",
    "steering",
]
# fmt: on
