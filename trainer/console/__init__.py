"""The screens: clients of the line protocol."""
