"""A day of exercises at full speed, or half an hour by the clock."""
