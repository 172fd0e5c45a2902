"""Orders as lines of words: their table, their grammar, their help, their files."""
