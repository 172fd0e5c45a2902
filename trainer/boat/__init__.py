"""A boat put together from its file, and the orders that it obeys."""
