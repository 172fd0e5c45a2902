"""What a screen shows, drawn as text."""
