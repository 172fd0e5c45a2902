"""The run in Rerun's viewer or file: the boat, its sea, charts, states and log.

``sdk`` imports rerun; what imports it is itself imported when somebody asks for it.
"""
