"""The boat as numbers: numba kernels, no I/O, no clock, no Python objects.

Conventions of every module here. SI and radians. Body axes x forward, y starboard, z to the keel,
origin at the reference point of the coefficients; earth axes x north, y east, z down. ``psi`` is
positive to starboard, ``theta`` bow up, ``phi`` starboard side down. Plane signs are carried by
the coefficients. Symbols are those of [GH67] with the prime dropped.

Sources: [GH67] Gertler & Hagen, NSRDC Report 2510 (1967); [ASSES] Groves, Dorsey & Tucker,
NAVTRADEVCEN 68-C-0050-1 (1969), whose equation numbers (1)-(18) and program names are cited.
"""

# The modules that a program of one's own begins with: records, a start in trim, and the tick.
__all__ = ["kernel", "scheme", "start", "state", "terms", "update", "vessel"]
