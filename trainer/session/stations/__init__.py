"""Who is attached to a session, what each may order, and what each is sent."""
