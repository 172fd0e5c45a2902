"""The words of files and the command line for methods, models and channels."""

from typing import Final

EQUATION_SETS: Final = ("full", "modified", "basic", "longitudinal")
TRIGONOMETRY_KINDS: Final = ("exact", "report")


SHIP_FILE_SCHEMA: Final = "ship/1"  # form of the file of a ship that is not linear
LINEAR_MODELS: Final = ("1", "2", "3", "nomoto1", "nomoto2")
OUTPUT_CHANNELS: Final = (
    "bow_sway",
    "stern_sway",
    "sway",
    "yaw_rate",
    "heading",
)  # outputs, in order
