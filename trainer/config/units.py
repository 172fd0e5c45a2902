"""Units of columns that people write: their size in SI, their spellings."""

import math
import re
from collections.abc import Mapping
from typing import Final

from trainer.units import DEGREE, FOOT, KNOT

# fmt: off
UNIT_SPELLINGS: Final = tuple((re.compile(wrong), right) for wrong, right in (  # and ours
    ("percent", "%"), ("[\u00b5\u03bc]", "u"), ("°|degrees?|deg\\.", "deg"), ("radians?", "rad"),
    ("seconds?|sec", "s"), ("minutes?", "min"), ("hours?|hrs?", "h"), ("knots?|kts?", "kn"),
    ("fathoms?|^fm$", "fathom"), ("f(?:ee|oo)t", "ft"), ("met(?:re|er)s?", "m"),
    (r"[\s*]+|\^", ""), ("(?<=[a-z])(?:per|p)(?=(?:s|min|h)$)", "/"),
    ("(s|min|h)-1$", r"/\1"), ("^kmh?/?h$|^k/h$", "km/h"), ("^m/h$", "mph"), ("^f/s$", "ft/s"),
    ("^d/s$", "deg/s"), ("^(?:r(?:ev)?|1)/min$", "rpm"), ("^r(?:ev)?/s$", "rps"),
    ("^counts?$", "counts"), ("^mils$", "mil"), ("^gons$|^grads?$", "gon"),
    ("^deg(?:true|t|magnetic|mag|m)$", "deg"),
))
UNIT_FACTORS: Final[Mapping[str, Mapping[str, float]]] = {  # by quantity, to SI and radians
    "s": {"s": 1.0, "ms": 1e-3, "us": 1e-6, "min": 60.0, "h": 3600.0, "ns": 1e-9},
    "rad": {
        "rad": 1.0, "deg": DEGREE, "gon": math.pi / 200.0, "mil": math.pi / 3200.0, "mrad": 1e-3,
        "cdeg": DEGREE / 100.0,
    },
    "rad/s": {
        "rad/s": 1.0, "deg/s": DEGREE, "deg/min": DEGREE / 60.0, "deg/h": DEGREE / 3600.0,
        "rad/min": 1.0 / 60.0, "mrad/s": 1e-3,
    },
    "m/s": {
        "m/s": 1.0, "kn": KNOT, "km/h": 1.0 / 3.6, "mph": 0.44704, "ft/s": FOOT, "cm/s": 0.01,
    },
    "1/s": {"1/s": 1.0, "rps": 1.0, "rpm": 1.0 / 60.0},
    "m": {"m": 1.0, "ft": FOOT, "fathom": 6.0 * FOOT, "cm": 0.01},
    "place": {"deg": DEGREE, "ddmm": DEGREE, "rad": 1.0},
}
# fmt: on
SCALELESS_UNITS: Final = ("%", "counts", "v", "us", "-")  # of a gauge: they say no angle
KNOWN_UNITS: Final = frozenset(  # that may stand in brackets
    (*SCALELESS_UNITS, *(unit for units in UNIT_FACTORS.values() for unit in units))
)


def spell_unit(unit: str) -> str:
    """Return a unit as it is written here: deg for °, kn for kts."""
    spelling = unit.strip().strip("[]()").casefold()
    for wrong, right in UNIT_SPELLINGS:
        spelling = wrong.sub(right, spelling)
    return spelling
