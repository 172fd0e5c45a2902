"""What a sweep compiles: its random numbers, and the start of many boats."""
