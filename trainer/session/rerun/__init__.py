"""The run in Rerun's viewer or file: the boat, its sea, charts, states and log.

Only ``sdk`` imports rerun. Modules that need ``sdk`` are imported when a user asks for Rerun.
"""
