"""The measures by name: required keys, unit, and formula in words."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Final

from trainer.core.surfaces import SURFACES

ITS_OWN: Final = ""  # the unit of a measure that is a quantity's
COURSE: Final = "course"  # a quantity beside those of conditions: it goes round
ORDERED: Final[Mapping[str, str]] = {  # places of the state that hold what is ordered
    "depth": "ordered_depth",
    COURSE: "ordered_psi",
    "speed": "ordered_speed",
}


@dataclass(frozen=True)
class Measure:
    """One measure: what a rule must and may say, its unit, and its formula."""

    needs: tuple[str, ...]
    may: tuple[str, ...]
    unit: str  # ITS_OWN: that of the quantity
    formula: str  # {q} the quantity, {t} its target, {b} its band, {u} their unit, {c} the casualty
    place: str  # which moment is told
    quantities: tuple[str, ...] = ()  # the only ones it takes; () any


TANKS: Final = ("bank_main", "bank_emergency")
MEASURES: Final[Mapping[str, Measure]] = {
    "overshoot": Measure(
        ("quantity", "target"),
        ("band",),
        ITS_OWN,
        "furthest of {q} beyond {t}, seen from where it began; no value short of it{by}",
        "the furthest",
    ),
    "time-to": Measure(
        ("quantity", "target", "band"),
        (),
        "s",
        "time until {q} is within {b} of {t} and stays there to the end",
        "when it is",
    ),
    "reach": Measure(
        ("quantity", "target", "band"),
        (),
        "s",
        "time until {q} is within {b} of {t} and stays there; no value if it was there at once",
        "when it is",
    ),
    "settled": Measure(
        ("quantity", "target", "band"),
        (),
        "%",
        "share of the last 120 s with {q} within {b} of {t}; no value if it was there at once",
        "the furthest from it",
    ),
    "final": Measure(
        ("quantity",),
        ("target",),
        ITS_OWN,
        "{q} at the end{f}",
        "the end",
    ),
    "rms": Measure(
        ("quantity",),
        ("target",),
        ITS_OWN,
        "root of the mean of ({q} - {t})^2, a term for each tick",
        "the furthest from it",
    ),
    "in-band": Measure(
        ("quantity", "band"),
        ("target",),
        "%",
        "share of the ticks with {q} within {b} of {t}",
        "the furthest from it",
    ),
    "highest": Measure(("quantity",), (), ITS_OWN, "greatest {q}", "when it was"),
    "lowest": Measure(("quantity",), (), ITS_OWN, "least {q}", "when it was"),
    "largest": Measure(
        ("quantity",), ("target",), ITS_OWN, "greatest {q} either way{f}", "when it was"
    ),
    "activity": Measure(
        (),
        ("quantity",),
        "deg/min",
        "sum of what {q} moved from tick to tick, by the time",
        "the fastest",
        tuple(SURFACES),
    ),
    "distance": Measure(
        (),
        (),
        "m",
        "sum of the way over the ground from tick to tick",
        "the last",
    ),
    "closest-approach": Measure(
        (),
        (),
        "m",
        "least range to any ship, middle to middle, straight between ticks",
        "when it was",
    ),
    "exposed": Measure(
        (),
        (),
        "s",
        "number of ticks with the periscope's head out of the water, times the step",
        "the first",
    ),
    "exposed-raise": Measure(
        (),
        (),
        "s",
        "the same of the raise of the mast that has most",
        "its first",
    ),
    "time-to-detect": Measure(
        (),
        (),
        "s",
        "longest time from when a ship came in sight to a mark of it: `mark contact 045`, "
        "within 3 deg",
        "the mark",
    ),
    "broaches": Measure(
        (),
        (),
        "-",
        "times that sail or deck came out of the sea, main ballast not being blown",
        "the first",
    ),
    "aground": Measure(
        (),
        (),
        "-",
        "times that the ground carried the boat, not counting where it was laid down well",
        "the first",
    ),
    "beyond-limits": Measure(
        (),
        (),
        "s",
        "number of ticks beyond any limit of the exercise, times the step",
        "the first",
    ),
    "beyond-test-depth": Measure(
        (),
        (),
        "m",
        "furthest that the hull's lowest point was beyond test depth",
        "the furthest",
    ),
    "time-beyond-test-depth": Measure(
        (),
        (),
        "s",
        "number of ticks with the hull's lowest point beyond test depth, times the step",
        "the first",
    ),
    "response": Measure(
        ("casualty",),
        ("orders",),
        "s",
        "time from the first onset of {c} to the crew's next order{o}",
        "the order",
    ),
    "reserve-air": Measure(
        (),
        ("quantity",),
        "%",
        "least of the air in {q} as a share of full",
        "when it was",
        TANKS,
    ),
}
TIMELESS: Final = ("response",)  # look at the whole record
WINDOW: Final = ("since", "from_s", "to_s", "when")
