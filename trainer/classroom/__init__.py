"""A class: one instructor, many boats.

A boat of a class is a session like any other: a process of its own, with its own recording, socket
and laws. ``fleet`` begins these processes and brings back one that dies. ``launch`` begins a whole
class, for the command line. Nothing here orders, records or judges: sessions do.
"""

# The modules that other rooms may use.
__all__ = ["launch"]
