"""The drawings of a screen, as text."""
