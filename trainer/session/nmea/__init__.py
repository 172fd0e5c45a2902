"""NMEA 0183, out and in."""
