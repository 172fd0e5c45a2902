"""The programs of 1969: a boat's numbers, and two runs of it compared."""
