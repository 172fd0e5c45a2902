"""Many boats flown side by side, each with the bits that it has alone.

Begin with ``ensemble``: a fleet in one call. ``lanes`` lay boats
side by side in one array, ``tick`` calls one boat's kernels for every lane, ``member`` flies one as
it would be alone. What one boat's kernels compute is ``shipped`` code, called by its address.
"""

# The modules that other rooms may use.
__all__ = ["ensemble", "shipped"]
