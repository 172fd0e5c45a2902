"""What a recording tells of an exercise: measures, marks, a page."""
