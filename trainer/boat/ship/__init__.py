"""A ship that is not a submarine: its equations, as its file has them."""
