"""What a careful crew could still earn, at each moment of a run.

Begin with ``explorer``, which flies the rest of a run from any moment, and ``curve``, all of them
with their changes. ``stretches``, ``falls`` and ``causes`` find what made the marks fall; ``words``
says it.
"""

# The modules that other rooms may use.
__all__ = ["changes", "curve", "explorer", "falls", "words"]
