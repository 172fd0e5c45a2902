"""The alerts of a boat's plant: oil, buses, overload, smoke, and the battery.

A session asks ``PlantMonitor.look`` after each tick, and announces the calls. Each alert watches a
number, which has one bound where it begins and another where it is over, so that it does not come
and go. Most are numbers of the state, and only a plant that was touched changes them. The battery
is drained all the time, so ``BatteryWatch`` looks at it whenever the core has drained it.
"""

import math
from collections import deque
from collections.abc import Collection, Iterator
from copy import copy
from dataclasses import dataclass, field
from typing import Any, Final, NamedTuple

import numpy as np

from trainer.boat.boat import STATE_OFFSETS, TICK_OFFSET, Boat
from trainer.boat.calls import MonitorCall, Rank
from trainer.boat.flown_ticks import FlownTicks, Mask, count_before
from trainer.core.plant.parts import BUS_NAMES, MAIN, OIL_SYSTEMS, PLACE_NAMES
from trainer.core.plant.plant import CALM_TICKS
from trainer.core.readings import new_readings, write_readings
from trainer.core.state import new_scratch

MEGAPASCAL: Final = 1e6  # [Pa]
LOW_MPA, WHOLE_MPA = 16.0, 18.0  # [MPa] oil is low below, and no more from here on; estimates
HALF_TANK, REFILLED_TANK = 0.5, 0.6  # [-]
SEEN_SMOKE, THIN_SMOKE = 0.05, 0.02  # [-] estimates
OIL_LOW, TANK_HALF, MAIN_LOST = "oil low", "oil tank half", "main oil lost"  # names of alerts
BUS_LOST, OVERLOAD, FIRE = "bus lost", "overload", "fire"
BATTERY_LOW, BATTERY_FLAT = "battery low", "battery nearly flat"
PLANT_RANKS: Final = {
    MAIN_LOST: Rank.ALARM,
    FIRE: Rank.ALARM,
    OVERLOAD: Rank.ALARM,
    BUS_LOST: Rank.ALARM,
    BATTERY_FLAT: Rank.ALARM,
    BATTERY_LOW: Rank.WARNING,
    OIL_LOW: Rank.WARNING,
    TANK_HALF: Rank.WARNING,
}
TOUCHED_OFFSET: Final = STATE_OFFSETS["plant_touched"]
SPENT_OFFSET, CELLS_OFFSET = STATE_OFFSETS["battery_spent"], STATE_OFFSETS["cells_gone"]
DRAW_TIME_S: Final = 60.0  # [s] over which the battery's draw is the mean


class Reserve(NamedTuple):
    """What is left of a battery, and for how long at its draw."""

    charge: float  # [-]
    minutes: float

    def lies_below(self, other: "Reserve") -> bool:
        """Return whether there is less of one of both."""
        return self.charge < other.charge or self.minutes < other.minutes


# where each begins, and where it is over
BATTERY_BOUNDS: Final = {
    BATTERY_LOW: (Reserve(0.40, 60.0), Reserve(0.45, 75.0)),
    BATTERY_FLAT: (Reserve(0.20, 20.0), Reserve(0.25, 30.0)),
}


@dataclass(frozen=True)
class NamedAlert:
    """An alert of the plant, and its words."""

    name: str
    part: str  # of the plant, "" where there is one
    words: str

    @property
    def key(self) -> str:
        """Return the key, with the part after a colon."""
        return f"{self.name}:{self.part}" if self.part else self.name

    @property
    def call(self) -> MonitorCall:
        """Return what is called."""
        return MonitorCall(self.words, PLANT_RANKS[self.name], self.key)


@dataclass(frozen=True)
class PlantAlert(NamedAlert):
    """An alert by a number of the state."""

    offset: int  # in the state
    begins: float  # above this
    ends: float  # at this or below
    sign: float = 1.0  # of the number

    def turns(self, number: Any, *, holds: bool) -> Any:
        """Return whether a number, or each of many, has it begin or end."""
        value = self.sign * number
        return value <= self.ends if holds else value > self.begins


@dataclass(frozen=True)
class BatteryAlert(NamedAlert):
    """An alert by what the battery has left."""

    begins: Reserve  # below one of both
    ends: Reserve  # not below any

    def turns(self, reserve: Reserve, *, holds: bool) -> bool:
        """Return whether the reserve has it begin or end."""
        return not reserve.lies_below(self.ends) if holds else reserve.lies_below(self.begins)


def oil_out(boat: Boat, system: int, pressure: float) -> float:
    """Return the oil [m3] out of an accumulator at a pressure [Pa].

    By Boyle's law.
    """
    c = boat.vessel
    full, low = float(c.oil_full[system]), float(c.oil_low[system])
    gas = low * float(c.oil_usable[system]) / (full - low)
    return min(gas * (full / pressure - 1.0), float(c.oil_usable[system]))


def plant_alerts(boat: Boat) -> Iterator[PlantAlert]:
    """Yield the alerts of a boat's plant, none where it has none."""
    if boat.file.plant is None:
        return
    c = boat.vessel
    for system, name in enumerate(OIL_SYSTEMS):
        spent = STATE_OFFSETS["oil_spent"] + system
        low, whole = (oil_out(boat, system, MEGAPASCAL * p) for p in (LOW_MPA, WHOLE_MPA))
        words = f"OIL LOW: {name} below {LOW_MPA:g} MPa"
        yield PlantAlert(OIL_LOW, name, words, spent, low, whole)
        held, tank = float(c.oil_reserve[system]), STATE_OFFSETS["tank_gain"] + system
        half, refilled = (held * (1.0 - share) for share in (HALF_TANK, REFILLED_TANK))
        words = f"OIL TANK: {name} less than half full"
        yield PlantAlert(TANK_HALF, name, words, tank, half, refilled, -1.0)
    dead, rated = (oil_out(boat, MAIN, float(p)) for p in (c.oil_dead, c.oil_rated))
    words = "MAIN OIL LOST: what is in normal stands still"
    # where the tick has let all out, rounding may leave a drop
    least = dead - 1e-9 * float(c.oil_usable[MAIN])
    yield PlantAlert(MAIN_LOST, "", words, STATE_OFFSETS["oil_spent"] + MAIN, least, rated)
    for bus, name in enumerate(BUS_NAMES):
        offset = STATE_OFFSETS["bus_dead"] + bus
        yield PlantAlert(BUS_LOST, name, f"BUS LOST: {name}", offset, 0.0, 0.0)
    words = f"OVERLOAD: a breaker opens in {float(c.overload_time):g} s"
    yield PlantAlert(OVERLOAD, "", words, STATE_OFFSETS["overload"], 0.0, 0.0)
    for place, name in enumerate(PLACE_NAMES):
        offset = STATE_OFFSETS["smoke"] + place
        yield PlantAlert(FIRE, name, f"FIRE: smoke {name}", offset, SEEN_SMOKE, THIN_SMOKE)


def battery_alerts() -> Iterator[BatteryAlert]:
    """Yield the alerts of a battery."""
    for name, (begins, ends) in BATTERY_BOUNDS.items():
        bounds = f"below {100.0 * begins.charge:g} %, or less than {begins.minutes:g} min"
        yield BatteryAlert(name, "", f"{name.upper()}: {bounds} at this draw", begins, ends)


def power_drawn(boat: Boat) -> float:
    """Return what drains a boat's battery now [W], its own losses included."""
    c, readings = boat.vessel, new_readings()
    write_readings(boat.records.vessel, boat.records.state, new_scratch(), readings)
    speed = float(boat.state.u_c / c.screw_speed)
    power = float(c.screw_power) * abs(speed) ** 3 + float(readings[0].bus_load.sum())
    return power * (1.0 + power / float(c.cell_power))


class BatteryWatch:
    """The watch on a battery, after each tick that drains it while all is well.

    Of the time before it began, it takes the draw of that moment for the last minute's.
    """

    def __init__(self, boat: Boat) -> None:
        self._full, self._interval = float(boat.vessel.battery_full), CALM_TICKS * boat.method.step
        looks = max(round(DRAW_TIME_S / self._interval), 1)
        self._draws: deque[float] = deque([power_drawn(boat)], looks)  # [W] from look to look
        self._seen: tuple[float, float] | None = None  # [J] spent, [-] of cells, at the last look

    def another(self) -> "BatteryWatch":
        """Return a copy, which may look ahead."""
        watch = copy(self)
        watch._draws = self._draws.copy()  # noqa: SLF001  its own kind
        return watch

    @staticmethod
    def due(ticks: Any) -> Any:
        """Return whether, or at which of many ticks, it is looked at."""
        return ticks % CALM_TICKS == 1.0

    def take(self, numbers: Any) -> None:
        """Take the numbers of a state when it is due. What went with lost cells is no draw."""
        spent, gone = float(numbers[SPENT_OFFSET]), float(numbers[CELLS_OFFSET])
        if self._seen and self._seen[1] == gone:
            self._draws.append((spent - self._seen[0]) / self._interval)
        self._seen = spent, gone

    def reserve(self, numbers: Any) -> Reserve:
        """Return what is left by the numbers of a state."""
        left = self._full - float(numbers[SPENT_OFFSET])
        draw = math.fsum(self._draws) / len(self._draws)
        return Reserve(left / self._full, left / draw / 60.0 if draw > 0.0 else math.inf)


@dataclass
class PlantMonitor:
    """The watch on a plant: which alerts hold, and when each was called."""

    alerts: tuple[PlantAlert, ...] = ()
    battery_alerts: tuple[BatteryAlert, ...] = ()
    battery: BatteryWatch = field(init=False)  # where there is one
    holding: set[str] = field(default_factory=set)  # keys of the alerts called that hold still
    times: dict[str, list[float]] = field(default_factory=dict)  # [s]

    @classmethod
    def over(cls, boat: Boat) -> "PlantMonitor":
        """Return the watch over a boat; what holds now is no news."""
        of_battery = battery_alerts() if boat.has_plant else ()
        monitor = cls(tuple(plant_alerts(boat)), tuple(of_battery))
        monitor.reset_to(boat)
        return monitor

    def reset_to(self, boat: Boat) -> None:
        """Take the boat as it is. Nothing of it is news."""
        if self.battery_alerts:
            self.battery = BatteryWatch(boat)
            self._turn(self._turning(self.battery.reserve(boat.plain)))
        self._turn(self._touched(boat))

    def look(self, boat: Boat) -> list[MonitorCall]:
        """Return what there is to call out after a tick."""
        news: list[NamedAlert] = []
        if boat.plain[TOUCHED_OFFSET] or self.holding:
            news += self._turn(self._touched(boat))
        if self.battery_alerts and BatteryWatch.due(boat.plain[TICK_OFFSET]):
            self.battery.take(boat.plain)
            news += self._turn(self._turning(self.battery.reserve(boat.plain)))
        for alert in news:
            self.times.setdefault(alert.key, []).append(boat.time)
        tick = f"tick {boat.ticks} ({boat.time:g} s)"
        return [alert.call._replace(text=f"{tick}: {alert.words}") for alert in news]

    def quiet_ticks(self, _boat: Boat, flown: FlownTicks) -> int:
        """Return after how many ticks there may be something to call, or all of them."""
        mask: Mask = np.zeros(len(flown), np.bool_)
        for alert in self.alerts:
            mask |= alert.turns(flown.rows[:, alert.offset], holds=alert.key in self.holding)
        quiet = count_before(mask)
        if self.battery_alerts:
            watch = self.battery.another()
            for i in np.flatnonzero(BatteryWatch.due(flown.ticks[:quiet])).tolist():
                watch.take(flown.rows[i])
                if self._turning(watch.reserve(flown.rows[i])):
                    return int(i)
        return quiet

    def pass_over(self, _boat: Boat, flown: FlownTicks) -> None:
        """Take these ticks as seen, in which there was nothing to call."""
        if self.battery_alerts:
            for row in flown.rows[BatteryWatch.due(flown.ticks)]:
                self.battery.take(row)

    def _touched(self, boat: Boat) -> list[NamedAlert]:
        """Return the alerts of a plant that was touched that begin or end."""
        plain, holding = boat.plain, self.holding
        return [a for a in self.alerts if a.turns(plain[a.offset], holds=a.key in holding)]

    def _turning(self, reserve: Reserve) -> list[NamedAlert]:
        """Return the alerts of the battery that begin or end."""
        holding = self.holding
        return [a for a in self.battery_alerts if a.turns(reserve, holds=a.key in holding)]

    def _turn(self, turning: Collection[NamedAlert]) -> list[NamedAlert]:
        """Have alerts begin or end; return those that have begun."""
        begun = [alert for alert in turning if alert.key not in self.holding]
        self.holding ^= {alert.key for alert in turning}
        return begun
