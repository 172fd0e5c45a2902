"""Manoeuvres: schedules of controls flown by any vehicle, and what they are measured by."""
