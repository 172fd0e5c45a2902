"""What identification found, for terminal, plot and browser."""
