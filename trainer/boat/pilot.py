"""The crew is told what the autopilot and an X-tail do not give."""

import math
from dataclasses import dataclass, field
from typing import Final

from trainer.boat.boat import STATE_PLACES, Boat
from trainer.boat.casualties import active_casualties
from trainer.core.autopilot.ascent import ASCENT_AFLOAT, NO_ASCENT
from trainer.core.autopilot.depth import LEAST_ASTERN
from trainer.core.autopilot.steering import ASTERN_SPEED
from trainer.core.ballast.tanks import AUXILIARY_TANK, TRIM_AFT, TRIM_FORWARD
from trainer.units import KNOT

MIN_LACK_TIME_S: Final = 60.0  # [s] without speed, or water to trim, before that is told
GIVEN_UP_TEXTS: Final = {  # what is not kept, and why
    "emergency ascent": "emergency ascent: bow up, the after group held back; no depth is kept",
    "afloat": "afloat: no depth is kept until one is ordered",
    "astern": f"going astern slower than {LEAST_ASTERN / KNOT:.0f} kn: planes amidships, depth is "
    "for the tanks",
    "hover lost": "hovering is given up: the pump cannot hold this depth; the planes have it",
    "trim short": "automatic trim has no more water or room in a tank: planes carry the rest",
    "speed not reached": "the engine gives all it has, and the ordered speed is not reached",
}
ASCENT_PLACE, SPEED_PLACE = STATE_PLACES["ascent"], STATE_PLACES["u"]
SPEED_SHORT_PLACE, HOVER_LOST_PLACE = STATE_PLACES["speed_short"], STATE_PLACES["hover_lost"]
TRIM_FLOOD_PLACE, TRIM_FORWARD_PLACE = STATE_PLACES["trim_flood"], STATE_PLACES["trim_forward"]
LIMIT_MARGIN: Final = math.radians(0.5)  # [rad] short of the limit that rudder and planes share
MIN_LACK_ANGLE: Final = math.radians(3.0)  # [rad] of an order that is not given, to be told
LACK_RECALL_S: Final = 30.0  # [s] with all that is ordered, before a lack is news again
SHARED_SURFACES: Final = {  # of an X-tail: in words, where it stands and where it is ordered to
    "rudder": ("rudder has", STATE_PLACES["delta_r"], STATE_PLACES["command_r"]),
    "stern": ("stern planes have", STATE_PLACES["delta_s"], STATE_PLACES["command_s"]),
}


def lacks_water(boat: Boat) -> bool:
    """Return whether automatic trim asks for water or room that is not there."""
    flood, forward = boat.plain[TRIM_FLOOD_PLACE], boat.plain[TRIM_FORWARD_PLACE]
    if flood == 0.0 and forward == 0.0:
        return False
    water, capacity = boat.state.water, boat.vessel.capacity
    first, last = (TRIM_AFT, TRIM_FORWARD) if forward > 0.0 else (TRIM_FORWARD, TRIM_AFT)
    moved = forward != 0.0 and (water[first] <= 0.0 or water[last] >= capacity[last])
    end = capacity[AUXILIARY_TANK] if flood > 0.0 else 0.0
    return bool(moved or (flood != 0.0 and water[AUXILIARY_TANK] == end))


def is_broken(boat: Boat, surface: str) -> bool:
    """Return whether a casualty acts on a surface."""
    return any(each.kind.startswith(f"{surface}-") for each in active_casualties(boat))


@dataclass
class TailMonitor:
    """The watch on what rudder and stern planes of an X-tail lack.

    A surface that is broken is not looked at: its order tells nothing of the sharing.
    """

    lacking: dict[str, float] = field(default_factory=dict)  # [s] when each was last seen to

    def look(self, boat: Boat) -> list[tuple[str, str]]:
        """Return what there is to say after a tick, by names for the account."""
        c, plain = boat.vessel, boat.plain
        total = sum(abs(plain[place]) for _, place, _ in SHARED_SURFACES.values())
        if c.x_tail == 0.0 or total < c.limit_s - LIMIT_MARGIN:
            return []
        news = []
        for name, (has, place, command) in SHARED_SURFACES.items():
            stands, ordered = abs(plain[place]), abs(plain[command])
            if ordered - stands <= MIN_LACK_ANGLE or is_broken(boat, name):
                continue
            last = self.lacking.get(name, -math.inf)
            self.lacking[name] = boat.time
            if boat.time - last > LACK_RECALL_S:
                angles = f"{math.degrees(stands):.0f} of {math.degrees(ordered):.0f} deg"
                words = f"X-TAIL: the {has} {angles}: rudder and stern planes share the fins"
                news.append((f"{name} short on the X-tail", words))
        return news


@dataclass
class PilotMonitor:
    """The laws given up at present, and the times [s] at which laws were."""

    given_up: set[str] = field(default_factory=set)
    times: dict[str, list[float]] = field(default_factory=dict)  # [s]
    trimmed: float = 0.0  # [s] when tanks last had what automatic trim asks for
    tail: TailMonitor = field(default_factory=TailMonitor)

    @classmethod
    def over(cls, boat: Boat) -> "PilotMonitor":
        """Return the watch over a boat; what is given up now is no news."""
        monitor = cls()
        monitor.settle(boat)
        return monitor

    def settle(self, boat: Boat) -> None:
        """Take the boat as it is, after a jump in time. Nothing of it is news."""
        self.trimmed = boat.time
        self.given_up = self._left_undone(boat) if self._is_unusual(boat) else set()
        self.tail.lacking.clear()
        self.tail.look(boat)

    def look(self, boat: Boat) -> list[str]:
        """Return what there is to say after a tick."""
        shared = self.tail.look(boat)
        for name, _ in shared:
            self.times.setdefault(name, []).append(boat.time)
        news = [words for _, words in shared]
        news += [f"autopilot: {text}" for text in self._news(boat)]
        return [f"tick {boat.ticks} ({boat.time:g} s): {text}" for text in news]

    def _news(self, boat: Boat) -> list[str]:
        """Return what the autopilot has newly given up, or has again."""
        if not lacks_water(boat):
            self.trimmed = boat.time
        if not self.given_up and not self._is_unusual(boat):
            return []
        now = self._left_undone(boat)
        news = [GIVEN_UP_TEXTS[name] for name in sorted(now - self.given_up)]
        for name in now - self.given_up:
            self.times.setdefault(name, []).append(boat.time)
        if "emergency ascent" in self.given_up and boat.plain[ASCENT_PLACE] == NO_ASCENT:
            news.append(f"the ascent is over: keeping depth {boat.state.ordered_depth:.0f} m")
        self.given_up = now
        return news

    def _is_unusual(self, boat: Boat) -> bool:
        """Return whether anything could be given up."""
        plain = boat.plain
        lost = plain[HOVER_LOST_PLACE] != 0.0 or plain[SPEED_SHORT_PLACE] > MIN_LACK_TIME_S
        lost = lost or boat.time - self.trimmed > MIN_LACK_TIME_S
        return lost or plain[ASCENT_PLACE] != NO_ASCENT or plain[SPEED_PLACE] < ASTERN_SPEED

    def _left_undone(self, boat: Boat) -> set[str]:
        """Return what is given up, of GIVEN_UP_TEXTS."""
        plain, s = boat.plain, boat.state
        undone = set()
        if plain[ASCENT_PLACE] != NO_ASCENT:
            undone.add("afloat" if plain[ASCENT_PLACE] == ASCENT_AFLOAT else "emergency ascent")
        if (
            plain[SPEED_PLACE] < ASTERN_SPEED
            and plain[ASCENT_PLACE] == NO_ASCENT
            and boat.automatic
        ):
            slow = plain[SPEED_PLACE] > -LEAST_ASTERN or "astern" in self.given_up  # told once
            if slow and (s.stern_by_hand == 0.0 or s.bow_by_hand == 0.0):
                undone.add("astern")
        if plain[SPEED_SHORT_PLACE] > MIN_LACK_TIME_S:
            undone.add("speed not reached")
        if boat.time - self.trimmed > MIN_LACK_TIME_S:
            undone.add("trim short")
        if plain[HOVER_LOST_PLACE] != 0.0:
            undone.add("hover lost")
        return undone
