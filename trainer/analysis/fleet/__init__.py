"""Many boats flown side by side, each to the bits that it has alone."""
