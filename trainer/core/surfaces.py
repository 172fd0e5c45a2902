"""The control surfaces: their names, and the letters that their places in the records end in."""

from typing import Final

SURFACES: Final = {"rudder": "r", "stern": "s", "bow": "b"}
