"""Proofs that anybody can run: long exercises, faults on purpose, inputs made to break it."""
