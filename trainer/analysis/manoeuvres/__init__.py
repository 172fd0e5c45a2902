"""Manoeuvres, and what is measured in them."""
