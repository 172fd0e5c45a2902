"""The programs that made the constants of the core; tests make the constants again."""
