"""Faults made on purpose, and what became of the orders."""
