"""The control surfaces: names, and letters at the end of their fields in the records.

So ``delta_r`` is the angle of the rudder.

Orders, casualties, pages and exports find a surface's numbers by it.
"""

from typing import Final

SURFACES: Final = {"rudder": "r", "stern": "s", "bow": "b"}
