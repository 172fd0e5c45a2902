"""What could still be earned at each moment of a run, and what cost it.

Begin with ``continuations``, which says what a crew could do from a moment on, and ``search``,
which flies it. ``explorer`` does so from the moments of a recorded run, ``curve`` from all of them;
``causes`` proves what made the marks fall, ``words`` says it.
"""

# The modules that other rooms may use.
__all__ = ["changes", "continuations", "curve", "explorer", "search", "words"]
