"""Acceptance cases of identification: ships whose numbers are known."""
