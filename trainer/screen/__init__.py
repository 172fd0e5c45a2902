"""The instructor's console and the stations' panels: clients of a session's line, nothing else."""
