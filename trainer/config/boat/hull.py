"""A hull by its drawing, from which ``trainer boat estimate`` makes a boat.

Lengths are in metres, masses in kg, angles in degrees, speeds in knots. x is counted aft from the
nose, heights up from the hull's axis.
"""

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from typing import Any, Final

from trainer.config.files import (
    ConfigError,
    Position,
    collecting,
    nearest,
    parse_toml,
    raise_problems,
    read_text,
)
from trainer.config.schema import (
    Choice,
    Flag,
    KeyForm,
    Quantities,
    Quantity,
    Rows,
    Text,
    above,
    list_schema,
    optional,
    read_record,
    required,
    with_default,
    within,
)

LENGTH_LIMITS_M: Final = within(0.3, 400.0)  # [m]
END_SHARE: Final = 0.03  # [-] of the length: a first or last station within it is at the end
POINTED_END_SHARE: Final = 0.2  # [-] of the greatest breadth: an end that is wider is blunt
MAX_TRAILING: Final = 1.1  # [-] of the length from the nose: no trailing edge lies further aft
# [-] least share of a panel's normal in the plane that it is to serve
MIN_NORMAL_SHARE: Final = 0.1
STERN_CONTROL, RUDDER_CONTROL, BOW_CONTROL, X_CONTROL = "stern", "rudder", "bow", "x"
CONTROL_KINDS: Final = ("none", STERN_CONTROL, RUDDER_CONTROL, BOW_CONTROL, X_CONTROL)
BOAT_NAME: Final = Text(200, "of the boat")
NECESSARY_TABLES: Final = ("hull", "speed")


def _size(meaning: str) -> Quantity:
    """Return a length [m] above zero."""
    return Quantity("m", above(0.0, 400.0), meaning)


def _number(unit: str, low: float, high: float, meaning: str) -> Quantity:
    """Return a number within limits, both ends included."""
    return Quantity(unit, within(low, high), meaning)


@dataclass(frozen=True)
class Stations:
    """The rows [x, breadth, height] of a hull, or with the height of their centre."""

    meaning: str
    fewest: int = 5
    most: int = 200

    @property
    def form(self) -> KeyForm:
        """Return unit, range and meaning, and the JSON Schema of its values."""
        rows = list_schema(list_schema({"type": "number"}, 3, 4), self.fewest, self.most)
        message = f"{self.fewest} to {self.most} rows of 3 or 4 numbers"
        return KeyForm("m", message, self.meaning, rows)

    def read(self, key: str, value: object, position: Position) -> tuple[tuple[float, ...], ...]:
        """Return the rows with four numbers each; ConfigError naming the first that is wrong."""
        if not isinstance(value, list) or not self.fewest <= len(value) <= self.most:
            message = f"must be {self.fewest} to {self.most} rows [x, breadth, height] in m"
            raise ConfigError(position.wrong(key, value, message))
        kind = Quantities(_number("m", -400.0, 400.0, ""), 3, 4)
        rows = [kind.read(f"{key}[{i}]", row, position) for i, row in enumerate(value)]
        for i, row in enumerate(rows):
            if min(row[:3]) < 0.0:
                raise ConfigError(
                    position.wrong(f"{key}[{i}]", value[i], "must not be negative, m")
                )
        for i, (before, row) in enumerate(pairwise(rows), start=1):
            if row[0] <= before[0]:
                message = f"x must rise: must be above {before[0]:g} m"
                raise ConfigError(position.wrong(f"{key}[{i}]", value[i], message))
        if not any(row[1] * row[2] > 0.0 for row in rows):
            raise ConfigError(position.wrong(key, value, "the area is nowhere above 0 m2"))
        return tuple((*row, 0.0)[:4] for row in rows)


@dataclass(frozen=True, kw_only=True)
class HullForm:
    """The bare hull, by stations or by a nose, a middle and a tail."""

    length: float = required("m", LENGTH_LIMITS_M, "over all")
    reference_length: float | None = optional(
        "m", LENGTH_LIMITS_M, "L of the coefficients; else length"
    )
    stations: tuple[tuple[float, ...], ...] | None = optional(
        Stations("[x, breadth, height] or with the centre above the axis; x rising, ends near zero")
    )
    breadth: float | None = optional(_size("greatest; instead of stations"))
    height: float | None = optional(_size("greatest; else breadth"))
    nose_length: float | None = optional(_size("else 1.5 breadths"))
    nose_exponent: float = with_default(
        2.0, _number("-", 1.0, 6.0, "(1-((x-a)/a)^2)^(1/n); else 2")
    )
    tail: str = with_default(
        "parabola", Choice(("parabola", "cone", "myring"), "form; else parabola")
    )
    tail_exponent: float = with_default(2.0, _number("-", 1.0, 6.0, "of a parabola; else 2"))
    tail_length: float | None = optional(_size("else 3 breadths"))
    tail_half_angle_deg: float | None = optional(_number("deg", 1.0, 60.0, "of a myring tail"))
    tail_cut: float | None = optional(_number("m", 0.0, 400.0, "cut off the end of a myring tail"))
    base_diameter: float = with_default(
        0.0, _number("m", 0.0, 400.0, "at the end of the tail; else 0")
    )
    section: str = with_default(
        "ellipse", Choice(("ellipse", "box"), "form of a section; else ellipse")
    )
    section_fullness: float | None = optional(
        _number("-", 0.7, 1.28, "area over that of the ellipse; else 1, of a box 1.15")
    )


@dataclass(frozen=True, kw_only=True)
class Mass:
    """The submerged boat's mass, with the water in its free-flooding spaces."""

    mass: float | None = optional("kg", above(0.0, 1e9), "else neutral: rho V")
    cg_from_nose: float | None = optional(_number("m", 0.0, 400.0, "else the volume's centroid"))
    cg_below_axis: float = with_default(0.0, _number("m", -50.0, 50.0, "else 0"))
    cb_above_cg: float | None = optional(_number("m", -50.0, 50.0, "else 0.05 heights"))
    Ix: float | None = optional("kg m2", above(0.0, 1e13), "else mass (0.36 breadth)^2")
    Iy: float | None = optional("kg m2", above(0.0, 1e13), "else mass (0.25 L)^2")
    Iz: float | None = optional("kg m2", above(0.0, 1e13), "else Iy")


@dataclass(frozen=True, kw_only=True)
class Water:
    """The water."""

    rho: float = with_default(1025.0, _number("kg/m3", 900.0, 1100.0, "density; else 1025"))
    nu: float = with_default(
        1.19e-6, _number("m2/s", 5e-7, 3e-6, "kinematic viscosity; else 1.19e-6")
    )


@dataclass(frozen=True, kw_only=True)
class Speed:
    """The speed that the boat is made for, and its resistance."""

    design_kn: float = required("kn", above(0.0, 50.0), "for resistance and the bells")
    roughness: float = with_default(
        0.0004, _number("-", 0.0, 0.005, "added to friction; else 0.0004")
    )
    extra_drag_area: float = with_default(
        0.0, _number("m2", 0.0, 100.0, "C_d A of openings, masts, brackets; else 0")
    )
    cross_flow_drag: float | None = optional(
        _number("-", 0.1, 3.0, "else 0.55, of small or slow hulls 1.1")
    )


@dataclass(frozen=True, kw_only=True)
class Propeller:
    """One propeller aft. Without it thrust is drag at command speed, ahead and astern."""

    diameter: float = required("m", above(0.0, 20.0), "of the propeller")
    KT: tuple[float, ...] = with_default(
        (0.45, -0.36, -0.09), Quantities(_number("-", -10.0, 10.0, "of J^0, J, J^2"), 3, 3)
    )
    KQ: tuple[float, ...] = with_default(
        (0.064, -0.032, -0.021), Quantities(_number("-", -10.0, 10.0, "of J^0, J, J^2"), 3, 3)
    )
    wake: float = with_default(0.25, _number("-", 0.0, 0.6, "wake fraction; else 0.25"))
    thrust_deduction: float = with_default(0.15, _number("-", 0.0, 0.6, "else 0.15"))
    clockwise_from_astern: bool = with_default(True, Flag("turning ahead; else true"))  # noqa: FBT003
    swirl_recovered: float = with_default(
        0.5, _number("-", 0.0, 1.0, "share of the torque that comes back on the tail; else 0.5")
    )


@dataclass(frozen=True, kw_only=True)
class Controls:
    """The limits of rudder and planes."""

    limit_deg: float = with_default(30.0, _number("deg", 1.0, 90.0, "either way; else 30"))
    rate_deg_s: float | None = optional(_number("deg/s", 0.01, 1000.0, "else 7.1 sqrt(70/L)"))


@dataclass(frozen=True, kw_only=True)
class Panels:
    """Equal panels about the hull: planes, rudders, a sail."""

    name: str = required(Text(60, "name shown"))
    angles_deg: tuple[float, ...] = required(
        Quantities(
            _number("deg", 0.0, 360.0, "a panel each: 0 starboard, 90 up, 180 port, 270 down"), 1, 8
        )
    )
    control: str = with_default("none", Choice(CONTROL_KINDS, "what it steers; else none"))
    sail: bool = with_default(False, Flag("a sail, or a deck casing; else false"))  # noqa: FBT003
    le_root: float = required(
        _number("m", -400.0, 400.0, "leading edge at the root, aft of the nose")
    )
    root_chord: float = required(_size("chord at the root"))
    tip_chord: float = required(_size("chord at the tip"))
    tip_radius: float = required(_size("from the axis, or from axis_up"))
    root_radius: float | None = optional(_number("m", 0.0, 400.0, "else that of the hull there"))
    le_tip: float | None = optional(_number("m", -400.0, 400.0, "else trailing edges in line"))
    moving_area: float | None = optional("m2", above(0.0, 1e4), "else the whole panel")
    flap_ratio: float = with_default(
        1.0, _number("-", 0.05, 1.0, "chord of a flap over the whole; 1")
    )
    thickness: float = with_default(0.15, _number("-", 0.01, 0.6, "over the chord; else 0.15"))
    axis_up: float = with_default(
        0.0, _number("m", -50.0, 50.0, "height that radii count from; else 0")
    )


@dataclass(frozen=True, kw_only=True)
class HullFile:
    """A hull file as a whole, checked."""

    path: Path
    name: str
    form: HullForm
    mass: Mass
    water: Water
    speed: Speed
    propeller: Propeller | None
    controls: Controls
    surfaces: tuple[Panels, ...]
    tables: Mapping[str, Any]  # as written

    @property
    def length(self) -> float:
        """Return the reference length L [m] of the coefficients."""
        return self.form.reference_length or self.form.length

    @property
    def position(self) -> Position:
        """Return the position that messages name."""
        return Position(self.path.name, "")


SURFACE_ROWS: Final = Rows(Panels, ("note",), 1, 40, "surfaces, below")
HULL_TABLES: Final[Mapping[str, type[Any]]] = {
    "hull": HullForm,
    "mass": Mass,
    "fluid": Water,
    "speed": Speed,
    "propeller": Propeller,
    "controls": Controls,
}
KNOWN_KEYS: Final = ("name", "note", *HULL_TABLES, "surfaces")
KNOWN_KEYS_TEXT: Final = ", ".join(KNOWN_KEYS)


def load_hull(path: Path) -> HullFile:
    """Return the hull of a file; ConfigError with all that is wrong."""
    return read_hull(parse_toml(read_text(path), path.name), path)


def read_hull(given: Mapping[str, Any], path: Path) -> HullFile:
    """Return the hull of parsed tables; ConfigError with all that is wrong."""
    position = Position(path.name, "")
    if "schema" in given or "vessel" in given:  # a hull has neither
        given_as = "a vessel" if "vessel" in given else f"of the form {given['schema']!r}"
        text = f"is {given_as}; wanted is a hull, as `trainer boat estimate new FILE` writes one"
        raise ConfigError(position.problem(text))
    problems = [
        position.wrong(
            key, value, f"no such key{nearest(key, KNOWN_KEYS) or f'; there are {KNOWN_KEYS_TEXT}'}"
        )
        for key, value in given.items()
        if key not in KNOWN_KEYS
    ]
    lacking = [key for key in ("name", *NECESSARY_TABLES, "surfaces") if key not in given]
    if lacking:
        problems.append(position.problem(f"lacks {', '.join(lacking)}"))
    parts: dict[str, Any] = {"propeller": None}
    for name, record in HULL_TABLES.items():
        if name in given or name not in (*NECESSARY_TABLES, "propeller"):
            with collecting(problems):
                here = position.inside(name)
                parts[name] = read_record(record, given.get(name, {}), here, ("note",))
    for name, kind in (("name", BOAT_NAME), ("surfaces", SURFACE_ROWS)):
        with collecting(problems):
            parts[name] = kind.read(name, given[name], position) if name in given else None
    raise_problems(problems)
    file = HullFile(
        path=path, form=parts.pop("hull"), water=parts.pop("fluid"), tables=given, **parts
    )
    problems = [*_form_problems(file), *_mass_problems(file), *_surface_problems(file)]
    raise_problems(problems)
    return file


def list_defaults(file: HullFile) -> tuple[str, ...]:
    """Return the keys, and the whole tables, that the file leaves out.

    The estimate's page and the boat's file name them, because a default is a guess about this boat.
    """
    names = []
    for name, record in HULL_TABLES.items():
        table = file.tables.get(name)
        if table is None:
            names.append(name)
            continue
        skipped = ("stations", *_skipped(file)) if name == "hull" else ()
        names += [
            f"{name}.{key}"
            for key in record.__dataclass_fields__
            if key not in table and key not in skipped
        ]
    return tuple(names)


def _skipped(file: HullFile) -> tuple[str, ...]:
    """Return the keys of [hull] that this kind of hull does not use."""
    form = file.form
    tail = {
        "parabola": ("tail_half_angle_deg", "tail_cut"),
        "cone": ("tail_exponent", "tail_half_angle_deg", "tail_cut"),
        "myring": ("tail_exponent", "base_diameter"),
    }[form.tail]
    by_stations = tuple(
        key
        for key in HullForm.__dataclass_fields__
        if key.startswith(("nose", "tail")) or key in ("breadth", "height", "base_diameter")
    )
    return by_stations if form.stations else tail


def _form_problems(file: HullFile) -> Iterator[str]:
    """Yield what does not fit about the bare hull."""
    form, position = file.form, file.position.inside("hull")
    if (form.stations is None) == (form.breadth is None):
        yield position.problem("give one of stations, breadth")
    elif form.stations is not None:
        yield from _station_problems(file)
    else:
        yield from _nose_and_tail_problems(file)
    if form.reference_length and not 0.8 <= form.reference_length / form.length <= 1.25:
        message = f"must be about length = {form.length:g} m, 0.8 to 1.25 of it"
        yield position.wrong("reference_length", form.reference_length, message)


def _station_problems(file: HullFile) -> Iterator[str]:
    """Yield what does not fit about stations."""
    form, position = file.form, file.position.inside("hull")
    rows = form.stations or ()
    first, last = rows[0], rows[-1]
    if last[0] > form.length * (1.0 + 1e-9) or first[0] < 0.0:
        message = f"x must lie within 0 to length = {form.length:g} m"
        yield position.problem(f"stations: {first[0]:g} to {last[0]:g} m: {message}")
        return
    widest = max(max(row[1:3]) for row in rows)
    for name, row, at in (("first", first, 0.0), ("last", last, form.length)):
        if abs(row[0] - at) > END_SHARE * form.length:
            yield position.problem(f"stations: the {name} x = {row[0]:g} m: must be near {at:g} m")
        elif max(row[1:3]) > POINTED_END_SHARE * widest:
            message = f"must be near 0, at most {POINTED_END_SHARE * widest:.3g} m"
            yield position.problem(f"stations: the {name} is {max(row[1:3]):g} m wide: {message}")


def _nose_and_tail_problems(file: HullFile) -> Iterator[str]:
    """Yield what does not fit about a hull of nose, middle and tail."""
    form, position = file.form, file.position.inside("hull")
    breadth = form.breadth or 0.0
    nose = form.nose_length or 1.5 * breadth
    tail = form.tail_length or 3.0 * breadth
    if nose + tail > form.length:
        message = f"nose {nose:g} m and tail {tail:g} m must not be longer than length"
        yield position.wrong("length", form.length, f"{message}; nearest is {nose + tail:g} m")
    if max(breadth, form.height or 0.0) > form.length / 2.0:
        message = f"must be at most half of length, {form.length / 2.0:g} m"
        yield position.wrong("breadth", breadth, message)
    if form.base_diameter >= breadth:
        yield position.wrong("base_diameter", form.base_diameter, f"must be below {breadth:g} m")
    if form.tail == "myring":
        lacks = [key for key in ("tail_half_angle_deg", "tail_cut") if getattr(form, key) is None]
        yield from (position.problem(f"lacks {key}: tail = myring needs it") for key in lacks)


def _mass_problems(file: HullFile) -> Iterator[str]:
    """Yield what does not fit about the centres."""
    position, mass, length = file.position.inside("mass"), file.mass, file.form.length
    low, high = 0.2 * length, 0.8 * length
    if mass.cg_from_nose is not None and not low <= mass.cg_from_nose <= high:
        message = f"must be in the middle 60 %, {low:g} to {high:g} m"
        yield position.wrong("cg_from_nose", mass.cg_from_nose, message)
    if mass.cb_above_cg is not None and mass.cb_above_cg <= 0.0:
        message = "must be above 0 m: the centre of buoyancy must be above that of gravity"
        yield position.wrong("cb_above_cg", mass.cb_above_cg, message)


def _surface_problems(file: HullFile) -> Iterator[str]:
    """Yield what does not fit about each surface."""
    for i, panels in enumerate(file.surfaces):
        position = file.position.inside(f"surfaces[{i}]")
        yield from _panel_problems(panels, position, file.form.length)
        # yield which panels cannot serve the control that they are given
        if panels.sail and panels.control != "none":
            yield position.wrong("control", panels.control, "a sail steers nothing; must be none")
        for angle in panels.angles_deg:
            across, down = abs(math.sin(math.radians(angle))), abs(math.cos(math.radians(angle)))
            wanted = {
                STERN_CONTROL: down,
                BOW_CONTROL: down,
                RUDDER_CONTROL: across,
                X_CONTROL: min(across, down),
            }
            if wanted.get(panels.control, 1.0) < MIN_NORMAL_SHARE:
                right = {RUDDER_CONTROL: "90 or 270", X_CONTROL: "45, 135, 225 or 315"}
                message = f"no {panels.control} can act there; nearest are"
                yield position.wrong(
                    "angles_deg", angle, f"{message} {right.get(panels.control, '0 or 180')} deg"
                )


def _panel_problems(panels: Panels, position: Position, length: float) -> Iterator[str]:
    """Yield what does not fit about the outline of a panel."""
    root = panels.root_radius
    if root is not None and panels.tip_radius <= root:
        yield position.wrong(
            "tip_radius", panels.tip_radius, f"must be above root_radius, {root:g} m"
        )
    for key in ("le_root", "le_tip"):
        at = getattr(panels, key)
        if at is not None and at < 0.0:
            yield position.wrong(key, at, "must not be ahead of the nose: must be 0 m or more")
    trailing = panels.le_root + panels.root_chord
    if trailing > MAX_TRAILING * length:
        message = f"trailing edge at {trailing:g} m, must be at most {MAX_TRAILING * length:g} m"
        yield position.wrong("le_root", panels.le_root, message)
    if panels.root_radius is not None:
        span = panels.tip_radius - panels.root_radius
        area = 0.5 * (panels.root_chord + panels.tip_chord) * span
        if panels.moving_area is not None and panels.moving_area > area > 0.0:
            message = f"must be at most the panel's area, {area:.4g} m2"
            yield position.wrong("moving_area", panels.moving_area, message)
