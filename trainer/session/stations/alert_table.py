"""The table of all alerts: when each begins and ends, and who answers for it.

Monitors call an alert by its key, whose name is a row here. Figures are those of the monitors. An
alert is acknowledged at a station of its roles, or anywhere if none of them is manned; others may
silence it. Tests compare the ranks with those of the calls, and docs/station-tables.md with all.
"""

from collections.abc import Mapping
from typing import Final, NamedTuple

from trainer.boat.calls import Rank
from trainer.boat.depths import CALL_SPACING_M, FIRST_CALL_M, RECALL_RISE_M, RECALL_SINK_M
from trainer.boat.grounding import BEYOND_KEY, RECALL_AFLOAT_S
from trainer.boat.limits import (  # fmt: skip
    FOLLOWING_SEA_TEXT,
    LIMIT_WORDS,
    MAST_SPEED_TEXT,
    RANGE_REENTRY_S,
    RANGE_WORDS,
    RECALL_COVER_M,
)
from trainer.boat.pilot import LACK_RECALL_S, MIN_LACK_TIME_S
from trainer.boat.world.encounters import RECALL_CLEAR_S
from trainer.session.stations.alerts import REMARK_S

HELM, PLANES = ("helm", "pilot"), ("planes", "pilot", "diving")
BALLAST, SCOPE, INSTRUCTOR = ("ballast", "diving"), ("scope",), ("instructor",)
EMERGENCY, ALARM, WARNING, CAUTION = Rank
BEYOND: Final = f"every {CALL_SPACING_M:g} m beyond it"
RISEN, SUNK = f"{RECALL_RISE_M:g} m above that", f"{RECALL_SINK_M:g} m deeper"
AFLOAT, CLEAR = f"{RECALL_AFLOAT_S:g} s off it", f"{RECALL_CLEAR_S:g} s clear"
COVERED: Final = f"{RECALL_COVER_M:g} m of water over sail and deck"
INSIDE: Final = f"{RANGE_REENTRY_S:g} s without it"
SUPPLIED: Final = f"{LACK_RECALL_S:g} s with all that is ordered"
SHORT: Final = f"after {MIN_LACK_TIME_S:g} s"
SOUND_PACES_S: Final = {EMERGENCY: 2.0, ALARM: 10.0, WARNING: 60.0}  # [s] from sound to sound


class AlertRow(NamedTuple):
    """What is said of one alert."""

    title: str
    rank: Rank
    begins: str
    ends: str
    roles: tuple[str, ...]  # of the stations that acknowledge it; none: of all

    @property
    def kind(self) -> str:
        """Return the kind of the events that tell of it."""
        return "watch" if self.roles == INSTRUCTOR else "depth"


# fmt: off
_ROWS: Final[Mapping[str, tuple[str, Rank, str, str, tuple[str, ...]]]] = {
    "collapse": ("Hull collapsed", EMERGENCY, "at collapse depth", "time goes back", PLANES),
    "collision": ("Collision", EMERGENCY, "hulls touch", "they part", INSTRUCTOR),
    "beyond test depth": ("Beyond test depth", EMERGENCY, BEYOND, RISEN, PLANES),
    "test depth": ("Test depth passed", ALARM, "at test depth", RISEN, PLANES),
    "near test depth": ("Near test depth", ALARM, f"{FIRST_CALL_M:g} m above it", RISEN, PLANES),
    "mast out": ("Too much mast", ALARM, "2 m above periscope depth", SUNK, PLANES),
    "sail near the surface": ("Sail near the surface", ALARM, "4 m above it", SUNK, PLANES),
    "aground": ("Aground", ALARM, "the ground carries the boat", AFLOAT, PLANES),
    "approach": ("Closest approach", ALARM, "as `[contacts]` says", CLEAR, INSTRUCTOR),
    "broached": ("Broached", ALARM, "sail or deck shows", COVERED, INSTRUCTOR),
    **{name: ("Limit passed", ALARM, words.replace("{:g}", "..."), "not so", INSTRUCTOR)
       for name, words in LIMIT_WORDS.items()},
    MAST_SPEED_TEXT: ("Mast shakes", WARNING, MAST_SPEED_TEXT, INSIDE, INSTRUCTOR),
    RANGE_WORDS[2]: ("Outside the equations", WARNING, "validity level 2", INSIDE, INSTRUCTOR),
    "emergency ascent": ("Emergency ascent", WARNING, "emergency blow", "it has risen", PLANES),
    "astern": ("Planes amidships", WARNING, "slowly astern", "ahead, or faster", PLANES),
    "hover lost": ("Hovering given up", WARNING, "the pump cannot", "it hovers", BALLAST),
    "trim short": ("No water to trim", WARNING, SHORT, "there is some", BALLAST),
    "speed not reached": ("Speed not reached", WARNING, SHORT, "it is reached", HELM),
    "engine limited": ("Engine limited", WARNING, "by torque or power", SUPPLIED, HELM),
    "rudder short on the X-tail": ("Rudder short", WARNING, "fins are shared", SUPPLIED, HELM),
    "stern short on the X-tail": ("Planes short", WARNING, "fins are shared", SUPPLIED, PLANES),
    FOLLOWING_SEA_TEXT: ("Following sea", CAUTION, "too fast a sea", INSIDE, INSTRUCTOR),
    RANGE_WORDS[1]: ("Equations extrapolated", CAUTION, "validity level 1", INSIDE, INSTRUCTOR),
    BEYOND_KEY: ("Beyond the chart", CAUTION, "off it", "on it", ()),
    "surfaced": ("Surfaced", CAUTION, "shows as it means to", COVERED, INSTRUCTOR),
    "afloat": ("Afloat", CAUTION, "surfaced", "a depth is ordered", ()),
    "": ("Remark", CAUTION, "said once", f"after {REMARK_S:g} s", ()),
}
# fmt: on
ALERT_TABLE: Final = {name: AlertRow(*row) for name, row in _ROWS.items()}


def alert_row(key: str) -> AlertRow:
    """Return the row of an alert, whose key may name a ship after a colon."""
    return ALERT_TABLE[key.partition(":")[0]]
