"""What orders to the plant write into the state: constants alone, a row each.

``effects`` makes effects of the rows. All of them touch the plant, which is computed from then on.
"""

from collections.abc import Iterator, Mapping
from typing import Final, NamedTuple

from trainer.boat.boat import Boat
from trainer.core.plant.parts import (
    EXHAUSTING,
    HAND,
    MODE_NAMES,
    NORMAL,
    OIL_PUMPS,
    OIL_SYSTEMS,
    PLACE_NAMES,
    RUN_VENTILATION,
    RUNNING,
    SECURED,
    STOPPED,
)
from trainer.core.surfaces import SURFACES
from trainer.io.orders.grammar import Refused

JUST_ORDERED: Final = -1.0  # ticks, before the core counts them
X_PLANES: Final = ("rudder", "stern")  # of an X-tail: the same four planes
PIPE_NAMES: Final = {
    **{name: f"the {name}'s leg" for name in SURFACES},
    "stern": "the stern planes' leg",
    "bow": "the bow planes' leg",
    "main": "main oil",
    "vital": "vital oil",
}
MOVED_NAMES: Final = {
    ("rudder",): "the rudder",
    ("stern",): "the stern planes",
    ("bow",): "the bow planes",
    ("stern", "bow"): "both pairs of planes",
    X_PLANES: "the X-tail, rudder and stern planes,",
}
VENTILATION_CODES: Final = {
    "secure": (SECURED, "ventilation secured"),
    "run": (RUN_VENTILATION, "ventilation running"),
    "exhaust": (EXHAUSTING, "exhausting smoke; the boat needs air from above for it"),
}


class ConstantRow(NamedTuple):
    """An order that writes constants: its words, these by field of the state, its answer."""

    words: str
    values: Mapping[str, float]
    answer: str = "{text}"


def lacking_plant(boat: Boat) -> Refused:
    """Return that the boat has no plant."""
    return Refused(f"this boat has no plant: {boat.file.path.name} has no [plant] table")


def mode_rows(boat: Boat, said: str, surfaces: tuple[str, ...]) -> Iterator[ConstantRow]:
    """Yield the orders that shift these surfaces to the modes that the boat has."""
    plant = boat.file.plant
    carried = [name for name in surfaces if boat.carries(name)]
    if plant is None or not carried:
        return
    if boat.vessel.x_tail and {*carried} & {*X_PLANES}:
        carried = [name for name in SURFACES if name in {*carried, *X_PLANES}]
    whom = MOVED_NAMES.get(tuple(carried), "all surfaces")
    for code, mode in enumerate(MODE_NAMES):
        if mode in plant.surfaces.modes:
            ordered = {f"{name}_mode_ordered": float(code) for name in carried}
            begun = {f"{name}_mode_ticks": JUST_ORDERED for name in carried}
            seconds = plant.surfaces.man_s if code == HAND else plant.surfaces.shift_s
            held = "" if code == NORMAL else ", by hand as they stand"
            answer = f"shifting {whom} to {mode} within {seconds:g} s{held}"
            yield ConstantRow(f"{said} {mode}", {**ordered, **begun}, answer)


def isolation_rows(word: str, isolated: float, _boat: Boat) -> Iterator[ConstantRow]:
    """Yield the orders that isolate parts of the oil, or open them."""
    for name in (*SURFACES, *OIL_SYSTEMS):
        answer = f"{PIPE_NAMES[name]} {'isolated' if isolated else 'open'}"
        yield ConstantRow(f"{word} {name}", {f"{name}_isolated": isolated}, answer)


def hydraulic_rows(_boat: Boat) -> Iterator[ConstantRow]:
    """Yield the orders to the pumps of oil."""
    for name in OIL_PUMPS:
        pump = f"hydraulic_pump_{name}"
        run = f"hydraulic pump {name} running until its accumulator is full, then standing by"
        yield ConstantRow(f"hydraulic pump {name} run", {pump: float(RUNNING)}, run)
        stop = f"hydraulic pump {name} stopped"
        yield ConstantRow(f"hydraulic pump {name} stop", {pump: float(STOPPED)}, stop)


def bus_rows(_boat: Boat) -> Iterator[ConstantRow]:
    """Yield the orders to the tie of the buses."""
    yield ConstantRow("bus tie shut", {"bus_tie": 1.0}, "bus tie shut")
    yield ConstantRow("bus tie open", {"bus_tie": 0.0}, "bus tie open")


def breaker_rows(_boat: Boat) -> Iterator[ConstantRow]:
    """Yield the orders to the breakers of the battery's halves."""
    for bus in ("port", "starboard"):
        for position, value in (("shut", 0.0), ("open", 1.0)):
            answer = f"{bus} breaker {position}"
            yield ConstantRow(f"breaker {bus} {position}", {f"{bus}_open": value}, answer)


def load_rows(_boat: Boat) -> Iterator[ConstantRow]:
    """Yield the orders to the loads that can be shed."""
    yield ConstantRow("loads shed", {"loads_shed": 1.0}, "loads shed")
    yield ConstantRow("loads back", {"loads_shed": 0.0}, "loads back on")


def ventilation_rows(_boat: Boat) -> Iterator[ConstantRow]:
    """Yield the orders to the ventilation."""
    for word, (code, answer) in VENTILATION_CODES.items():
        yield ConstantRow(f"ventilation {word}", {"ventilation": float(code)}, answer)


def fight_rows(boat: Boat) -> Iterator[ConstantRow]:
    """Yield the orders to fight a fire."""
    seconds = boat.file.plant.fire.party_s if boat.file.plant else 0.0
    for number, place in enumerate(PLACE_NAMES, start=1):
        sent = {"fighting": float(number), "fight_ticks": JUST_ORDERED}
        answer = f"party to the fire {place}, at it within {seconds:g} s"
        yield ConstantRow(f"fight fire {place}", sent, answer)
