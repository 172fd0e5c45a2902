"""The commands, by who uses them. They import what they need when they run: help comes at once."""
