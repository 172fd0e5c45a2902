"""A machine plays commands over recordings of any layout, and none is ruined."""
