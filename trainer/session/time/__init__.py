"""The deadlines of the ticks, and the ledger of how they were kept.

Begin with ``pacer``: when each tick is due, and what follows late ones. ``timekeeping`` is the
session's hold on it (speed, slips, what the system grants), ``ledger`` counts. All three are open.
"""

# The modules that other rooms may use.
__all__ = ["ledger", "pacer", "timekeeping"]
