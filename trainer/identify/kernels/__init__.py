"""The fast part of identification: sampling, filters, their gradients. Numbers only.

Begin with ``covariance_filter``, the filter over a whole record; ``sensitivity`` has its likelihood
and the slopes of it, all or none. ``sampling`` makes steps of continuous
systems, ``ship_models`` their matrices. ``extended_filter`` is for ships that are not linear; its
slopes (``extended_slopes``) stay here. ``kernel`` has the options of the compiler.
"""

# The modules that other rooms may use.
# fmt: off
__all__ = [
    "covariance_filter", "extended_filter", "kernel", "nonlinear_steering", "sampling",
    "sensitivity", "ship_models",
]
# fmt: on
