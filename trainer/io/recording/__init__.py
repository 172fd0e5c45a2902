"""The recording of a run: its file, how it is written, how it is queried."""
