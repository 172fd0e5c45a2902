"""What a run was planned to be, and what has happened in it.

``plan`` decides all settings of a run before it starts, from its ``options``; ``control`` moves its
time. ``journal`` and ``history`` keep what happens, by the ``layout`` of the state; ``header`` says
what a recording is of, and ``run_modes`` what is flown: a run, a replay, or the way shown.
"""

# The modules that other rooms may use.
__all__ = ["control", "header", "history", "journal", "layout", "options", "plan", "run_modes"]
