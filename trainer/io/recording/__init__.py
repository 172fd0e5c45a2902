"""The recording: its file, what is written to it, what it tells of the past."""
