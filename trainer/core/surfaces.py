"""The control surfaces: names, and letters at the end of their places in the records."""

from typing import Final

SURFACES: Final = {"rudder": "r", "stern": "s", "bow": "b"}
