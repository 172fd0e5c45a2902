"""Random orders and casualties, on every boat by every set: numbers, attitude and energy hold."""

import math
from collections.abc import Iterator
from dataclasses import dataclass, field
from random import Random
from typing import Final

import numpy as np

from soak.operators import Orders
from trainer.boat.assemble import Method
from trainer.boat.boat import STATE_OFFSETS, Boat
from trainer.boat.depths import collapse_of
from trainer.boat.helm import obey_order
from trainer.config.boat.vessel import VesselFile, load_vessel
from trainer.config.files import shipped_names
from trainer.core import full, wide
from trainer.core.envelope import wide_share
from trainer.core.kernel import Numbers, Record
from trainer.core.kinematics import EXACT_TRIGONOMETRY, attitude_of
from trainer.core.propulsion import thrust, thrust_astern
from trainer.core.rigid_body import add_weight, body_forces
from trainer.core.stall import write_stalled
from trainer.io.orders.grammar import Order, parse
from trainer.session.stations.roles import INSTRUCTOR_ROLE
from trainer.units import KNOT

SETS: Final = (
    ("full", "exact"),
    ("modified", "lagged"),
    ("basic", "lagged"),
    ("longitudinal", "exact"),
)
THETA: Final = STATE_OFFSETS["theta"]
RIGHTS: Final = ("clear all", "release all", "blow stop")
SURVEY: Final = 20  # ticks between two looks at the energy
FEEDS: Final = 2e-3  # [-] of rho/2 l^2 U^3, allowed inside the range (docs/envelope.md)


def propulsion(vessel: Record, state: Record) -> float:
    """Return thrust [N] less what the propeller and hull drag with it stopped."""
    s = state[0]
    of = thrust if s.u >= 0.0 else thrust_astern
    whole, turning = of(vessel, state), s.u_c
    s.u_c = 0.0
    drag = of(vessel, state)
    s.u_c = turning
    return float(whole - drag)


def water_forces(boat: Boat) -> Numbers:
    """Return the water's force [N] and moment [N m]. The full set and the wide one are blended.

    Without weight and buoyancy, propulsion, and what comes from outside.
    """
    vessel, state = boat.records.vessel, boat.records.state
    share = wide_share(vessel, state)
    own, inside, outside, stalled = (np.zeros(6) for _ in range(4))
    body_forces(vessel, state, own)
    add_weight(vessel, state, own)
    if share < 1.0:
        full.forces(vessel, attitude_of(EXACT_TRIGONOMETRY, state), state, inside)
        write_stalled(vessel, stalled, state, stalled)
        inside += stalled
    if share > 0.0:
        wide.forces(vessel, state, outside)
        u_c = boat.state.u_c
        outside[3] -= boat.vessel.K_star * u_c * abs(u_c)
    found = (1.0 - share) * inside + share * outside - own
    found[0] -= propulsion(vessel, state)
    return np.asarray(found)


def water_power(boat: Boat) -> float:
    """Return the power of the water over rho/2 l^2 U^3 [-]. Above 0 it feeds the boat."""
    motion, c = boat.state.motion[:6], boat.vessel
    speed = float(np.sqrt(np.sum(motion[:3] ** 2) + c.cross_arm * np.sum(motion[3:] ** 2)))
    if speed == 0.0:
        return 0.0
    power = float(np.dot(water_forces(boat), motion))
    return power / float(0.5 * c.rho * c.ell**2 * speed**3)


@dataclass
class Stressed:
    """The result of one boat by one set."""

    vessel: str
    equations: str
    orders: int = 0
    ticks: int = 0
    collapses: int = 0
    steepest_deg: float = 0.0
    fed: float = 0.0  # [-] most power of the water, over rho/2 l^2 U^3
    lost: list[str] = field(default_factory=list)

    @property
    def kept(self) -> bool:
        """Return whether nothing was lost, no pitch was beyond the vertical and nothing was fed."""
        return not self.lost and self.steepest_deg <= 90.0 and self.fed <= FEEDS


def start(boat: Boat, file: VesselFile, dice: Random) -> None:
    """Start the boat anew, at its start speed and a depth it may go to."""
    deepest = file.hull.max_depth_m or 300.0
    depth = dice.uniform(0.2, 1.0) * deepest
    boat.start(file.run.start_speed_kn * KNOT, depth, 0.0, seed=dice.randrange(1, 1000))


def stress_one(
    file: VesselFile, way: tuple[str, str], seconds: float, orders: int, seed: int
) -> Stressed:
    """Return what becomes of a boat in ``seconds`` with so many ``orders``."""
    dice = Random(seed)  # noqa: S311  choices, not secrets
    boat = Boat(file, Method(way[0], way[1], "exact", "adams2", file.run.step_s))
    found = Stressed(file.name, way[0])
    given = Orders(INSTRUCTOR_ROLE, dice)
    start(boat, file, dice)
    between = max(round(seconds / orders / boat.method.step), 1)
    for number in range(orders):
        words = dice.choice(RIGHTS) if number % 50 == 49 else given.next()
        order = parse(words)
        if isinstance(order, Order):
            obey_order(boat, order)
            found.orders += 1
        _fly(boat, dice.randrange(1, 2 * between + 1), found, dice)
    return found


def _fly(boat: Boat, ticks: int, found: Stressed, dice: Random) -> None:
    """Take the boat through ``ticks``, noting what is not as it should be."""
    for number in range(ticks):
        status = boat.tick()
        if status:
            found.lost.append(boat.failure(status))
            start(boat, boat.file, dice)
        found.ticks += 1
        found.steepest_deg = max(found.steepest_deg, abs(math.degrees(boat.plain[THETA])))
        if number % SURVEY == 0 and boat.method.equations == "full":
            found.fed = max(found.fed, water_power(boat))
        if collapse_of(boat):
            found.collapses += 1
            start(boat, boat.file, dice)


def stress(orders: int, hours: float, seed: int) -> Iterator[Stressed]:
    """Yield what becomes of every shipped boat by every set."""
    for name in shipped_names("vessels"):
        for way in SETS:
            yield stress_one(load_vessel(name), way, 3600.0 * hours, orders, seed)


HEAD: Final = (
    f"{'vessel':44}{'set':14}{'orders':>8}{'ticks':>10}{'collapses':>10}{'pitch':>8}{'fed':>10}"
)


def row(found: Stressed) -> str:
    """Return a line of the table, and what was lost below it."""
    line = (
        f"{found.vessel[:42]:44}{found.equations:14}{found.orders:8,}{found.ticks:10,}"
        f"{found.collapses:10}{found.steepest_deg:8.2f}{found.fed:10.1e}"
    )
    return "\n".join([line, *(f"  LOST {text}" for text in found.lost[:5])])
