"""The cost of the trainer on this machine."""
