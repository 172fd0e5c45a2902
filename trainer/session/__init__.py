"""The real-time executive: a run from its plan to its summary.

Begin with ``session``, the loop of ticks; then ``dispatch``, the road of an order, and ``jump``,
the road of a jump in time: each begins with a page on how it works. ``run`` makes the parts and
joins them, ``parts`` names them, and a recorded run is flown again by ``replay``.

The rooms, each without a circle to another: ``past`` plans a run and keeps what happened, ``time``
keeps the deadlines, ``stations`` says who may see and order what, ``crew`` has the talk aboard,
``people`` sit at stations, ``exercise`` is conducted and marked, ``doors`` lead in. ``nmea`` and
``rerun`` lead to instruments and to a viewer. Other rooms plan a run, start it, read its header and
layout, or drive a session by hand.
"""

# The modules that other rooms may use.
# fmt: off
__all__ = [
    "aside", "crew", "doors", "exercise", "jump", "nmea", "parts", "past", "people", "ready",
    "replay", "rerun", "resume", "run", "session", "stations", "time",
]
# fmt: on
