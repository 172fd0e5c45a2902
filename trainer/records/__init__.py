"""Recordings read: what they were made of, flown again, gone on with, exported."""
