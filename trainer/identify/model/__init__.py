"""The models of a steered ship, and systems of a user's own: matrices and sampling."""
