"""The fast part of identification: sampling, filters, their gradients. Numbers only."""
