"""Waves, their forces, and the free surface."""
