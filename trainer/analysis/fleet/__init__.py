"""Many boats flown side by side, each with the bits that it has alone."""
