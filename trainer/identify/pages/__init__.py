"""The findings of identification, for terminal, plot and browser."""
