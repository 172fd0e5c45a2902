"""The trainer's records and constants as a C header, so that C works on the very same memory."""

from types import ModuleType
from typing import Final

import numpy as np

from trainer.core import (
    actuators,
    air,
    autopilot,
    casualties,
    instruments,
    kinematics,
    noise,
    onset,
    pumps,
    reference,
    sea,
    seaway,
    tanks,
    update,
    vessel,
    wave_filter,
    wave_forces,
)
from trainer.core import buoyancy as hull
from trainer.core.scheme import SCHEME
from trainer.core.scratch import SCRATCH
from trainer.core.state import STATE

RECORDS: Final = {
    "vessel": vessel.VESSEL,
    "compact": vessel.COMPACT,
    "scheme": SCHEME,
    "state": STATE,
    "scratch": SCRATCH,
}
TYPES: Final = {"f8": "double", "i8": "int64_t"}
CONSTANTS: Final[tuple[tuple[ModuleType, str], ...]] = (
    (actuators, "AMIDSHIPS"),
    (air, "CRITICAL THINNEST"),
    (autopilot, "BOW FAR GAIN_COUNT HANDOVER PLANE_GAINS RUDDER RUDDER_GAINS SETTLED SLOWEST"),
    (autopilot, "SPEED_BAND STANDS STERN"),
    (casualties, "AUTOPILOT_FAILED BIASED BREACH FIRST_FAULT FIRST_GAUGE FIRST_OPEN"),
    (casualties, "FOLLOW_UP_LOST FREE GAUGE_STUCK HARD_OVER PROPULSION_LOST PROPULSION_STUCK SLOW"),
    (casualties, "STUCK VENT_FAULT"),
    (hull, "SEGMENT_SLOPE SMALL_SEGMENT"),
    (instruments, "GYRO LOG"),
    (kinematics, "LINEAR POLYNOMIAL STEEPEST"),
    (noise, "PARITY SEA_FILTER"),
    (onset, "SURFACE_KINDS"),
    (pumps, "DAMPING INTEGRAL"),
    (reference, "APPROACH COURSE_SLEW DEPTH_SLEW LEASH"),
    (sea, "DEGREE"),
    (seaway, "OMEGA"),
    (tanks, "ATMOSPHERE AUXILIARY DEPTH_CONTROL DEPTH_CONTROL_PUMP DISCHARGE DRAIN_PUMP"),
    (tanks, "EMERGENCY_BANK END FIRST_DRY MAIN_BANK NEGATIVE STATIONS TRIM_AFT TRIM_FORWARD"),
    (tanks, "TRIM_PUMP"),
    (update, "FASTEST FASTEST_RATE FURTHEST"),
    (vessel, "SURFACE_DEPTHS"),
    (wave_filter, "G_OF_TABLE HIGH_DAMPING KNOT LOW_DAMPING PEAK WIDEST"),
)


def header() -> str:
    """Return the text of records.h."""
    lines = ["/* Written from the layout of the trainer's records. */", "#include <stdint.h>"]
    for module, names in CONSTANTS:
        lines += [f"#define {name} {getattr(module, name)!r}" for name in names.split()]
    lines += [
        f"#define SURFACE_FAULTS {len(casualties.SURFACE_FAULTS)}",
        f"#define GAUGE_FAULTS {len(casualties.GAUGE_FAULTS)}",
        _table("SIMILAR", np.array(wave_filter.SIMILAR)),
        _table("TAPER", np.array(wave_forces.TAPER)),
        _table("TABLE", wave_filter.TABLE),
    ]
    for name, dtype in RECORDS.items():
        lines += _struct(name, dtype)
    return "\n".join(lines) + "\n"


def _table(name: str, values: np.ndarray) -> str:
    """Return an array of constants."""
    text = str(values.tolist()).replace("[", "{").replace("]", "}")
    return f"static const double {name}{_shape(values.shape)} = {text};"


def _shape(shape: tuple[int, ...]) -> str:
    """Return the extents of an array in C."""
    return "".join(f"[{extent}]" for extent in shape)


def _struct(name: str, dtype: np.dtype) -> list[str]:
    """Return a record as a struct; blocks lie over the numbers that they are made of."""
    fields = sorted((dtype.fields or {}).items(), key=lambda field: (field[1][1], -_size(field[1])))
    lines, inside = [f"struct {name} {{", "union { struct {"], 0
    whole = ""
    for place, (field, (kind, offset, *_)) in enumerate(fields):
        declared = f"{TYPES[kind.base.str[1:]]} {field}{_shape(kind.shape)};"
        follows = fields[place + 1][1][1] if place + 1 < len(fields) else dtype.itemsize
        if field == "whole":
            whole = declared
        elif kind.shape and follows == offset and not inside:
            inside = offset + kind.itemsize
            lines.append(f"union {{ {declared} struct {{")
        else:
            lines.append(declared)
        if inside and follows >= inside:
            lines.append("}; };")
            inside = 0
    return [*lines, "}; " + whole + " };", "};", _check(name, dtype)]


def _size(place: tuple[np.dtype, int]) -> int:
    """Return the size of a field [bytes]."""
    return place[0].itemsize


def _check(name: str, dtype: np.dtype) -> str:
    """Return what makes the compiler refuse a struct that is not laid out like the record."""
    return f'_Static_assert(sizeof(struct {name}) == {dtype.itemsize}, "{name} is laid out otherwise");'
