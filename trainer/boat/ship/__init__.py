"""A ship that is not a submarine: its equations, as its file has them.

Begin with ``models``, the four models with their coefficients; ``forces`` computes accelerations by
them, ``motion`` integrates them. ``forward_numbers`` carry derivatives through the same equations,
for identification, which uses all four modules.
"""

# The modules that other rooms may use.
__all__ = ["forces", "forward_numbers", "models", "motion"]
