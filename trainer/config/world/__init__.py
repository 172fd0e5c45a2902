"""What is around a boat, read into records: sea, current, ground, ships.

Begin with ``world``.
"""

# The modules that other rooms may use.
__all__ = ["bottom", "contacts", "current", "sea", "sound_rows", "soundings", "world"]
