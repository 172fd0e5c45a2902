"""The compiled boat as a library for other programs."""
