"""How well an exercise was done: measures of a recorded run, and the rules that use them."""
