"""Tanks, air, pumps, and the buoyancy that follows from them."""
