"""The world around the boat: what writes current, ground and ships near into its state."""
