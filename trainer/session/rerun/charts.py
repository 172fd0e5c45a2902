"""Time series of a block as charts, and states as words under a time line."""

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from typing import Final

import numpy as np

from trainer.boat.boat import Boat
from trainer.boat.sea_orders import PARTS
from trainer.core.ballast.tanks import BANKS, BLOWN, COMPARTMENTS, PUMPED, TANKS
from trainer.core.casualties import KINDS
from trainer.core.kernel import Numbers
from trainer.core.state import CASUALTIES, VALVES
from trainer.core.surfaces import SURFACES
from trainer.session.rerun.batch import Block, Whole, Worked
from trainer.units import KNOT

TONNE: Final = 1000.0  # [kg]
MICROSECOND: Final = 1000.0  # [ns]
UNITS: Final = {"%": "percent"}  # in a path

# Okabe and Ito (2008), in the order of their contrast with a dark ground
COLOURS: Final = (
    *((86, 180, 233), (230, 159, 0), (0, 158, 115), (240, 228, 66)),
    *((204, 121, 167), (213, 94, 0), (240, 240, 240), (0, 114, 178)),
)


DOWNWARDS: Final = -1.0  # [m] a viewer's numbers grow upwards: 60 m of depth is drawn at -60


@dataclass(frozen=True)
class Series:
    """One line of a chart."""

    name: str
    read: Callable[[Block], Numbers]


@dataclass(frozen=True)
class Chart:
    """Lines over the same time, in one unit; NaN leaves a gap."""

    name: str
    unit: str
    series: tuple[Series, ...]
    note: str = ""  # on the title

    @property
    def path(self) -> str:
        """Return its place among the entities, which tells the unit."""
        return f"charts/{self.name}_{UNITS.get(self.unit, self.unit)}"

    @property
    def title(self) -> str:
        """Return its name with the unit."""
        return f"{self.name}{self.note} [{self.unit}]"

    @property
    def labels(self) -> list[str]:
        """Return the name of each line."""
        return [each.name for each in self.series]

    def columns(self, block: Block) -> Numbers:
        """Return one column for each line."""
        return np.stack([each.read(block) for each in self.series], axis=1)


# what became of the ticks, which no state tells
LEDGER: Final = "charts/ticks_us"
LEDGER_LABELS: Final = ["work", "lateness"]


def ledger_columns(worked: Worked) -> Numbers:
    """Return work and lateness [us] of the ticks that were timed."""
    return np.stack((worked.work, worked.lateness), axis=1) / MICROSECOND


def charts_of(boat: Boat) -> tuple[Chart, ...]:
    """Return the charts that the boat has something to show in."""
    return tuple(chart for chart in (*_motion(boat), *_ballast(boat)) if chart.series)


def _place(name: str, place: str, unit: float = 1.0) -> Series:
    """Return a number of the state, in a unit of that size [SI]."""
    return Series(name, lambda block: block[place] / unit)


def _standing_order(name: str, place: str, unit: float, kept: Callable[[Block], Numbers]) -> Series:
    """Return a standing order, where it is kept."""
    return Series(name, lambda block: np.where(kept(block) > 0.0, block[place] / unit, np.nan))


def depth_kept(block: Block) -> Numbers:
    """Return 1 where the boat keeps the ordered depth, by planes or hovering."""
    by_planes = block["stern_by_hand"] * block["bow_by_hand"] == 0.0
    return np.where(by_planes | (block["hover"] > 0.0), 1.0, 0.0)


def over_ground(block: Block) -> Numbers:
    """Return the speed [kn] over the ground, 0 while the place is held."""
    speed = np.hypot(block["xdot"], block["ydot"]) / KNOT
    return np.where(block["held_position"] > 0.0, 0.0, speed)


def drift(block: Block) -> Numbers:
    """Return the speed [kn] of the water at the boat over the ground."""
    north = block["water_north"] + block["shear_north"] * block["z"]
    east = block["water_east"] + block["shear_east"] * block["z"]
    speed: Numbers = np.hypot(north, east) / KNOT
    return speed


def _motion(boat: Boat) -> Iterator[Chart]:
    """Yield the charts of how the boat moves and is steered."""
    degree = np.pi / 180.0
    yield Chart(
        "depth",
        "m",
        (
            _place("true", "z", DOWNWARDS),
            _standing_order("ordered", "ordered_depth", DOWNWARDS, depth_kept),
        ),
        ", downwards",
    )
    yield Chart(
        "heading",
        "deg",
        (
            _place("true", "psi", degree),
            _standing_order(
                "ordered", "ordered_psi", degree, lambda block: 1.0 - block["rudder_by_hand"]
            ),
        ),
    )
    yield Chart(
        "speed",
        "kn",
        (
            _place("true", "u", KNOT),
            _standing_order(
                "ordered", "ordered_speed", KNOT, lambda block: 1.0 - block["speed_by_hand"]
            ),
            _place("turns make", "u_c", KNOT),
        ),
    )
    yield Chart(
        "attitude", "deg", (_place("pitch", "theta", degree), _place("heel", "phi", degree))
    )
    yield Chart("surfaces", "deg", tuple(_surfaces(boat, degree)))
    yield Chart("ground", "kn", (Series("speed", over_ground), Series("drift", drift)))
    yield Chart("sea", "m", (_place("above the boat", "eta_wave"), _place("height", "sea_height")))


def _surfaces(boat: Boat, degree: float) -> Iterator[Series]:
    """Yield each surface as it is and as it is told; right and rise are positive."""
    for surface, letter in SURFACES.items():
        toward = boat.toward[surface]
        if not toward:
            continue
        yield _place(surface, f"delta_{letter}", toward * degree)
        by_hand = f"{surface}_by_hand"
        told = f"ordered_{letter}", f"command_{letter}"

        def ordered(
            block: Block,
            unit: float = toward * degree,
            by: str = by_hand,
            names: tuple[str, str] = told,
        ) -> Numbers:
            return np.where(block[by] > 0.0, block[names[0]], block[names[1]]) / unit

        yield Series(f"{surface} ordered", ordered)


def _ballast(boat: Boat) -> Iterator[Chart]:
    """Yield the charts of weight, tanks and air."""
    c = boat.vessel
    weight = float(c.g) * TONNE

    def heavy(block: Block) -> Numbers:
        return (block["weight"] - float(c.buoyancy)) / weight

    yield Chart("weight", "t", (Series("heavier than at rest", heavy),))
    capacity = dict(zip(TANKS, c.capacity.tolist(), strict=True))
    full = dict(zip(BANKS, c.bank_full.tolist(), strict=True))
    yield Chart(
        "ballast",
        "%",
        tuple(
            _place(_words(tank), f"water_{tank}", 0.01 * capacity[tank])
            for tank in BLOWN
            if capacity[tank]
        ),
    )
    yield Chart("trim", "t", tuple(_tonnes(PUMPED, capacity)))
    yield Chart("flooding", "t", tuple(_tonnes(COMPARTMENTS, capacity)))
    yield Chart(
        "air",
        "%",
        tuple(
            _place(_words(bank), f"bank_{bank}", 0.01 * full[bank]) for bank in BANKS if full[bank]
        ),
    )


def _tonnes(tanks: tuple[str, ...], capacity: dict[str, float]) -> Iterator[Series]:
    """Yield the water in each tank or compartment that the boat has."""
    for tank in tanks:
        if capacity[tank]:
            flooded = tank.replace("compartment_", "flood_")
            place = flooded if flooded != tank else f"water_{tank}"
            yield _place(_words(tank.removeprefix("compartment_")), place, TONNE)


def _words(name: str) -> str:
    return name.replace("_", " ")


# Lanes: what is so from one moment to another, as words under a time line.


SLOTS: Final = tuple(f"casualty[{i}]" for i in range(CASUALTIES))
LEFT: Final = tuple(f"casualty_ticks[{i}]" for i in range(CASUALTIES))
ACTING, CLEARED = "acting", "being cleared"
BLOWS: Final = ("", "", " (emergency)")  # by the position of a blow valve


AUTO, HAND, BROKEN, MENDING = 0x56B4E9FF, 0xE69F00FF, 0xD55E00FF, 0xCC79A7FF


@dataclass(frozen=True)
class Lane:
    """A code for each tick, and the word for each code. "" while there is nothing to show."""

    path: str
    codes: Callable[[Block], Whole]
    word: Callable[[int], str]
    colours: Mapping[str, int] = field(default_factory=dict)  # of words that have their own


def lanes_of(boat: Boat) -> tuple[Lane, ...]:
    """Return the lanes of the boat; those of casualties come with `casualty_lanes`."""
    steered = [name for name in SURFACES if boat.toward[name]]
    lanes = [Lane("lanes/run", _run, _describe_run)]
    lanes += [_by_hand(name) for name in (*steered, "speed")]
    lanes.append(_several("lanes/held", tuple(f"held_{part}" for part in PARTS), PARTS))
    if boat.vessel.fitted:
        lanes.append(
            Lane("lanes/hover", lambda block: _whole(block["hover"]), ("", "on").__getitem__)
        )
        lanes.append(Lane("lanes/blow", _blow, _describe_blow))
        lanes.append(_several("lanes/vents", tuple(f"vent_{name}" for name in VALVES), VALVES))
    return tuple(lanes)


def casualty_lanes(block: Block) -> list[Lane]:
    """Return a lane for each kind of casualty that is there in the block."""
    kinds = np.unique(block.several(*SLOTS)).astype(int)
    return [_casualty(kind) for kind in kinds.tolist() if kind]


def _casualty(kind: int) -> Lane:
    """Return the lane of a kind of casualty."""

    def codes(block: Block) -> Whole:
        here = block.several(*SLOTS) == kind
        clearing = here & (block.several(*LEFT) < 0.0)
        acting = np.any(here & ~clearing, axis=1)
        return np.where(acting, 2, np.where(np.any(clearing, axis=1), 1, 0))

    word = ("", CLEARED, ACTING).__getitem__
    return Lane(f"lanes/{KINDS[kind - 1]}", codes, word, {CLEARED: MENDING, ACTING: BROKEN})


def _whole(column: np.ndarray) -> Whole:
    return column.astype(np.int64)


def _run(block: Block) -> Whole:
    return 2 * block.branch + block.replaying


def _describe_run(code: int) -> str:
    return f"{'replay of ' if code % 2 else ''}branch {code // 2}"


def _by_hand(what: str) -> Lane:
    """Return whether something is steered by hand."""
    place = f"{what}_by_hand"
    word = ("auto", "hand").__getitem__
    colours = {"auto": AUTO, "hand": HAND}
    return Lane(f"lanes/{what}", lambda block: _whole(block[place]), word, colours)


def _several(path: str, places: tuple[str, ...], names: tuple[str, ...]) -> Lane:
    """Return which of several things are so, each a bit of the code."""
    bits = 2 ** np.arange(len(places))

    def word(code: int) -> str:
        return ", ".join(name for i, name in enumerate(names) if code & 1 << i)

    return Lane(path, lambda block: _whole((block.several(*places) > 0.0) @ bits), word)


def _blow(block: Block) -> Whole:
    positions = block.several(*(f"blow_{name}" for name in VALVES))
    return _whole(positions @ 3.0 ** np.arange(len(VALVES)))


def _describe_blow(code: int) -> str:
    """Return which blow valves are open; each is a digit of the code to the base of three."""
    positions = [(name, code // 3**i % 3) for i, name in enumerate(VALVES)]
    return ", ".join(name + BLOWS[position] for name, position in positions if position)
