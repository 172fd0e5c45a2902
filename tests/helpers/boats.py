"""Boats for the tests."""

from collections.abc import Iterable
from typing import Any, Protocol

from helpers.places import DATA
from trainer.boat.assemble import Method
from trainer.boat.boat import Boat
from trainer.boat.calls import MonitorCall
from trainer.config.boat.vessel import load_vessel
from trainer.units import KNOT


def make_boat(
    vessel: str = "bb2",
    equations: str = "full",
    rates: str = "lagged",
    integrator: str = "adams2",
    step: float = 0.5,
) -> Boat:
    """Return a boat not yet started."""
    path = str(DATA / "vectors" / vessel) if vessel.endswith(".toml") else vessel
    return Boat(load_vessel(path), Method(equations, rates, "exact", integrator, step))


def start_boat(
    speed: float, depth: float = 60.0, course: float = 0.0, *, seed: int = 1, **made: Any
) -> Boat:
    """Return a boat started in trim, everything automatic; ``made`` is as for make_boat."""
    boat = make_boat(**made)
    boat.start(speed, depth, course, seed)
    return boat


def start_bb2(
    equations: str = "full",
    rates: str = "lagged",
    integrator: str = "adams2",
    *,
    depth: float = 60.0,
) -> Boat:
    """Return BB2 at 10 kn on course 000, everything automatic."""
    return start_boat(10.0 * KNOT, depth, equations=equations, rates=rates, integrator=integrator)


def take_in_hand(boat: Boat) -> None:
    """Put every surface and the propeller in hand as they stand."""
    s = boat.state
    s.rudder_by_hand = s.stern_by_hand = s.bow_by_hand = s.speed_by_hand = 1.0
    s.ordered_r, s.ordered_s, s.ordered_b = s.delta_r, s.delta_s, s.delta_b
    s.ordered_u_c = s.u_c


def fly(boat: Boat, seconds: float) -> None:
    """Let time pass."""
    take_ticks(boat, round(seconds / boat.method.step))


def take_ticks(boat: Boat, count: int) -> None:
    """Let so many ticks pass; none may fail."""
    for _ in range(count):
        assert boat.tick() == 0


class Monitor(Protocol):
    """What looks at a boat after each tick."""

    def look(self, boat: Boat) -> Iterable[MonitorCall]: ...


def calls_of(boat: Boat, monitor: Monitor, seconds: float) -> list[MonitorCall]:
    """Let time pass; return what is called out meanwhile."""
    said: list[MonitorCall] = []
    for _ in range(round(seconds / boat.method.step)):
        assert boat.tick() == 0
        said += monitor.look(boat)
    return said
