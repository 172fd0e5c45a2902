"""The worth of a fit: residuals, uncertainty, other models and other records.

Begin with ``fitted``: a study carried out, and what is known afterwards. ``residuals``,
``uncertainty`` and ``validation`` question one fit; ``validation`` and ``allowed`` lay other models
beside it.
"""

# The modules that other rooms may use.
__all__ = ["allowed", "fitted", "residuals", "uncertainty", "validation"]
