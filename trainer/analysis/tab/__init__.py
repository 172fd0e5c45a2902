"""A boat for a page: her numbers, and what was recorded of her."""
