"""The run in Rerun's viewer or file: the boat, its sea, charts, states and log.

Rerun (rerun.io) is a library and a viewer of its own for scenes and numbers over time. Only ``sdk``
imports it. Modules that need ``sdk`` are imported when a user asks for Rerun.
"""
