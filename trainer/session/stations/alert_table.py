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
from trainer.boat.plant_alerts import (
    BATTERY_BOUNDS,
    BUS_LOST,
    FIRE,
    HALF_TANK,
    LOW_MPA,
    MAIN_LOST,
    OIL_LOW,
    OVERLOAD,
    PLANT_RANKS,
    REFILLED_TANK,
    SEEN_SMOKE,
    TANK_HALF,
    THIN_SMOKE,
    WHOLE_MPA,
)
from trainer.boat.world.encounters import RECALL_CLEAR_S
from trainer.session.stations.alerts import REMARK_S

HELM_ROLES, PLANES_ROLES = ("helm", "pilot"), ("planes", "pilot", "diving")
BALLAST_ROLES, SCOPE_ROLES, INSTRUCTOR_ROLES = ("ballast", "diving"), ("scope",), ("instructor",)
EMERGENCY, ALARM, WARNING, CAUTION = Rank
BEYOND_WORDS: Final = f"every {CALL_SPACING_M:g} m beyond it"
RISEN_WORDS, SUNK_WORDS = f"{RECALL_RISE_M:g} m above that", f"{RECALL_SINK_M:g} m deeper"
AFLOAT_WORDS, CLEAR_WORDS = f"{RECALL_AFLOAT_S:g} s off it", f"{RECALL_CLEAR_S:g} s clear"
COVERED_WORDS: Final = f"{RECALL_COVER_M:g} m of water over sail and deck"
INSIDE_WORDS: Final = f"{RANGE_REENTRY_S:g} s without it"
SUPPLIED_WORDS: Final = f"{LACK_RECALL_S:g} s with all that is ordered"
PLANT_WORDS: Final = {  # title, when it begins, when it is over
    MAIN_LOST: ("Main oil lost", "no pressure in main", "whole rate again"),
    FIRE: (
        "Fire or smoke",
        f"smoke above {100.0 * SEEN_SMOKE:g} %",
        f"{100.0 * THIN_SMOKE:g} % or less",
    ),
    OVERLOAD: ("Overload", "a breaker gives too much", "it does not, or is open"),
    BUS_LOST: ("Bus lost", "a bus is dead", "it is live"),
    **{
        name: (
            name.capitalize(),
            f"below {100.0 * begins.charge:g} %, or {begins.minutes:g} min at this draw",
            f"{100.0 * ends.charge:g} %, and {ends.minutes:g} min",
        )
        for name, (begins, ends) in BATTERY_BOUNDS.items()
    },
    OIL_LOW: ("Oil low", f"below {LOW_MPA:g} MPa", f"{WHOLE_MPA:g} MPa again"),
    TANK_HALF: (
        "Oil tank half empty",
        f"less than {100.0 * HALF_TANK:g} % of its oil",
        f"{100.0 * REFILLED_TANK:g} % again",
    ),
}
SHORT_WORDS: Final = f"after {MIN_LACK_TIME_S:g} s"
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
        return "watch" if self.roles == INSTRUCTOR_ROLES else "depth"


# fmt: off
_ROWS: Final[Mapping[str, tuple[str, Rank, str, str, tuple[str, ...]]]] = {
    "collapse": ("Hull collapsed", EMERGENCY, "at collapse depth", "time goes back", PLANES_ROLES),
    "collision": ("Collision", EMERGENCY, "hulls touch", "they part", INSTRUCTOR_ROLES),
    "beyond test depth": ("Beyond test depth", EMERGENCY, BEYOND_WORDS, RISEN_WORDS, PLANES_ROLES),
    "test depth": ("Test depth passed", ALARM, "at test depth", RISEN_WORDS, PLANES_ROLES),
    "near test depth": (
        "Near test depth", ALARM, f"{FIRST_CALL_M:g} m above it", RISEN_WORDS, PLANES_ROLES,
    ),
    "mast out": ("Too much mast", ALARM, "2 m above periscope depth", SUNK_WORDS, PLANES_ROLES),
    "sail near the surface": (
        "Sail near the surface", ALARM, "4 m above it", SUNK_WORDS, PLANES_ROLES,
    ),
    "aground": ("Aground", ALARM, "the ground carries the boat", AFLOAT_WORDS, PLANES_ROLES),
    "approach": ("Closest approach", ALARM, "as `[contacts]` says", CLEAR_WORDS, INSTRUCTOR_ROLES),
    "broached": ("Broached", ALARM, "sail or deck shows", COVERED_WORDS, INSTRUCTOR_ROLES),
    **{name: ("Limit passed", ALARM, words.replace("{:g}", "..."), "not so", INSTRUCTOR_ROLES)
       for name, words in LIMIT_WORDS.items()},
    MAST_SPEED_TEXT: ("Mast shakes", WARNING, MAST_SPEED_TEXT, INSIDE_WORDS, INSTRUCTOR_ROLES),
    RANGE_WORDS[2]: (
        "Outside the equations", WARNING, "validity level 2", INSIDE_WORDS, INSTRUCTOR_ROLES,
    ),
    **{name: (words[0], PLANT_RANKS[name], *words[1:], BALLAST_ROLES)
       for name, words in PLANT_WORDS.items()},
    "emergency ascent": (
        "Emergency ascent", WARNING, "emergency blow", "it has risen", PLANES_ROLES,
    ),
    "astern": ("Planes amidships", WARNING, "slowly astern", "ahead, or faster", PLANES_ROLES),
    "swinging": ("Swinging astern", WARNING, "a whole turn off", "ahead", HELM_ROLES),
    "hover lost": ("Hovering given up", WARNING, "the pump cannot", "it hovers", BALLAST_ROLES),
    "trim short": ("No water to trim", WARNING, SHORT_WORDS, "there is some", BALLAST_ROLES),
    "speed not reached": ("Speed not reached", WARNING, SHORT_WORDS, "it is reached", HELM_ROLES),
    "engine limited": ("Engine limited", WARNING, "by torque or power", SUPPLIED_WORDS, HELM_ROLES),
    "rudder short on the X-tail": (
        "Rudder short", WARNING, "fins are shared", SUPPLIED_WORDS, HELM_ROLES,
    ),
    "stern short on the X-tail": (
        "Planes short", WARNING, "fins are shared", SUPPLIED_WORDS, PLANES_ROLES,
    ),
    FOLLOWING_SEA_TEXT: (
        "Following sea", CAUTION, "too fast a sea", INSIDE_WORDS, INSTRUCTOR_ROLES,
    ),
    RANGE_WORDS[1]: (
        "Equations extrapolated", CAUTION, "validity level 1", INSIDE_WORDS, INSTRUCTOR_ROLES,
    ),
    BEYOND_KEY: ("Beyond the chart", CAUTION, "off it", "on it", ()),
    "surfaced": ("Surfaced", CAUTION, "shows as it means to", COVERED_WORDS, INSTRUCTOR_ROLES),
    "afloat": ("Afloat", CAUTION, "surfaced", "a depth is ordered", ()),
    "": ("Remark", CAUTION, "said once", f"after {REMARK_S:g} s", ()),
}
# fmt: on
ALERT_TABLE: Final = {name: AlertRow(*row) for name, row in _ROWS.items()}


def alert_row(key: str) -> AlertRow:
    """Return the row of an alert, whose key may name a ship or part."""
    return ALERT_TABLE[key.partition(":")[0]]
