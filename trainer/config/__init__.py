"""TOML files read into checked records."""
