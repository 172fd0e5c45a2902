"""The world around the boat: what writes current, ground and ships near into its state.

Begin with ``world``: its parts write a few numbers before each tick, by exercise and orders alone,
so that a replay meets the same world. ``bottom`` is the ground, ``contacts`` the ships near,
``encounters`` how near they come, ``scope`` what the periscope sees of them, ``swell`` the waves
round the boat.

How a ship moves (``tracks``, ``steered``, ``steered_ship``), its ``lights``, its pull
(``ship_force``) and the ``current`` stay here.
"""

# The modules that other rooms may use.
# fmt: off
__all__ = [
    "approach", "bottom", "contacts", "encounters", "hulls", "nomoto", "scope", "swell", "world",
]
# fmt: on
