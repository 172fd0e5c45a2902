"""The plain C tick, compiled with a header of the trainer's records."""

import ctypes
import os
import shlex
import shutil
import subprocess
import tempfile
from collections.abc import Callable, Sequence
from pathlib import Path
from types import ModuleType
from typing import Final, NamedTuple

import numpy as np

from trainer.boat.assemble import Records
from trainer.boat.export.targets import NoCompilerError
from trainer.core import (
    actuators,
    attitude,
    casualties,
    elementary,
    envelope,
    kinematics,
    noise,
    propulsion,
    scheme,
    state,
    surfaced,
    update,
    vessel,
)
from trainer.core.autopilot import (
    ascent,
    depth,
    reference,
    sections,
    speed,
    steering,
    trimming,
    waves,
)
from trainer.core.ballast import air, tanks
from trainer.core.ballast import buoyancy as hull
from trainer.core.ballast import hover as hovering
from trainer.core.plant import parts as plant_parts
from trainer.core.plant import plant
from trainer.core.sea import cosine_sum, filter_1969, forces, wave_filter
from trainer.core.sea import sea as sea_module
from trainer.core.state import SCRATCH, STATE

RECORDS: Final = {
    "vessel": vessel.VESSEL,
    "compact": vessel.COMPACT,
    "scheme": scheme.SCHEME,
    "state": STATE,
    "scratch": SCRATCH,
}
TYPES: Final = {"f8": "double", "i8": "int64_t"}
CONSTANTS: Final[tuple[tuple[ModuleType, str], ...]] = (
    (actuators, "AMIDSHIPS_ANGLE"),
    (air, "CRITICAL_RATIO MIN_TANK_PRESSURE"),
    (attitude, "HALF_TURN PHI POLAR_PITCH PSI THETA FULL_TURN"),
    (ascent, "ASCENT_AFLOAT ASCENT_BUBBLE EMERGENCY_OPENING AFT_BLOW_PITCH EXTRA_BUBBLE"),
    (ascent, "QUIET_TIME_S QUIET_PITCH QUIET_RATE ASCENT_RISING"),
    (ascent, "MIN_PITCH_GAIN SURFACED_DEPTH BUBBLE_RATE"),
    (
        casualties,
        "AUTOPILOT_FAILED GAUGE_BIASED FOLLOW_UP_LOST SURFACE_FREE GYRO HARD_OVER LOG SOUNDER",
    ),
    (casualties, "GAUGE_STUCK PROPULSION_LOST PROPULSION_STUCK SURFACE_SLOW"),
    (cosine_sum, "BAND_COUNT VARIANCE_SHARE"),
    (depth, "FAR_SHARE LEAST_ASTERN SURE_ASTERN"),
    (envelope, "PROVED_TURN_RATIO EXTRAPOLATED_RANGE INSIDE_RANGE MOST_SUBSTEPS"),
    (envelope, "OUTSIDE_RANGE SUBSTEP_PHASE STILL_SUBSTEP SURFACE_SUBSTEP"),
    (hull, "SEGMENT_SLOPE SMALL_SEGMENT"),
    (kinematics, "LINEAR_TRIGONOMETRY POLYNOMIAL_TRIGONOMETRY MIN_PITCH_COSINE"),
    (filter_1969, "G_OF_TABLE HIGH_DAMPING KNOT LOW_DAMPING PEAK_FACTOR MAX_HALF_ANGLE"),
    (forces, "MAX_KAPPA FLOW HEAVE HEAVE_ADDED LAST_TRUE SUM_NUMBERS PITCH PITCH_ADDED RISE"),
    (forces, "ROWS_PER_TURN MIN_KAPPA SURGE SWAY SWAY_ADDED SWING YAW YAW_ADDED"),
    (noise, "KEY_PARITY SEA_BANK SEA_FILTER SEA_FREQUENCY SEA_PHASE"),
    (hovering, "GIVE_UP_SPEED CATCH_SHARE SLOW_DAMPING LEARNING_TIME_S MAX_WAY_SPEED"),
    (sections, "EARLY SECTION_SIZE LATE OUTPUT"),
    (reference, "APPROACH_TICKS ASTERN_PACE COURSE_AXIS DEPTH_AXIS LEASH_SHARE"),
    (plant, "CALM_TICKS"),
    (plant_parts, "CONSUMER_COUNT FED_COMPRESSOR FED_DEPTH_CONTROL FED_DRAIN FED_TRIM"),
    (plant_parts, "HYDRAULIC_END FED_AUTOPILOT FED_GYRO FED_TELEGRAPH FED_PROPULSION"),
    (plant_parts, "PORT STARBOARD DC MAIN VITAL MAIN_PUMP_COUNT STANDING_BY RUNNING NORMAL HAND"),
    (plant_parts, "MAIN_VALVE VITAL_VALVE HEADER FIRST_LEG FIRST_BUS CELLS DIP"),
    (propulsion, "POWER_ROOT_STEPS"),
    (scheme, "ADAMS"),
    (speed, "ANSWER_TIME_S LOW_PASS_TIME_S PROPELLER_SLACK"),
    (steering, "ASTERN_SPEED BOW GAIN_COUNT HANDOVER_LENGTHS RUDDER LEVEL_SHARE MIN_DIVISOR_SPEED"),
    (steering, "ARRIVAL_TOLERANCE STERN"),
    (state, "FILTER_DEGREE SEA_COMPONENTS STRIP_COUNT STRIP_ROWS"),
    (sea_module, "OMEGA"),
    (tanks, "ATMOSPHERIC_PRESSURE AUXILIARY_TANK DEPTH_CONTROL DEPTH_CONTROL_PUMP"),
    (tanks, "DISCHARGE_COEFFICIENT DRAIN_PUMP"),
    (tanks, "EMERGENCY_BANK TANKS_END FIRST_DRY MAIN_BANK NEGATIVE_TANK HULL_STATIONS"),
    (tanks, "TRIM_AFT TRIM_FORWARD"),
    (tanks, "TRIM_PUMP"),
    (trimming, "MAX_FLOOD_RATE TRIM_TIME_S MIN_HEAVINESS LEVELLING_RATE"),
    (trimming, "MAX_TRANSFER_RATE MAX_DEPTH_ERROR_M MIN_IMBALANCE MIN_TRIM_SPEED"),
    (update, "MAX_SPEED MAX_RATE MAX_DISTANCE"),
    (surfaced, "HUMP_FROUDE TRAVEL_SHARE TROUGH_SHARE"),
    (vessel, "COURSE_GAIN COURSE_INTEGRAL_GAIN DEPTH_GAIN DEPTH_RATE_GAIN DEPTH_SLEW"),
    (vessel, "INTEGRAL_GAIN PITCH_GAIN PITCH_RATE_GAIN PLANE_COUNT RELIEF_GAIN"),
    (vessel, "SLEW_ACCELERATION SLEW_COUNT SLEW_RATE STERN_GAINS SURFACE_DEPTHS SWAY_GAIN"),
    (vessel, "YAW_RATE_GAIN"),
    (waves, "UPPER_NOTCH LOWER_NOTCH LIMIT_BLEND AVERAGED_WAVES FADE_TIME_S"),
    (waves, "FELT_DEPTH_RATE LEAST_RATIO MAX_QUIET_PERIODS NOTCH_SIZE MIN_CROSSING_S"),
    (wave_filter, "MOST_STEPS OUTPUT_COUNT PHASE_STEP SLOWEST_CLOCK"),
)
CASUALTY_TABLES: Final = (
    "KIND_SURFACES",
    "KIND_GAUGES",
    "KIND_FAULTS",
    "KIND_OFFSETS",
    "KIND_SENSES",
    "KIND_HOLDS",
    "KIND_IN_PLANT",
    "GAUGE_CODE",
    "SERVO_CODE",
)
FILTER_TABLES: Final = ("MODE_FACTORS", "WAVE_ROWS", "FORCE_ROWS", "FORCE_DEPTHS", "LENGTH_TABLE")
SUM_TABLES: Final = ("ANGLE_COS", "ANGLE_SIN", "DIRECTION_WEIGHTS")
PILOT_TABLES: Final[dict[tuple[ModuleType, str], str]] = {
    (ascent, "EXTRA_BUBBLE_SPEEDS"): "FAST",
    (hovering, "DAMPING_RATIOS"): "HOVER_DAMPING",
    (hovering, "INTEGRAL_FACTORS"): "HOVER_INTEGRAL",
    (hovering, "FREQUENCY_FACTORS"): "SOFTER",
    (speed, "MAX_SPEED_TRIM"): "MOST_TRIM",
    (waves, "FREQUENCY_LIMITS"): "LIMITS",
    (waves, "SOFT_GAINS"): "SOFT",
    (waves, "PITCH_RATE_GAINS"): "DAMPED",
    (waves, "INTEGRAL_GAINS"): "LEARNT",
}
CLASHING: Final[dict[tuple[ModuleType, str], str]] = {  # names that two modules have, in C
    (ascent, "MIN_PITCH_RATE_GAIN"): "DAMPED_BUBBLE",
    (ascent, "MAX_STERN_ANGLE"): "MOST_STERN",
    (speed, "ANSWER_ERROR"): "FAR_SPEED",
    (trimming, "MAX_FREE_PLANES"): "FREE_PLANES",
    (trimming, "TRIM_MEMORY_S"): "TRIM_MEMORY",
    (hovering, "MAX_ERROR_GROWTH_M"): "HOVER_FURTHEST",
    (hovering, "MAX_CATCH_TIME_S"): "HOVER_LONGEST",
    (hovering, "MAX_SUCTION_ERROR_M"): "HOVER_NEAR",
    (hovering, "POLE_DAMPING"): "HOVER_POLES",
    (hovering, "SLOW_FREQUENCY"): "HOVER_SLOW",
    (hovering, "ZERO_DAMPING"): "HOVER_ZEROS",
    (sections, "MAX_HALF_ANGLE"): "LONGEST_STEP",
    (waves, "WAVE_MEMORY_S"): "WAVE_MEMORY",
    (waves, "POLE_DAMPING"): "PLANE_POLES",
    (waves, "ZERO_DAMPING"): "PLANE_ZEROS",
    (waves, "SLOW_FREQUENCY"): "SLOW_PITCH",
}


def header() -> str:
    """Return the text of records.h."""
    lines = ["/* Written from the layout of the trainer's records. */"]
    lines += ["#include <stddef.h>", "#include <stdint.h>"]
    for module, names in CONSTANTS:
        lines += [f"#define {name} {getattr(module, name)!r}" for name in names.split()]
    lines += [
        *(_table(name, 1 * getattr(casualties, name), "int") for name in CASUALTY_TABLES),
        *(_table(name, np.array(getattr(cosine_sum, name))) for name in SUM_TABLES),
        _table("ARCTANGENT", elementary.ARCTANGENT_COEFFICIENTS),
        _table("EIGHTHS", elementary.ARCTANGENT_EIGHTHS),
        _table("SIMILAR", np.array(filter_1969.SIMILAR_FREQUENCIES)),
        _table("TAPER", np.array(forces.TAPER_DIAMETERS)),
        _table("FADING", forces.FADING_FIT),
        _table("TABLE", filter_1969.WIND_TABLE),
        *(_table(name, np.array(getattr(wave_filter, name))) for name in FILTER_TABLES),
    ]
    for (module, name), known in CLASHING.items():
        lines.append(f"#define {known} {getattr(module, name)!r}")
    for (module, name), known in PILOT_TABLES.items():
        lines.append(_table(known, np.array(getattr(module, name))))
    for name, dtype in RECORDS.items():
        lines += _struct(name, dtype)
    return "\n".join(lines) + "\n"


def _table(name: str, values: np.ndarray, kind: str = "double") -> str:
    """Return an array of constants."""
    text = str(values.tolist()).replace("[", "{").replace("]", "}")
    return f"static const {kind} {name}{_shape(values.shape)} = {text};"


def _shape(shape: tuple[int, ...]) -> str:
    """Return the extents of an array in C."""
    return "".join(f"[{extent}]" for extent in shape)


class Place(NamedTuple):
    """A field of a record: its name, what it is, and where [bytes]."""

    name: str
    kind: np.dtype
    offset: int

    @property
    def declared(self) -> str:
        """Return the field as a member in C."""
        return f"{TYPES[self.kind.base.str[1:]]} {self.name}{_shape(self.kind.shape)};"


def _places(dtype: np.dtype) -> list[Place]:
    """Return the fields as they lie, a block before the numbers that it is made of."""
    fields = (dtype.fields or {}).items()
    places = [Place(name, at[0], at[1]) for name, at in fields if name != "whole"]
    return sorted(places, key=lambda place: (place.offset, -place.kind.itemsize))


def _struct(name: str, dtype: np.dtype) -> list[str]:
    """Return a record as a struct; blocks lie over the numbers that they are made of.

    The compiler refuses it where it is not laid out like the record.
    """
    places, block_ends = _places(dtype), 0
    lines = [f"struct {name} {{", "union { struct {"]
    for place, after in zip(places, [*places[1:], None], strict=True):
        follows = after.offset if after else dtype.itemsize
        if place.kind.shape and follows == place.offset:
            block_ends = place.offset + place.kind.itemsize
            lines.append(f"union {{ {place.declared} struct {{")
        else:
            lines.append(place.declared)
        if block_ends and follows >= block_ends:
            lines.append("}; };")
            block_ends = 0
    whole = f"double whole[{dtype.itemsize // 8}];" if "whole" in (dtype.names or ()) else ""
    lines += [f"}}; {whole} }};", "};", _assertion(f"sizeof(struct {name})", dtype.itemsize)]
    return lines + [_assertion(f"offsetof(struct {name}, {p.name})", p.offset) for p in places]


def _assertion(expression: str, value: int) -> str:
    """Return what makes the compiler refuse another value [bytes]."""
    return f'_Static_assert({expression} == {value}, "not laid out like the record");'


SOURCES: Final = Path(__file__).parent
COMMON: Final = ("-std=gnu11", "-fPIC", "-shared")

Ticks = Callable[[Records, int], int]  # so many ticks of a boat; the status of the last


class Build(NamedTuple):
    """One way to compile it."""

    name: str
    flags: tuple[str, ...]


# gcc 12 fuses a product and a sum in pairs that it finds by SLP, also where it is told not to
STRICT: Final = ("-O3", "-march=native", "-ffp-contract=off", "-fno-tree-slp-vectorize")
BUILDS: Final = (
    Build("gcc -O3", ("-O3",)),
    Build("strict, for this processor", STRICT),
    Build("contracted, for this processor", ("-O3", "-march=native", "-ffp-contract=fast")),
)
SAME_BITS: Final = BUILDS[:2]  # the third is another arithmetic


def compiler() -> list[str]:
    """Return the C compiler's command, CC or gcc or cc; NoCompilerError without one."""
    asked = os.environ.get("CC")
    for command in [asked] if asked else ["gcc", "cc"]:
        words = shlex.split(command)
        if words and shutil.which(words[0]):
            return words
    named = f"CC is {asked!r}, which is not here" if asked else "neither gcc nor cc is here"
    raise NoCompilerError(f"no C was compiled: {named}; install one, or name it by CC")


def version() -> str:
    """Return what the compiler calls itself."""
    done = subprocess.run([*compiler(), "--version"], capture_output=True, text=True, check=False)
    return done.stdout.partition("\n")[0] or compiler()[0]


def compile_source(source: Path, flags: Sequence[str]) -> ctypes.CDLL:
    """Return ``source`` compiled and loaded; NoCompilerError if that cannot be done."""
    with tempfile.TemporaryDirectory(prefix="trainer-") as folder:
        library = Path(folder) / "compiled.so"
        words = [*compiler(), *COMMON, *flags, str(source), "-o", str(library), "-lm"]
        done = subprocess.run(words, capture_output=True, text=True, check=False)
        if done.returncode != 0:
            raise NoCompilerError(f"{source.name} was not compiled: {done.stderr.strip()}")
        return ctypes.CDLL(str(library))  # which stays when its file goes


def build(way: Build) -> Ticks:
    """Return the tick in C, compiled and loaded; NoCompilerError if that cannot be done."""
    with tempfile.TemporaryDirectory(prefix="trainer-") as folder:
        (Path(folder) / "records.h").write_text(header(), encoding="ascii")
        take_ticks = compile_source(SOURCES / "tick.c", [*way.flags, f"-I{folder}"]).take_ticks
    address, number = ctypes.c_void_p, ctypes.c_int64
    take_ticks.argtypes = [address, address, address, number, address, address]
    take_ticks.restype = number

    def ticks(records: Records, count: int) -> int:
        vessel, compact, scheme, state, scratch = (each.ctypes.data for each in records)
        return int(take_ticks(vessel, compact, scheme, count, state, scratch))

    return ticks
