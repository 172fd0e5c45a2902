"""The likelihood in plain C, compiled on this machine: what the compiled Python is held against."""
