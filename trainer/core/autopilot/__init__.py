"""The automatic helmsman and planesman: depth, course, speed and trim keeping."""
