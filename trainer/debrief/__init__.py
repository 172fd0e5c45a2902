"""The debrief of a recorded run: one page of what was ordered, what came of it, and the marks."""
