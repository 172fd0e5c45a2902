"""Studies of many runs that differ in known ways."""
