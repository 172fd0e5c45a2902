"""The periscope: its mast and optics, and the ships that are seen from its head.

``world`` has it in the boat's surroundings; stations, marks and debriefs see by it. How it stands
follows from the orders with their ticks alone. Refraction bends light round the earth: N. Bowditch,
American Practical Navigator (2019), tables 8 and 12, as a larger earth has it.
"""

import math
from bisect import bisect_right
from collections.abc import Callable, Iterable, Sequence
from operator import attrgetter
from typing import Any, Final, NamedTuple

import numpy as np

from trainer.boat.world.bottom import TICK_OFFSET
from trainer.boat.world.contact_fleet import ContactFleet, Ticks
from trainer.boat.world.contacts import ContactState, contacts_in
from trainer.config.boat.vessel_records import Scope
from trainer.config.world.world import WorldTables
from trainer.core.casualties import instruments
from trainer.core.kernel import Numbers
from trainer.core.sea.free_surface import height_above_water
from trainer.io.orders.grammar import Order, Refused, Reply
from trainer.units import KNOT

EARTH_RADIUS_M: Final = (
    6371e3 / 0.8279
)  # [m] radius of an earth round which light would be straight
ARC_MINUTE: Final = math.radians(1.0 / 60.0)
LOW_POWER: Final = 1.5  # [-] powers
HIGH_POWER: Final = 6.0  # [-] magnification
VIEW_WIDTHS: Final = {
    LOW_POWER: math.radians(32.0),
    HIGH_POWER: math.radians(8.0),
}  # [rad] width of the view
STADIMETER_STEPS: Final = {
    LOW_POWER: 2.0 * ARC_MINUTE,
    HIGH_POWER: 0.5 * ARC_MINUTE,
}  # [rad] of the stadimeter: estimate
OPTICS_SHOWING_M: Final = 0.5  # [m] out, below which the optics are in their well
NAUTICAL_MILE_M: Final = 1852.0  # [m]


class Mast(NamedTuple):
    """How mast and optics stand at a tick."""

    tick: int = 0
    up: bool = False
    out: float = 0.0  # [m]
    train: float = 0.0  # [rad] off the bow, clockwise
    power: float = LOW_POWER  # [-]
    raised: int = 0  # how often it has been ordered up


class Eye(NamedTuple):
    """The head of the periscope, as the point from which one looks.

    It has its location [m], its height over the waves, and the boat's heading [rad].
    """

    north: float
    east: float
    height: float
    heading: float


class Lamp(NamedTuple):
    """A light in sight: colour, off the ship's middle and over the horizontal [rad]."""

    colour: str
    beside: float
    elevation: float


class Sight(NamedTuple):
    """A ship as it is seen: angles [rad] alone are for everybody."""

    name: str
    type: str
    train: float  # off the bow, clockwise, -pi to pi
    bottom: float  # elevation of the waterline, or of the horizon before it
    top: float  # elevation of the masthead
    aspect: float  # off its bow, to starboard positive, of who looks
    span: float  # of its length, seen abeam
    lamps: tuple[Lamp, ...]
    distance: float  # [m] for the truth alone


def horizon_distance(eye: float) -> float:
    """Return the distance [m] of the horizon from a height [m]."""
    return math.sqrt(2.0 * EARTH_RADIUS_M * max(eye, 0.0))


def elevation(height: float, distance: float, eye: float) -> float:
    """Return the elevation [rad] of a height [m] at a distance [m]."""
    return (height - eye) / distance - distance / (2.0 * EARTH_RADIUS_M)


def hidden_height(distance: float, eye: float) -> float:
    """Return the height [m] that the horizon hides at a distance [m]."""
    beyond = max(distance - horizon_distance(eye), 0.0)
    return beyond * beyond / (2.0 * EARTH_RADIUS_M)


def hidden_heights(distances: Numbers, eyes: Numbers) -> Numbers:
    """Return the same for many distances [m] and heights [m] of the eye."""
    horizons = np.sqrt(2.0 * EARTH_RADIUS_M * np.maximum(eyes, 0.0))
    beyond = np.maximum(distances - horizons, 0.0)
    hidden: Numbers = beyond * beyond / (2.0 * EARTH_RADIUS_M)
    return hidden


def distance_in_sight(target: ContactState, eye: Eye) -> float | None:
    """Return how far [m] a ship is, at least 1.

    None: it is below the horizon, or the head is washed over.
    """
    distance = max(math.hypot(target.north - eye.north, target.east - eye.east), 1.0)
    if eye.height <= 0.0 or hidden_height(distance, eye.height) >= target.mast:
        return None
    return distance


def look_at(target: ContactState, eye: Eye) -> Sight | None:
    """Return how a ship is seen. None: it is below the horizon, or the head is washed over."""
    north, east = target.north - eye.north, target.east - eye.east
    distance = distance_in_sight(target, eye)
    if distance is None:
        return None
    bearing = math.atan2(east, north)
    aspect = math.remainder(bearing + math.pi - target.heading, math.tau)
    return Sight(
        name=target.name,
        type=target.type,
        train=math.remainder(bearing - eye.heading, math.tau),
        bottom=elevation(hidden_height(distance, eye.height), distance, eye.height),
        top=elevation(target.mast, distance, eye.height),
        aspect=aspect,
        span=target.length / distance,
        lamps=tuple(_lamps(target, aspect, distance, eye.height)),
        distance=distance,
    )


def _lamps(target: ContactState, aspect: float, distance: float, eye: float) -> Iterable[Lamp]:
    """Yield the lights that show: within their sector and range, over the horizon."""
    least = hidden_height(distance, eye)
    for light in target.lights:
        width, off = light.ends - light.begins, (aspect - light.begins) % math.tau
        shows = width >= math.tau or off <= width
        if shows and distance <= light.range_nm * NAUTICAL_MILE_M and light.height > least:
            beside = light.starboard * math.cos(aspect) - light.ahead * math.sin(aspect)
            yield Lamp(light.colour, -beside / distance, elevation(light.height, distance, eye))


def stadimeter_range(height: float, sight: Sight, power: float) -> float | None:
    """Return the distance [m] that a height [m] gives. None: its angle is too small.

    A stadimeter measures the angle between waterline and masthead, in its own steps.
    """
    step = STADIMETER_STEPS[power]
    steps = round((sight.top - sight.bottom) / step)
    return height / (steps * step) if steps else None


class Periscope:
    """The part of the world that the order ``scope`` is for."""

    def __init__(self, boat: Any, _tables: WorldTables) -> None:
        self._boat = boat
        self._fitted: Scope | None = boat.file.scope
        self._step: float = boat.method.step
        self._stood = [Mast()]
        self._shown: list[range] = []  # ticks at which the head was out of the water

    @property
    def fitted(self) -> Scope | None:
        """Return the vessel file's periscope, None for a boat without one."""
        return self._fitted

    @property
    def acts(self) -> bool:
        """Return whether the mast has been ordered up: it may show."""
        return self._stood[-1].raised > 0

    def stands(self, tick: int) -> bool:
        """Return whether the mast is down. One that is up is looked at in each tick."""
        mast = self.at(tick)
        return not mast.up and mast.out == 0.0

    def write(self, numbers: Any) -> None:
        """Write nothing; note that the head is out of the water.

        Marks count how long it has shown, since a head that shows is seen.
        """
        tick = int(numbers[TICK_OFFSET])
        while self._shown and self._shown[-1].start >= tick:
            self._shown.pop()
        goes_on = bool(self._shown) and self._shown[-1].stop >= tick
        begun = self._shown.pop().start if goes_on else tick
        mast = self.at(tick)
        until = tick + (mast.out > 0.0 and self.height(mast) > 0.0)
        if until > begun:
            self._shown.append(range(begun, until))

    def exposed(self, tick: int, *, raised: bool) -> float:
        """Return how long [s] the head has shown up to a tick.

        ``raised`` counts only since the mast was raised last.
        """
        since = self.raised_at(tick) if raised else 0
        ticks = (min(each.stop, tick + 1) - max(each.start, since) for each in self._shown)
        return sum(max(number, 0) for number in ticks) * self._step

    def raised_at(self, tick: int) -> int:
        """Return the tick at which the mast was ordered up last, else 0."""
        number = self.at(tick).raised
        return next((each.tick for each in self._stood if each.raised == number), 0)

    def forget(self) -> None:
        """Forget all orders: the mast is down, as at the start."""
        self._stood = [Mast()]

    def at(self, tick: int) -> Mast:
        """Return how the mast stands after so many ticks."""
        index = bisect_right(self._stood, tick, key=attrgetter("tick"))
        last = self._stood[max(index - 1, 0)]
        if self._fitted is None:
            return last
        rate = self._fitted.extension_m / self._fitted.raise_s
        way = rate * self._step * max(tick - last.tick, 0)
        out = last.out + way if last.up else last.out - way
        return last._replace(tick=tick, out=min(max(out, 0.0), self._fitted.extension_m))

    def over(self, ticks: Ticks) -> tuple[Numbers, Numbers]:
        """Return how far the mast is out [m] at ticks, and its number of raises."""
        stood = np.array([(each.tick, each.up, each.out, each.raised) for each in self._stood])
        indices = np.searchsorted(stood[:, 0], ticks, side="right") - 1
        begun, up, out, raised = stood[np.maximum(indices, 0)].T
        if self._fitted is None:
            return out, raised
        rate = self._fitted.extension_m / self._fitted.raise_s
        way = rate * self._step * np.maximum(ticks - begun, 0)
        out = np.where(up > 0.0, out + way, out - way)
        return np.clip(out, 0.0, self._fitted.extension_m), raised

    def raised(self, mast: Mast) -> Mast:
        """Return the mast as it stands once it is all out."""
        return mast._replace(out=self._fitted.extension_m if self._fitted else 0.0)

    def head(self, mast: Mast) -> tuple[float, float]:
        """Return where the head is [m], body axes x and z."""
        ahead = self._fitted.x_m if self._fitted else float(self._boat.vessel.x_sail)
        return ahead, float(self._boat.vessel.z_sail) - mast.out

    def height(self, mast: Mast) -> float:
        """Return the height [m] of the head over the waves now."""
        return float(height_above_water(self._boat.records.state, *self.head(mast)))

    def eye(self, s: Any, mast: Mast, height: float) -> Eye:
        """Return where the head is in a state, whose numbers have their names."""
        heading = float(s["psi"])
        ahead = self.head(mast)[0] * math.cos(float(s["theta"]))
        north, east = ahead * math.cos(heading), ahead * math.sin(heading)
        return Eye(float(s["x"]) + north, float(s["y"]) + east, height, heading)

    def sights(self, eye: Eye, mast: Mast) -> list[Sight]:
        """Return the ships in sight all round, the nearest first."""
        if mast.out < OPTICS_SHOWING_M:
            return []
        ships = ships_near(self._boat, mast.tick)
        seen = [sight for ship in ships if (sight := look_at(ship, eye))]
        return sorted(seen, key=attrgetter("distance"))

    def distances_in_sight(
        self, fleet: ContactFleet, ticks: Ticks, column: Callable[[str], Numbers], heights: Numbers
    ) -> Numbers:
        """Return how far [m] each ship of a fleet is at ticks, a row each.

        Infinity stands for a ship that is below the horizon. ``column`` has numbers of the states
        at these ticks by name, ``heights`` [m] are those of the head over the waves.
        """
        ahead = self.head(Mast())[0] * np.cos(column("theta"))
        north = column("x") + ahead * np.cos(column("psi"))
        east = column("y") + ahead * np.sin(column("psi"))
        now = fleet.over(ticks)
        apart = np.maximum(np.hypot(now.north - north, now.east - east), 1.0)
        masts = np.array([ship.type.mast for ship in fleet.order])[:, None]
        shows = (heights > 0.0) & (hidden_heights(apart, heights) < masts)
        return np.where(shows, apart, math.inf)

    def heights_over(self, column: Callable[[str], Numbers], out: Numbers | float) -> Numbers:
        """Return the heights [m] over the waves of a head that is ``out`` [m]."""
        x, foot = self.head(Mast())
        upright = np.cos(column("theta")) * np.cos(column("phi"))
        lifted = x * np.sin(column("theta")) - (foot - out) * upright
        return np.asarray(lifted - column("z") - column("eta_wave"))

    def near(self, s: Any, tick: int) -> list[tuple[str, float]]:
        """Return each ship at a tick and its true bearing [rad], seen or not."""
        return [
            (ship.name, math.atan2(ship.east - float(s["y"]), ship.north - float(s["x"])))
            for ship in ships_near(self._boat, tick)
        ]

    def obey(self, order: Order, tick: int) -> Reply:
        """Raise, lower or train it, change its power, or tell a distance."""
        if self._fitted is None:
            return Refused(f"{self._boat.file.path.name} has no periscope")
        now = self.at(tick)
        if order.word == "range":
            return self._range(order.value, now)
        then, answer = self._changed(order, now, self._fitted)
        if self._stood[-1].tick == tick:  # turned on and on: once a tick is enough
            self._stood.pop()
        self._stood.append(then)
        return answer

    def _changed(self, order: Order, now: Mast, fitted: Scope) -> tuple[Mast, str]:
        """Return how the mast stands by an order, and what is answered."""
        rate = fitted.extension_m / fitted.raise_s
        if order.word == "raise":
            seconds = (fitted.extension_m - now.out) / rate
            then = now._replace(up=True, raised=now.raised + (not now.up))
            why = self.too_fast(float(self._boat.state.u))
            return then, f"raising scope: up in {seconds:.0f} s{why and f'; {why}'}"
        if order.word == "lower":
            return now._replace(up=False), f"lowering scope: down in {now.out / rate:.0f} s"
        if order.word == "train":
            return now._replace(train=order.value), order.text
        power = LOW_POWER if order.word == "power_1.5" else HIGH_POWER
        field = math.degrees(VIEW_WIDTHS[power])
        return now._replace(power=power), f"power {power:g}: field {field:g} deg"

    def too_fast(self, speed: float) -> str:
        """Return the warning of a speed [m/s] too fast for the mast, or ""."""
        most, knots = self._fitted.speed_kn_max if self._fitted else math.inf, speed / KNOT
        return f"{knots:.1f} kn is too fast for it, {most:g} at most" if knots > most else ""

    def _range(self, height: float, mast: Mast) -> Reply:
        """Return the distance of the ship at the wire by the height of its masthead."""
        state = self._boat.records.state
        eye = self.eye(self._boat.state, mast, self.height(mast))
        half = 0.5 * VIEW_WIDTHS[mast.power]
        off = [
            (abs(math.remainder(target.train - mast.train, math.tau)), target)
            for target in self.sights(eye, mast)
        ]
        near = [pair for pair in off if pair[0] <= half]
        if not near:
            return Refused("nothing to measure: no ship in the view")
        if self.shakes(float(self._boat.state.u), mast):
            return Refused("the mast shakes: nothing can be measured")
        sight = min(near, key=lambda pair: pair[0])[1]
        distance = stadimeter_range(height, sight, mast.power)
        if distance is None:
            return Refused("too small to measure: come nearer, or take power 6")
        instruments(state, self._boat.records.scratch)
        heading = float(self._boat.records.scratch["reading"][0][1])
        where = round(math.degrees(heading + sight.train)) % 360
        return f"bearing {where:03d}: {height:g} m high, range {distance:.0f} m"

    def shakes(self, speed: float, mast: Mast) -> bool:
        """Return whether the mast is out at a speed [m/s] that it does not stand."""
        most = self._fitted.speed_kn_max * KNOT if self._fitted else math.inf
        return mast.out >= OPTICS_SHOWING_M and speed > most


def periscope_of(boat: Any) -> Periscope | None:
    """Return a boat's periscope, None where it has none."""
    periscope = boat.world.parts.get("scope")
    return periscope if isinstance(periscope, Periscope) and periscope.fitted else None


def eye_height(boat: Any) -> float:
    """Return the height [m] of the head over the waves now. NaN for a boat without one."""
    scope = periscope_of(boat)
    return scope.height(scope.at(boat.ticks)) if scope else math.nan


def ships_near(boat: Any, tick: int) -> Sequence[ContactState]:
    """Return the ships near a boat at a tick, none where the exercise has none."""
    contacts = contacts_in(boat)
    return contacts.seen(tick) if contacts else ()
