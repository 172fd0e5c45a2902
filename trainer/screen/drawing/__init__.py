"""Drawings: functions from what is known of the session to lines in inks."""
