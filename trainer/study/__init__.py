"""The engineer's programs, one module each."""
