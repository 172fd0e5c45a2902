"""NMEA 0183: sentences to instruments, and orders from controllers."""
