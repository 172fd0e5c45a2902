"""A boat from the drawing of its hull: coefficients, and how far each may be trusted."""
