"""The search for a compact set of coefficients."""
