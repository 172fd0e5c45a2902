"""The same computations in plain C, to be compared with."""
