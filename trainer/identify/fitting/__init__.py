"""Parameters estimated from a record: the problem, its cost, the search and where it starts."""
