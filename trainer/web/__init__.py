"""Stations in a browser: pages, and the server that carries their lines to a session."""
