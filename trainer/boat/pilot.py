"""The crew is told what the autopilot and an X-tail do not give."""

import math
from dataclasses import dataclass, field
from typing import Final

from trainer.boat.boat import PLACES, Boat
from trainer.boat.casualties import active
from trainer.core.autopilot.ascent import AFLOAT, NONE
from trainer.core.autopilot.depth import LEAST_ASTERN
from trainer.core.autopilot.steering import ASTERN
from trainer.core.ballast.tanks import AUXILIARY, TRIM_AFT, TRIM_FORWARD
from trainer.units import KNOT

LACKING: Final = 60.0  # [s] of the engine at its most before that is told
GIVEN_UP: Final = {  # what is not kept, and why
    "emergency ascent": "emergency ascent: bow up, the after group held back; no depth is kept",
    "afloat": "afloat: no depth is kept until one is ordered",
    "astern": f"going astern slower than {LEAST_ASTERN / KNOT:.0f} kn: planes amidships, depth is "
    "for the tanks",
    "hover lost": "hovering is given up: the pump cannot hold this depth; the planes have it",
    "trim short": "automatic trim has no more water or room in a tank: planes carry the rest",
    "speed not reached": "the engine gives all it has, and the ordered speed is not reached",
}
ASCENT, SPEED = PLACES["ascent"], PLACES["u"]
SHORT, LOST = PLACES["speed_short"], PLACES["hover_lost"]
FLOOD, FORWARD = PLACES["trim_flood"], PLACES["trim_forward"]
TOUCHING: Final = math.radians(0.5)  # [rad] short of the limit that rudder and planes share
TAKEN: Final = math.radians(3.0)  # [rad] of an order that is not given, to be told
SETTLED: Final = 30.0  # [s] with all that is ordered, before a lack is news again
SHARING: Final = {  # of an X-tail: in words, where it stands and where it is ordered to
    "rudder": ("rudder has", PLACES["delta_r"], PLACES["command_r"]),
    "stern": ("stern planes have", PLACES["delta_s"], PLACES["command_s"]),
}


def lacks_water(boat: Boat) -> bool:
    """Return whether automatic trim asks for water or room that is not there."""
    flood, forward = boat.plain[FLOOD], boat.plain[FORWARD]
    if flood == 0.0 and forward == 0.0:
        return False
    water, capacity = boat.state.water, boat.vessel.capacity
    first, last = (TRIM_AFT, TRIM_FORWARD) if forward > 0.0 else (TRIM_FORWARD, TRIM_AFT)
    moved = forward != 0.0 and (water[first] <= 0.0 or water[last] >= capacity[last])
    end = capacity[AUXILIARY] if flood > 0.0 else 0.0
    return bool(moved or (flood != 0.0 and water[AUXILIARY] == end))


def is_broken(boat: Boat, surface: str) -> bool:
    """Return whether a casualty acts on a surface."""
    return any(each.kind.startswith(f"{surface}-") for each in active(boat))


@dataclass
class TailMonitor:
    """The watch on what rudder and stern planes of an X-tail lack.

    A surface that is broken is not looked at: its order tells nothing of the sharing.
    """

    lacking: dict[str, float] = field(default_factory=dict)  # [s] when each was last seen to

    def look(self, boat: Boat) -> list[tuple[str, str]]:
        """Return what there is to say after a tick, by names for the account."""
        c, plain = boat.vessel, boat.plain
        given = sum(abs(plain[place]) for _, place, _ in SHARING.values())
        if c.x_tail == 0.0 or given < c.limit_s - TOUCHING:
            return []
        news = []
        for name, (has, place, command) in SHARING.items():
            stands, asked = abs(plain[place]), abs(plain[command])
            if asked - stands <= TAKEN or is_broken(boat, name):
                continue
            last = self.lacking.get(name, -math.inf)
            self.lacking[name] = boat.time
            if boat.time - last > SETTLED:
                told = f"{math.degrees(stands):.0f} of {math.degrees(asked):.0f} deg"
                words = f"X-TAIL: the {has} {told}: rudder and stern planes share the fins"
                news.append((f"{name} short on the X-tail", words))
        return news


@dataclass
class PilotMonitor:
    """The laws that are given up at present, each with the time of that."""

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
        news = [GIVEN_UP[name] for name in sorted(now - self.given_up)]
        for name in now - self.given_up:
            self.times.setdefault(name, []).append(boat.time)
        if "emergency ascent" in self.given_up and boat.plain[ASCENT] == NONE:
            news.append(f"the ascent is over: keeping depth {boat.state.ordered_depth:.0f} m")
        self.given_up = now
        return news

    def _is_unusual(self, boat: Boat) -> bool:
        """Return whether anything could be given up."""
        plain = boat.plain
        lost = plain[LOST] != 0.0 or plain[SHORT] > LACKING
        lost = lost or boat.time - self.trimmed > LACKING
        return lost or plain[ASCENT] != NONE or plain[SPEED] < ASTERN

    def _left_undone(self, boat: Boat) -> set[str]:
        """Return what is given up, of GIVEN_UP."""
        plain, s = boat.plain, boat.state
        found = set()
        if plain[ASCENT] != NONE:
            found.add("afloat" if plain[ASCENT] == AFLOAT else "emergency ascent")
        if plain[SPEED] < ASTERN and plain[ASCENT] == NONE and boat.automatic:
            slow = plain[SPEED] > -LEAST_ASTERN or "astern" in self.given_up  # told once
            if slow and (s.stern_by_hand == 0.0 or s.bow_by_hand == 0.0):
                found.add("astern")
        if plain[SHORT] > LACKING:
            found.add("speed not reached")
        if boat.time - self.trimmed > LACKING:
            found.add("trim short")
        if plain[LOST] != 0.0:
            found.add("hover lost")
        return found
