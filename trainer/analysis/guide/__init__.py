"""The automatic test guide of a vessel file."""
