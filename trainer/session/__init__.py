"""The real-time executive: a run from its plan to its summary.

Begin with ``session``, the loop of ticks; then ``dispatch``, the road of an order, and ``jump``,
the road of a jump in time: each begins with a page on how it works. ``plan`` decides all settings
before the start, ``run`` makes the parts and joins them, ``parts`` names them. What happened is
kept by ``journal`` and ``history``, and a recorded run is flown again by ``replay``.

``time`` keeps the deadlines, ``stations`` says who may see and order what, ``nmea`` and ``rerun``
lead to instruments and to a viewer. Other rooms plan a run, start it, read its ``header`` and
``layout``, or drive a session by hand. Who obeys an order (``control``, the parts of ``conduct``,
``questions``, ...) and what is told (``event_log``, ``status``, ``evaluation``) stays here.
"""

# The modules that other rooms may use.
# fmt: off
__all__ = [
    "agenda", "aside", "attach", "crew", "exercise", "header", "history", "journal", "jump",
    "layout", "manning", "marks", "nmea", "options", "parts", "plan", "replay", "rerun", "resume",
    "run", "second_boat", "session", "stations", "time", "warm_up",
]
# fmt: on
