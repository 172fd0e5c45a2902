"""The real-time executive: a run from its plan to its summary."""
