"""The run in Rerun's viewer, or in a file for it: the boat in its sea, charts, lanes and the log.

``sdk`` imports rerun; what imports it is itself imported when somebody asks for it.
"""
