"""What the identification needs fast: sampling, filters, their gradients. Numbers only."""
