"""The worth of a fit: residuals, uncertainty, other models and other records.

Begin with ``fitted``: a study carried out, and what is known afterwards. ``residuals``,
``uncertainty`` and ``validation`` question one fit; ``rivals``, ``orders`` and ``allowed`` lay
other models beside it; ``design`` asks before a trial what its record would be worth.
``propagation`` stays here.
"""

# The modules that other rooms may use.
# fmt: off
__all__ = [
    "allowed", "design", "fitted", "orders", "residuals", "rivals", "uncertainty", "validation",
]
# fmt: on
