"""Vessels, seas, casualties and exercises: from their files to checked records."""
