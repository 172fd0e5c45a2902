"""What the trainer costs on this machine."""
