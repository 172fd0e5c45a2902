"""The calls that tell the crew what the autopilot or an X-tail cannot do.

A session looks after each tick. The core's autopilot gives up a law without a word, such as depth
by the planes at too low a speed; the crew would find out only by the gauge.
"""

import math
from dataclasses import dataclass, field
from typing import Final

import numpy as np

from trainer.boat.boat import STATE_OFFSETS, Boat
from trainer.boat.calls import MonitorCall, Rank
from trainer.boat.casualties import active_casualties, kind_row
from trainer.boat.flown_ticks import FlownTicks, Mask, count_before
from trainer.core.autopilot.ascent import (
    ASCENT_AFLOAT,
    ASCENT_RISING,
    EMERGENCY_OPENING,
    NO_ASCENT,
)
from trainer.core.autopilot.depth import LEAST_ASTERN
from trainer.core.autopilot.speed import PROPELLER_SLACK
from trainer.core.autopilot.steering import ASTERN_SPEED
from trainer.core.ballast.tanks import (
    AUXILIARY_TANK,
    NEGATIVE_TANK,
    TANKS,
    TRIM_AFT,
    TRIM_FORWARD,
)
from trainer.core.envelope import (
    AHEAD,
    ASTERN,
    BY_FLOW_FLOW,
    BY_N_FLOW,
    BY_N_N,
    STOPPING,
)
from trainer.core.kernel import Numbers
from trainer.units import KNOT

MIN_LACK_TIME_S: Final = 60.0  # [s] without speed, or water to trim, before it is called
GIVEN_UP_TEXTS: Final = {  # the laws that the autopilot gives up, and the call of each
    "emergency ascent": "emergency ascent: bow up, the after group held back; no depth is kept",
    "afloat": "afloat: no depth is kept until one is ordered",
    "astern": f"going astern slower than {LEAST_ASTERN / KNOT:.0f} kn: planes amidships, depth is "
    "not kept",
    "swinging": "going astern, the rudder does not stop her swing: no course is kept; go ahead",
    "hover lost": "hovering is given up: the pump cannot hold this depth; the planes have it",
    "trim short": "automatic trim has no more water or room in a tank: planes carry the rest",
    "speed not reached": "the engine gives all it has, and the ordered speed is not reached",
}
# what follows from an order that was given, and asks nobody to do anything
REMARK_NAMES: Final = ("afloat",)
ASCENT_OFFSET, SPEED_OFFSET = STATE_OFFSETS["ascent"], STATE_OFFSETS["u"]
PSI_OFFSET, ORDERED_PSI_OFFSET = STATE_OFFSETS["psi"], STATE_OFFSETS["ordered_psi"]
ANSWER_OFFSET, U_C_OFFSET = STATE_OFFSETS["telegraph_answer"], STATE_OFFSETS["u_c"]
SPEED_SHORT_OFFSET, HOVER_LOST_OFFSET = STATE_OFFSETS["speed_short"], STATE_OFFSETS["hover_lost"]
TRIM_FLOOD_OFFSET, TRIM_FORWARD_OFFSET = STATE_OFFSETS["trim_flood"], STATE_OFFSETS["trim_forward"]
LIMIT_MARGIN: Final = math.radians(0.5)  # [rad] short of the limit that rudder and planes share
MIN_LACK_ANGLE: Final = math.radians(3.0)  # [rad] lacking of an order, before it is called
LACK_RECALL_S: Final = 30.0  # [s] with all that is ordered, before a lack is news again
SHARED_SURFACES: Final = {  # of an X-tail: in words, where it stands and where it is ordered to
    "rudder": ("rudder has", STATE_OFFSETS["delta_r"], STATE_OFFSETS["command_r"]),
    "stern": ("stern planes have", STATE_OFFSETS["delta_s"], STATE_OFFSETS["command_s"]),
}


def lacks_water(boat: Boat) -> bool:
    """Return whether automatic trim asks for water or room that is not there."""
    flood, forward = boat.plain[TRIM_FLOOD_OFFSET], boat.plain[TRIM_FORWARD_OFFSET]
    if flood == 0.0 and forward == 0.0:
        return False
    water, capacity = boat.state.water, boat.vessel.capacity
    # Water is moved between the trim tanks; the auxiliary tank takes it from the sea or gives it.
    first, last = (TRIM_AFT, TRIM_FORWARD) if forward > 0.0 else (TRIM_FORWARD, TRIM_AFT)
    moved = forward != 0.0 and (water[first] <= 0.0 or water[last] >= capacity[last])
    end = capacity[AUXILIARY_TANK] if flood > 0.0 else 0.0
    return bool(moved or (flood != 0.0 and water[AUXILIARY_TANK] == end))


def lacked_water(boat: Boat, flown: FlownTicks) -> Mask:
    """Return at which ticks trim lacked water or room, as ``lacks_water`` says of one."""
    flood, forward = flown["trim_flood"], flown["trim_forward"]
    water, capacity = flown.block("water", len(TANKS)).T, boat.vessel.capacity
    ahead = forward > 0.0
    first = np.where(ahead, water[TRIM_AFT], water[TRIM_FORWARD])
    room = np.where(
        ahead,
        capacity[TRIM_FORWARD] - water[TRIM_FORWARD],
        capacity[TRIM_AFT] - water[TRIM_AFT],
    )
    moved = (forward != 0.0) & ((first <= 0.0) | (room <= 0.0))
    end = np.where(flood > 0.0, capacity[AUXILIARY_TANK], 0.0)
    lacked: Mask = moved | ((flood != 0.0) & (water[AUXILIARY_TANK] == end))
    return lacked


def engine_limit(boat: Boat) -> str:
    """Return what keeps the engine from the revolutions ordered, "torque" or "power"; "": nothing.

    It is asked as soon as the engine room acts on an order: revolutions come after, by their lag.
    """
    c, plain = boat.vessel, boat.plain
    answer, u = plain[ANSWER_OFFSET], plain[SPEED_OFFSET]
    driving = answer > max(u, 0.0) or answer < min(u, 0.0)
    if c.torque_limit == 0.0 or not driving or abs(answer - plain[U_C_OFFSET]) <= PROPELLER_SLACK:
        return ""
    way = AHEAD if answer > 0.0 else STOPPING if u >= 0.0 else ASTERN
    flow, n = (max(u, 0.0) if answer > 0.0 else abs(u)) / c.screw, abs(answer) * c.turns
    q = c.torque[way]
    torque = n * (n * q[BY_N_N] + flow * q[BY_N_FLOW]) + flow * flow * q[BY_FLOW_FLOW]
    if torque > c.torque_limit:
        return "torque"
    return "power" if 0.0 < c.power_limit < n * torque else ""


def was_limited(boat: Boat, flown: FlownTicks) -> Mask:
    """Return at which ticks the engine was limited, as ``engine_limit`` says of one."""
    c, answer, u = boat.vessel, flown["telegraph_answer"], flown["u"]
    driving = (answer > np.maximum(u, 0.0)) | (answer < np.minimum(u, 0.0))
    driving &= np.abs(answer - flown["u_c"]) > PROPELLER_SLACK
    ahead = answer > 0.0
    q = c.torque[np.where(ahead, AHEAD, np.where(u >= 0.0, STOPPING, ASTERN))].T
    flow, n = np.where(ahead, np.maximum(u, 0.0), np.abs(u)) / c.screw, np.abs(answer) * c.turns
    torque = n * (n * q[BY_N_N] + flow * q[BY_N_FLOW]) + flow * flow * q[BY_FLOW_FLOW]
    power = (c.power_limit > 0.0) & (c.power_limit < n * torque)
    limited: Mask = driving & ((torque > c.torque_limit) | power)
    return limited


def is_broken(boat: Boat, surface: str) -> bool:
    """Return whether a casualty acts on a surface."""
    return any(kind_row(each.kind).equipment == surface for each in active_casualties(boat))


@dataclass
class TailMonitor:
    """The watch on what rudder and stern planes of an X-tail lack.

    A surface that is broken is not looked at: its order tells nothing of the sharing.
    """

    lacking: dict[str, float] = field(default_factory=dict)  # [s] when each was last seen to

    def holding(self, now: float) -> set[str]:
        """Return the keys of the alerts called that hold still at a time [s]."""
        lately = (name for name, last in self.lacking.items() if now - last <= LACK_RECALL_S)
        return {f"{name} short on the X-tail" for name in lately}

    def may_lack(self, boat: Boat, flown: FlownTicks) -> Mask:
        """Return at which ticks the surfaces stand so far that one may lack something."""
        c = boat.vessel
        total = np.abs(flown["delta_r"]) + np.abs(flown["delta_s"])
        mask: Mask = (total >= c.limit_s - LIMIT_MARGIN) & (c.x_tail != 0.0)
        return mask

    def look(self, boat: Boat) -> list[tuple[str, str]]:
        """Return what there is to say after a tick, by names for the account."""
        c, plain = boat.vessel, boat.plain
        total = sum(abs(plain[offset]) for _, offset, _ in SHARED_SURFACES.values())
        if c.x_tail == 0.0 or total < c.limit_s - LIMIT_MARGIN:
            return []
        news = []
        for name, (has, offset, command) in SHARED_SURFACES.items():
            stands, ordered = abs(plain[offset]), abs(plain[command])
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
class EngineMonitor:
    """The watch on an engine that cannot turn what is ordered."""

    limited: float = -math.inf  # [s] when it was so last
    stands: bool = False  # it was so within LACK_RECALL_S

    def may_lack(self, boat: Boat, flown: FlownTicks) -> Mask:
        """Return at which ticks there is something to say."""
        if boat.vessel.torque_limit == 0.0:
            return np.zeros(len(flown), np.bool_)
        limited = was_limited(boat, flown)
        before = np.append(self.limited, np.where(limited, flown.times, -math.inf)[:-1])
        again: Mask = flown.times - np.maximum.accumulate(before) > LACK_RECALL_S
        return again & (limited | self.stands)

    def pass_over(self, boat: Boat, flown: FlownTicks) -> None:
        """Take these ticks as seen, in which there was nothing to say."""
        if boat.vessel.torque_limit != 0.0 and (limited := was_limited(boat, flown)).any():
            self.limited = float(flown.times[limited][-1])

    def look(self, boat: Boat) -> list[tuple[str, str]]:
        """Return what there is to say after a tick, by names for the account."""
        limit = engine_limit(boat)
        self.stands = bool(limit) or boat.time - self.limited <= LACK_RECALL_S
        if not limit:
            return []
        last, self.limited = self.limited, boat.time
        if boat.time - last <= LACK_RECALL_S:
            return []
        ordered = boat.plain[ANSWER_OFFSET] * boat.file.propulsion.rps_per_mps * 60.0
        words = f"ENGINE: limited by {limit}, short of the {ordered:.0f} rpm ordered"
        return [(f"engine limited by {limit}", words)]


@dataclass
class PilotMonitor:
    """The laws given up at present, and the times [s] at which laws were."""

    given_up: set[str] = field(default_factory=set)
    times: dict[str, list[float]] = field(default_factory=dict)  # [s]
    rising: bool = False  # in an emergency, or to surface, which is ordered and needs no call
    trimmed: float = 0.0  # [s] when tanks last had what automatic trim asks for
    tail: TailMonitor = field(default_factory=TailMonitor)
    engine: EngineMonitor = field(default_factory=EngineMonitor)

    @classmethod
    def over(cls, boat: Boat) -> "PilotMonitor":
        """Return the watch over a boat; what is given up now is no news."""
        monitor = cls()
        monitor.reset_to(boat)
        return monitor

    def reset_to(self, boat: Boat) -> None:
        """Take the boat as it is. Nothing of it is news."""
        self.trimmed = boat.time
        self.given_up = self._left_undone(boat) if self._is_unusual(boat) else set()
        self.rising = boat.plain[ASCENT_OFFSET] == ASCENT_RISING
        self.tail.lacking.clear()
        self.tail.look(boat)
        self.engine = EngineMonitor()
        self.engine.look(boat)

    def look(self, boat: Boat) -> list[MonitorCall]:
        """Return what there is to say after a tick."""
        shared = self.tail.look(boat) + self.engine.look(boat)
        for name, _ in shared:
            self.times.setdefault(name, []).append(boat.time)
        calls = [
            MonitorCall(words, Rank.WARNING, name.partition(" by ")[0]) for name, words in shared
        ]
        calls += self._news(boat)
        if not calls:
            return []
        now = f"tick {boat.ticks} ({boat.time:g} s)"
        return [call._replace(text=f"{now}: {call.text}") for call in calls]

    def holding(self, now: float) -> set[str]:
        """Return the keys of the alerts called that hold still at a time [s]."""
        engine = {"engine limited"} if self.engine.stands else set()
        return self.given_up | self.tail.holding(now) | engine

    def quiet_ticks(self, boat: Boat, flown: FlownTicks) -> int:
        """Return after how many ticks there may be something to call, or all of them."""
        begun = float(flown.times[0]) - boat.method.step if len(flown) else boat.time
        if self.given_up or self.rising or self.tail.holding(begun):
            return 0
        mask = flown["hover_lost"] != 0.0
        mask |= (flown["speed_short"] > MIN_LACK_TIME_S) | (flown["ascent"] != NO_ASCENT)
        mask |= (flown["u"] < ASTERN_SPEED) | self.tail.may_lack(boat, flown)
        mask |= self.engine.may_lack(boat, flown)
        mask |= (flown["u"] < 0.0) & (np.abs(flown["psi"] - flown["ordered_psi"]) > math.tau)
        mask |= flown.times - self._trimmed_at(boat, flown) > MIN_LACK_TIME_S
        return count_before(mask)

    def pass_over(self, boat: Boat, flown: FlownTicks) -> None:
        """Take these ticks as seen, in which there was nothing to call."""
        self.trimmed = float(self._trimmed_at(boat, flown)[-1])
        self.engine.pass_over(boat, flown)

    def _trimmed_at(self, boat: Boat, flown: FlownTicks) -> Numbers:
        """Return for each tick when [s] tanks last had what automatic trim asks for."""
        since = np.where(lacked_water(boat, flown), self.trimmed, flown.times)
        return np.maximum.accumulate(since)

    def _news(self, boat: Boat) -> list[MonitorCall]:
        """Return what the autopilot has newly given up, or has again."""
        if not lacks_water(boat):
            self.trimmed = boat.time
        rose, self.rising = self.rising, boat.plain[ASCENT_OFFSET] == ASCENT_RISING
        if not (self.given_up or rose or self._is_unusual(boat)):
            return []
        now = self._left_undone(boat)
        calls = []
        for name in sorted(now - self.given_up):
            rank = Rank.CAUTION if name in REMARK_NAMES else Rank.WARNING
            calls.append(MonitorCall(f"autopilot: {GIVEN_UP_TEXTS[name]}", rank, name))
            self.times.setdefault(name, []).append(boat.time)
        if rose and boat.plain[ASCENT_OFFSET] == NO_ASCENT:
            s, over = boat.state, "autopilot: the ascent is over"
            if s.hover or not (s.stern_by_hand and s.bow_by_hand):
                over += f": keeping depth {round(float(s.ordered_depth), 1):g} m"
            calls.append(MonitorCall(over, Rank.CAUTION))
        self.given_up = now
        return calls

    def _is_unusual(self, boat: Boat) -> bool:
        """Return whether anything could be given up."""
        plain = boat.plain
        lost = plain[HOVER_LOST_OFFSET] != 0.0 or plain[SPEED_SHORT_OFFSET] > MIN_LACK_TIME_S
        lost = lost or boat.time - self.trimmed > MIN_LACK_TIME_S
        lost = lost or plain[ASCENT_OFFSET] != NO_ASCENT or plain[SPEED_OFFSET] < ASTERN_SPEED
        return lost or self._swings(boat)

    def _swings(self, boat: Boat) -> bool:
        """Return whether the boat is more than a turn off her course, going astern."""
        plain = boat.plain
        off = abs(plain[PSI_OFFSET] - plain[ORDERED_PSI_OFFSET])
        return bool(plain[SPEED_OFFSET] < 0.0 and off > math.tau)

    def _left_undone(self, boat: Boat) -> set[str]:
        """Return what is given up, of GIVEN_UP_TEXTS."""
        plain, s = boat.plain, boat.state
        undone = set()
        if plain[ASCENT_OFFSET] == ASCENT_AFLOAT:
            undone.add("afloat")
        elif plain[ASCENT_OFFSET] == ASCENT_RISING:
            blown = EMERGENCY_OPENING in s.blow[:NEGATIVE_TANK]  # main ballast
            undone |= {"emergency ascent"} if blown else self.given_up & {"emergency ascent"}
        if (
            plain[SPEED_OFFSET] < ASTERN_SPEED
            and plain[ASCENT_OFFSET] == NO_ASCENT
            and boat.automatic
        ):
            # Once called it holds at any speed astern, so that it is not called again and again.
            slow = plain[SPEED_OFFSET] > -LEAST_ASTERN or "astern" in self.given_up
            if slow and (s.stern_by_hand == 0.0 or s.bow_by_hand == 0.0):
                undone.add("astern")
        if self._swings(boat) and s.rudder_by_hand == 0.0:
            undone.add("swinging")
        if plain[SPEED_SHORT_OFFSET] > MIN_LACK_TIME_S:
            undone.add("speed not reached")
        if boat.time - self.trimmed > MIN_LACK_TIME_S:
            undone.add("trim short")
        if plain[HOVER_LOST_OFFSET] != 0.0:
            undone.add("hover lost")
        return undone
