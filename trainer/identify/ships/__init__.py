"""Ships that are not linear, identified by the extended Kalman filter.

Begin with ``fit``, the start, the search and the deviations, by the ``likelihood`` with what books
say; these two stay here. ``records`` read trials, ``results`` and ``page`` report a fit,
``published`` lays other figures beside it, ``vehicle`` sails the ship, ``trials`` plans new
records.
"""

# The modules that other rooms may use.
__all__ = ["page", "proposal", "published", "records", "results", "trials", "vehicle"]
