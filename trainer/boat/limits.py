"""The calls when a boat passes a limit, or leaves the sea.

A session asks ``LimitMonitor.look`` after each tick, and announces the calls. The limits are those
of the exercise, and those of the equations' range. A limit is called once when it is passed, and
again only if the boat has come back within it meanwhile.
"""

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, fields
from typing import Any, Final

import numpy as np

from trainer.boat.boat import STATE_OFFSETS, Boat
from trainer.boat.calls import MonitorCall, Rank
from trainer.boat.flown_ticks import FlownTicks, Mask, count_before
from trainer.boat.grounding import clearance
from trainer.boat.readings import NumberReader, read_rates
from trainer.boat.world.bottom import heights_of_keel, keel_of
from trainer.boat.world.encounters import EncounterMonitor
from trainer.boat.world.scope import periscope_of
from trainer.config.exercise.exercise import ExerciseLimits
from trainer.core.bottom import SOUNDING_STATIONS as STATIONS
from trainer.core.kernel import Numbers
from trainer.core.sea.free_surface import DECK_REACH, deck_height, sail_height
from trainer.units import DEGREE, KNOT

RECALL_COVER_M: Final = 1.0  # [m] of water over it before the same can be called out again
Z, WAVE_OFFSET, VALIDITY_OFFSET = (
    STATE_OFFSETS["z"],
    STATE_OFFSETS["eta_wave"],
    STATE_OFFSETS["validity"],
)
SPEED_OFFSET = STATE_OFFSETS["u"]
NORTH_OFFSET, EAST_OFFSET = STATE_OFFSETS["through_north"], STATE_OFFSETS["through_east"]
HEIGHT_OFFSET, OMEGA_OFFSET, DIRECTION_OFFSET, COSINES_OFFSET = (
    STATE_OFFSETS[f"sea_{name}"] for name in ("height", "omega", "direction", "cosines")
)
HEIGHT_ERROR_M, RATIO_ERROR = 1e-6, 1e-9  # of what is computed for many ticks at once
LIMIT_ERRORS: Final = {"clearance_m": HEIGHT_ERROR_M, "speed_over_ground_kn": 1e-9}  # likewise
FULL_BALLAST_SHARE: Final = 0.95  # [-] of main ballast; with less aboard the boat means to come up


RANGE_REENTRY_S: Final = 30.0  # [s] inside the equations' range before leaving it is news again
RANGE_WORDS: Final = ("", "equations extrapolated", "outside the equations")
FOLLOWING_SEA_TEXT: Final = "followed by a sea that the filter cannot follow"
FOLLOWING_SPEED_RATIO: Final = 0.15  # [-] speed with the waves over the peak wave's
MAST_SPEED_TEXT: Final = "faster than the mast stands"
WAVE_FELT_DEPTH: Final = 3.0  # [-] depth times the peak's wave number, above which waves are felt
# remarks on the model, which are no danger to the boat; only what it does astern is a mere estimate
RANGE_RANKS: Final = (Rank.CAUTION, Rank.CAUTION, Rank.WARNING)
RANGE_REASONS: Final = (
    "",
    "the flow is further off the bow than the boat was ever tested",
    "the boat goes astern or across the flow; what it does now is an estimate",
)
LIMIT_WORDS: Final = {  # what passing each limit is called; depth grows downwards
    "depth_m_max": "deeper than {:g} m",
    "depth_m_min": "shallower than {:g} m",
    "pitch_deg_max": "pitch more than {:g} deg",
    "heel_deg_max": "heel more than {:g} deg",
    "speed_kn_max": "faster than {:g} kn",
    "speed_kn_min": "slower than {:g} kn",
    "speed_over_ground_kn_max": "faster than {:g} kn over the ground",
    "validity_level_max": "validity level above {:g}",
    "clearance_m_min": "less than {:g} m of water under the keel",
    "cpa_m_min": "nearer than {:g} m to a ship",
}


# from the number of a state by its name, or those of many states
LIMIT_READERS: Final[dict[str, Callable[[NumberReader], Any]]] = {
    "depth_m": lambda read: read("z"),
    "pitch_deg": lambda read: abs(read("theta") / DEGREE),
    "heel_deg": lambda read: abs(read("phi") / DEGREE),
    "speed_kn": lambda read: read("u") / KNOT,
    "speed_over_ground_kn": lambda read: read_rates(read).way / KNOT,
    "validity_level": lambda read: read("validity"),
}


def height_showing(boat: Boat) -> float:
    """Return the height [m] of the highest part of sail and deck above the sea."""
    records = boat.records
    sail = sail_height(records.vessel, records.state)
    return float(max(sail, deck_height(records.vessel, records.state)))


def is_deep(boat: Boat) -> bool:
    """Return whether nothing of the boat can be near the surface, whatever its attitude.

    The costly look at sail and deck is then left out.
    """
    return boat.plain[Z] + boat.plain[WAVE_OFFSET] > boat.reach + RECALL_COVER_M


def following_speed_ratio(boat: Boat) -> float:
    """Return the boat's speed with the waves over the peak wave's [-].

    It tells how fast the sea follows, because the waves' filter is true for slow encounters alone.
    It is 0 without such a filter, and at depths where waves are not felt.
    """
    plain = boat.plain
    if plain[HEIGHT_OFFSET] == 0.0 or plain[COSINES_OFFSET] == 1.0:
        return 0.0
    # the speed through the water counts, because the waves run in the water
    omega, way, g = plain[OMEGA_OFFSET], plain[DIRECTION_OFFSET], float(boat.vessel.g)
    if plain[Z] * omega * omega > WAVE_FELT_DEPTH * g:
        return 0.0
    return omega / g * (plain[NORTH_OFFSET] * math.cos(way) + plain[EAST_OFFSET] * math.sin(way))


def may_surface(boat: Boat, flown: FlownTicks) -> Mask:
    """Return at which of some ticks main ballast is blown, or being blown.

    ``depths`` looks anew at these ticks, because a boat that surfaces is not called for its masts.
    """
    if not boat.vessel.fitted:
        return np.zeros(len(flown), np.bool_)
    held, capacity = flown.block("water", 3).sum(axis=1), float(boat.vessel.capacity[:3].sum())
    mask: Mask = (held < FULL_BALLAST_SHARE * capacity) | flown.block("blow", 3).any(axis=1)
    return mask


def is_surfacing(boat: Boat) -> bool:
    """Return whether main ballast is being blown, or blown."""
    if not boat.vessel.fitted:
        return False
    s = boat.state
    held = float(s.water[:3].sum()) < FULL_BALLAST_SHARE * float(boat.vessel.capacity[:3].sum())
    return held or bool(s.blow[:3].any())


@dataclass
class LimitMonitor:
    """The limits that the boat is beyond, and the times at which each was passed."""

    limits: ExerciseLimits = field(default_factory=ExerciseLimits)
    beyond: set[str] = field(default_factory=set)
    shows: bool = False
    shown: str = ""  # as which alert
    times: dict[str, list[float]] = field(default_factory=dict)  # [s]
    validity: int = 0  # the worst since the boat was last inside the equations' range for long
    inside_since: float = 0.0  # [s]
    followed: bool = False  # by a sea, faster than the wave filter is true
    followed_since: float = 0.0  # [s]
    shaken: bool = False  # the mast of the periscope
    shaken_since: float = 0.0  # [s]
    encounters: EncounterMonitor = field(default_factory=EncounterMonitor)
    _set: tuple[tuple[str, float], ...] = field(init=False)  # the limits that there are, by name

    def __post_init__(self) -> None:
        every = ((item.name, getattr(self.limits, item.name)) for item in fields(self.limits))
        self._set = tuple((name, limit) for name, limit in every if limit is not None)

    @classmethod
    def over(cls, boat: Boat, limits: ExerciseLimits) -> "LimitMonitor":
        """Return the watch over a boat. What shows or is beyond its limit now is no news."""
        monitor = cls(limits, encounters=EncounterMonitor.over(boat))
        monitor.reset_to(boat)
        return monitor

    def reset_to(self, boat: Boat) -> None:
        """Take the boat as it is. Nothing of it is news."""
        self.encounters.reset_to(boat)
        self.validity, self.shows, self.shaken = 0, False, False
        self.inside_since = self.followed_since = self.shaken_since = boat.time
        self.followed = self.followed and following_speed_ratio(boat) > FOLLOWING_SPEED_RATIO
        self._passed(boat)
        self._broken_surface(boat)
        self._out_of_range(boat)
        self._shaking_mast(boat)

    def look(self, boat: Boat) -> list[MonitorCall]:
        """Return what there is to call out after a tick."""
        met = self.encounters.look(boat)
        usual = boat.plain[VALIDITY_OFFSET] == 0.0 and self.validity == 0
        usual = usual and boat.plain[HEIGHT_OFFSET] == 0.0
        shaking = self._shaking_mast(boat)
        if usual and not self._set and not self.shows and not shaking and is_deep(boat):
            return met
        news = shaking + self._out_of_range(boat) + self._passed(boat) + self._broken_surface(boat)
        news += self._following_sea(boat)
        if not news:
            return met
        for what, _ in news:
            self.times.setdefault(what, []).append(boat.time)
        tick = f"tick {boat.ticks} ({boat.time:g} s)"
        return met + [call._replace(text=f"{tick}: {call.text}") for _, call in news]

    def _passed(self, boat: Boat) -> list[tuple[str, MonitorCall]]:
        """Return each limit passed since the last look, and the words for it."""
        news = []
        for name, limit in self._set:
            key, _, end = name.rpartition("_")
            value = self._value(boat, key)
            if not (value > limit if end == "max" else value < limit):
                self.beyond.discard(name)
            elif name not in self.beyond:
                self.beyond.add(name)
                said = LIMIT_WORDS[name].format(limit)
                news.append((said, MonitorCall(f"LIMIT: {said}", key=name)))
        return news

    def _value(self, boat: Boat, key: str) -> float:
        """Return the quantity that a limit bounds, in the unit of the limit."""
        if key == "clearance_m":
            return clearance(boat)
        if key == "cpa_m":
            return self.encounters.nearest[1]
        return float(LIMIT_READERS[key](lambda name: boat.plain[STATE_OFFSETS[name]]))

    @property
    def holding(self) -> set[str]:
        """Return the keys of the alerts called that hold still."""
        remarks = {RANGE_WORDS[self.validity]: self.validity > 0, self.shown: self.shows}
        remarks |= {FOLLOWING_SEA_TEXT: self.followed, MAST_SPEED_TEXT: self.shaken}
        hold = {key for key, holds in remarks.items() if holds}
        return hold | self.beyond | self.encounters.holding

    def quiet_ticks(self, boat: Boat, flown: FlownTicks) -> int:
        """Return after how many ticks there may be something to call, or all of them."""
        scope = periscope_of(boat)
        if self.shaken or (scope is not None and scope.acts):
            return 0
        ranges = self.encounters.ranges(flown)
        validity = flown["validity"].astype(np.int64)
        again = (validity == 0) & (self.validity > 0)
        mask = (validity > self.validity) | again | self._may_show(boat, flown)
        mask |= self._may_follow(boat, flown)
        for name, limit in self._set:
            key, _, end = name.rpartition("_")
            value = self._values(boat, flown, ranges, key)
            most = LIMIT_ERRORS.get(key, 0.0)
            for error in {-most, most}:
                passed = value + error > limit if end == "max" else value + error < limit
                mask |= passed != (name in self.beyond)
        return min(count_before(mask), self.encounters.quiet_ticks(flown, ranges))

    def _values(self, boat: Boat, flown: FlownTicks, ranges: Numbers, key: str) -> Numbers:
        """Return the quantity that a limit bounds at each tick, in the unit of the limit."""
        if key == "clearance_m":
            grounds, length = [*flown.block("bottom", len(STATIONS)).T], float(boat.vessel.ell)
            return heights_of_keel(grounds, flown.__getitem__, length, keel_of(boat.vessel))
        if key == "cpa_m":
            nearest: Numbers = ranges.min(axis=0, initial=math.inf)
            return nearest
        values: Numbers = LIMIT_READERS[key](flown.__getitem__)
        return values

    def pass_over(self, _boat: Boat, flown: FlownTicks) -> None:
        """Take these ticks as seen, in which there was nothing to call."""
        if self.validity > 0:  # else it was inside the range at each of them
            self.inside_since = float(flown.times[-1])
        if self.followed:
            self.followed_since = float(flown.times[-1])
        self.encounters.pass_over(flown)

    def _may_show(self, boat: Boat, flown: FlownTicks) -> Mask:
        """Return at which ticks the boat may come out of the sea, or may have been covered."""
        c, water = boat.vessel, flown["z"] + flown["eta_wave"]
        deep: Mask = water > boat.reach + RECALL_COVER_M
        if deep.all():
            return deep if self.shows else ~deep
        sine, upright = np.sin(flown["theta"]), np.cos(flown["theta"]) * np.cos(flown["phi"])
        deck = DECK_REACH * c.ell * np.abs(sine) - c.z_deck * upright
        height = np.maximum(c.x_sail * sine - c.z_sail * upright, deck) - water
        # the core has a sine of its own, and so a height this near may be either
        covered: Mask = deep | (height < HEIGHT_ERROR_M - RECALL_COVER_M)
        out: Mask = ~deep & (height > -HEIGHT_ERROR_M)
        return covered if self.shows else out

    def _may_follow(self, boat: Boat, flown: FlownTicks) -> Mask:
        """Return at which ticks the sea may begin or cease to follow too fast."""
        omega, way, g = flown["sea_omega"], flown["sea_direction"], float(boat.vessel.g)
        along = flown["through_north"] * np.cos(way) + flown["through_east"] * np.sin(way)
        felt = (flown["sea_height"] != 0.0) & (flown["sea_cosines"] != 1.0)
        felt &= flown["z"] * omega * omega <= WAVE_FELT_DEPTH * g
        ratio = np.where(felt, omega / g * along, 0.0)
        slower: Mask = ratio < FOLLOWING_SPEED_RATIO + RATIO_ERROR
        faster: Mask = ratio > FOLLOWING_SPEED_RATIO - RATIO_ERROR
        return slower if self.followed else faster

    def _out_of_range(self, boat: Boat) -> list[tuple[str, MonitorCall]]:
        """Return that the equations are extrapolated or at their end, if that is news."""
        now = int(boat.plain[VALIDITY_OFFSET])
        if now > 0:
            self.inside_since = boat.time
        elif boat.time - self.inside_since > RANGE_REENTRY_S:
            self.validity = 0
        if now <= self.validity:
            return []
        self.validity = now
        said = RANGE_WORDS[now]
        text = f"{said.upper()}: {RANGE_REASONS[now]}"
        return [(said, MonitorCall(text, RANGE_RANKS[now], said))]

    def _following_sea(self, boat: Boat) -> list[tuple[str, MonitorCall]]:
        """Return that the sea follows too fast for the wave filter, if that is news."""
        chase = following_speed_ratio(boat)
        if chase <= FOLLOWING_SPEED_RATIO:
            if boat.time - self.followed_since > RANGE_REENTRY_S:
                self.followed = False
            return []
        self.followed_since = boat.time
        if self.followed:
            return []
        self.followed = True
        said = (
            f"FOLLOWING SEA: at {chase:.2f} of the waves' speed the filter puts energy into wrong "
            'bands; a sea with generator = "cosines" does not'
        )
        return [(FOLLOWING_SEA_TEXT, MonitorCall(said, Rank.CAUTION, FOLLOWING_SEA_TEXT))]

    def _shaking_mast(self, boat: Boat) -> list[tuple[str, MonitorCall]]:
        """Return that the mast is out at a speed that it does not stand, if that is news."""
        scope, speed = periscope_of(boat), float(boat.plain[SPEED_OFFSET])
        if scope is None or not scope.acts or not scope.shakes(speed, scope.at(boat.ticks)):
            if boat.time - self.shaken_since > RANGE_REENTRY_S:
                self.shaken = False
            return []
        self.shaken_since = boat.time
        if self.shaken:
            return []
        self.shaken = True
        said = f"MAST SHAKES: {scope.too_fast(speed)}; nothing can be measured"
        return [(MAST_SPEED_TEXT, MonitorCall(said, Rank.WARNING, MAST_SPEED_TEXT))]

    def _broken_surface(self, boat: Boat) -> list[tuple[str, MonitorCall]]:
        """Return that sail or deck has come out of the sea, if it has."""
        if is_deep(boat):
            self.shows = False
            return []
        height = height_showing(boat)
        if self.shows or height <= 0.0:
            self.shows = self.shows and height > -RECALL_COVER_M
            return []
        self.shows, self.shown = True, "surfaced" if is_surfacing(boat) else "broached"
        call = MonitorCall(f"BROACHED: the boat shows {height:.1f} m above the sea", key=self.shown)
        if self.shown == "surfaced":
            text = "surfaced: the boat shows above the sea"
            call = MonitorCall(text, Rank.CAUTION, self.shown)
        return [(self.shown, call)]

    def account(self) -> str:
        """Return how often each has happened, in words."""
        return account_of(self.times)


def account_of(times: Mapping[str, Sequence[float]]) -> str:
    """Return in words how often each event was and when first, by its times [s]."""
    return ", ".join(
        f"{what} {len(when)} time{'s' * (len(when) > 1)} (first at {when[0]:g} s)"
        for what, when in times.items()
    )
