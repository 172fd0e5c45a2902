"""A boat from the drawing of its hull, with a deviation on each coefficient."""
