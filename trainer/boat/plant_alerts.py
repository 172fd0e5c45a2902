"""The alerts of a boat's plant: oil, buses, overload, and smoke.

A session asks ``PlantMonitor.look`` after each tick, and announces the calls. Each alert watches a
number of the state, which has one bound where it begins and another where it is over, so that it
does not come and go.
"""

from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Final

import numpy as np

from trainer.boat.boat import STATE_OFFSETS, Boat
from trainer.boat.calls import MonitorCall, Rank
from trainer.boat.flown_ticks import FlownTicks, Mask, count_before
from trainer.core.plant.parts import BUS_NAMES, MAIN, OIL_SYSTEMS, PLACE_NAMES

MEGAPASCAL: Final = 1e6  # [Pa]
LOW_MPA, WHOLE_MPA = 16.0, 18.0  # [MPa] oil is low below, and no more from here on; estimates
HALF_TANK, REFILLED_TANK = 0.5, 0.6  # [-]
SEEN_SMOKE, THIN_SMOKE = 0.05, 0.02  # [-] estimates
OIL_LOW, TANK_HALF, MAIN_LOST = "oil low", "oil tank half", "main oil lost"  # names of alerts
BUS_LOST, OVERLOAD, FIRE = "bus lost", "overload", "fire"
PLANT_RANKS: Final = {
    MAIN_LOST: Rank.ALARM,
    FIRE: Rank.ALARM,
    OVERLOAD: Rank.ALARM,
    BUS_LOST: Rank.ALARM,
    OIL_LOW: Rank.WARNING,
    TANK_HALF: Rank.WARNING,
}
TOUCHED_OFFSET: Final = STATE_OFFSETS["plant_touched"]


@dataclass(frozen=True)
class PlantAlert:
    """One alert: the number of the state that it watches, and its words."""

    name: str
    part: str  # of the plant, "" where there is one
    words: str
    offset: int  # in the state
    begins: float  # above this
    ends: float  # at this or below
    sign: float = 1.0  # of the number

    @property
    def key(self) -> str:
        """Return the key, with the part after a colon."""
        return f"{self.name}:{self.part}" if self.part else self.name

    @property
    def call(self) -> MonitorCall:
        """Return what is called."""
        return MonitorCall(self.words, PLANT_RANKS[self.name], self.key)


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


@dataclass
class PlantMonitor:
    """The watch on a plant: which alerts hold, and when each was called."""

    alerts: tuple[PlantAlert, ...] = ()
    holding: set[str] = field(default_factory=set)  # keys of the alerts called that hold still
    times: dict[str, list[float]] = field(default_factory=dict)  # [s]

    @classmethod
    def over(cls, boat: Boat) -> "PlantMonitor":
        """Return the watch over a boat; what holds now is no news."""
        monitor = cls(tuple(plant_alerts(boat)))
        monitor.reset_to(boat)
        return monitor

    def reset_to(self, boat: Boat) -> None:
        """Take the boat as it is. Nothing of it is news."""
        self._news(boat)

    def look(self, boat: Boat) -> list[MonitorCall]:
        """Return what there is to call out after a tick."""
        if not (boat.plain[TOUCHED_OFFSET] or self.holding):
            return []
        news = self._news(boat)
        for alert in news:
            self.times.setdefault(alert.key, []).append(boat.time)
        tick = f"tick {boat.ticks} ({boat.time:g} s)"
        return [alert.call._replace(text=f"{tick}: {alert.words}") for alert in news]

    def quiet_ticks(self, _boat: Boat, flown: FlownTicks) -> int:
        """Return after how many ticks there may be something to call, or all of them."""
        mask: Mask = np.zeros(len(flown), np.bool_)
        for alert in self.alerts:
            value = alert.sign * flown.rows[:, alert.offset]
            mask |= value <= alert.ends if alert.key in self.holding else value > alert.begins
        return count_before(mask)

    def _news(self, boat: Boat) -> list[PlantAlert]:
        """Return the alerts that have begun since the last look, and forget those that are over."""
        news = []
        for alert in self.alerts:
            value = alert.sign * boat.plain[alert.offset]
            if alert.key in self.holding:
                if value <= alert.ends:
                    self.holding.discard(alert.key)
            elif value > alert.begins:
                self.holding.add(alert.key)
                news.append(alert)
        return news
