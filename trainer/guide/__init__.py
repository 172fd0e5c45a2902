"""The qualification test guide: a boat's equation sets flown against each other and written up."""
