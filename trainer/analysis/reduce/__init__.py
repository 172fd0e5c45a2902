"""The search for a compact set of coefficients.

Begin with ``search``, which drops one term after another, by the ``objective``: how far a
candidate's flights lie from the full set's. Commands use ``reduction``, which is a search or a
filed set with its verdict, and write it by ``page``. ``programme``, the flights, stays
here with the search.
"""

# The modules that other rooms may use.
__all__ = ["objective", "page", "reduction"]
