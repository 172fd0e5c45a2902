"""The words of files and the command line for methods, models and channels."""

from typing import Final

EQUATIONS: Final = ("full", "modified", "basic", "longitudinal")
TRIGONOMETRY: Final = ("exact", "report")


# The words by which an identification is asked for: models and channels.


SHIP: Final = "ship/1"  # form of the file of a ship that is not linear
MODELS: Final = ("1", "2", "3", "nomoto1", "nomoto2")
CHANNELS: Final = ("bow_sway", "stern_sway", "sway", "yaw_rate", "heading")  # outputs, in order
