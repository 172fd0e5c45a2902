"""The models of a steered ship, and systems of a user's own: matrices and sampling.

Begin with ``models``: the parameters' names, and matrices by them. ``own_systems`` and
``system_files`` are a user's; ``sampled`` makes any of them discrete. ``nomoto`` and ``derived``
say what parameters mean to a seaman. All modules are open.
"""

# The modules that other rooms may use.
__all__ = ["derived", "models", "nomoto", "own_systems", "sampled", "system_files"]
