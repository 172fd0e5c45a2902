"""Studies of many members: one boat, ship or exercise with some of its numbers varied."""
