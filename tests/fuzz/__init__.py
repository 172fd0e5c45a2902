"""Inputs made to break the readers."""
