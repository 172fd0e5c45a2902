"""Deadlines, and what became of them."""
