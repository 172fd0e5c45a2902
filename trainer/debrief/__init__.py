"""A recording is judged as an exercise: measures, marks, a page."""
