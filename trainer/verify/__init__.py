"""Proofs and measurements of the trainer itself."""
