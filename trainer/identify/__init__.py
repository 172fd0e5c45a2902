"""Identification of steering dynamics: from a recording to coefficients, and back to sea."""
