"""Instruments for the world outside: NMEA 0183 sentences, and the orders that come so."""
