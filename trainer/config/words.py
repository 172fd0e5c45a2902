"""Words that files and the command line share: equation sets, models, channels.

They stand apart from the modules that use them, so that ``--help`` lists the words of a choice
without loading any of those. Equation sets: ``full`` is the report's whole equations, ``modified``
and ``basic`` are compact ones, ``longitudinal`` is of the vertical plane alone.
"""

from typing import Final

EQUATION_SETS: Final = ("full", "modified", "basic", "longitudinal")
TRIGONOMETRY_KINDS: Final = ("exact", "report")
ENDLESS_BATTERY: Final = "endless"
BATTERY_KINDS: Final = ("drained", ENDLESS_BATTERY)


SHIP_FILE_SCHEMA: Final = "ship/1"  # form of the file of a ship that is not linear
LINEAR_MODELS: Final = ("1", "2", "3", "nomoto1", "nomoto2")
OUTPUT_CHANNELS: Final = (
    "bow_sway",
    "stern_sway",
    "sway",
    "yaw_rate",
    "heading",
)  # outputs, in order
