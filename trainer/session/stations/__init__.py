"""The stations of a session: their rights, their orders, and what each is sent."""
