"""Whoever attends to a session: one line, one role, and the state as each sees it."""
