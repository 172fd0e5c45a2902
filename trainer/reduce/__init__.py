"""The reduction of the full set to a compact one as a computation."""
