"""Vessel files: a name or path becomes a checked, complete, immutable record.

What a file leaves out comes from the shipped defaults file; no default stands in code.
``boat/assemble`` makes the records of the core of it.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path
from typing import Any

from trainer.config.boat import plausibility
from trainer.config.boat.ballast_records import Ballast, ballast_problems, ballast_remarks
from trainer.config.boat.coefficients import read_coefficients, read_compensation
from trainer.config.boat.plant_records import Plant, plant_problems
from trainer.config.boat.propulsion import (
    DRAG_ASTERN,
    ThrustRows,
    joint_remarks,
    thrust_of,
    thrust_problems,
)
from trainer.config.boat.vessel_records import (
    Autopilot,
    CompactTerms,
    Envelope,
    Fluid,
    FreeSurface,
    HeldTerms,
    Hull,
    Propulsion,
    RunDefaults,
    Scope,
    Surfaces,
    WaveStrips,
)
from trainer.config.files import (
    ConfigError,
    Position,
    collecting,
    nearest,
    parse_toml,
    path_named,
    quote_key,
    raise_problems,
    read_text,
    shipped_path,
)
from trainer.config.schema import Choice, Kind, Text, find_infinite, read_record
from trainer.config.ship.nomoto import NOMOTO_SCHEMA
from trainer.config.words import SHIP_FILE_SCHEMA
from trainer.core.terms import COEFFICIENTS, EXTRA_TERMS
from trainer.units import KNOT

VESSEL_SCHEMA = Choice(("gertler-hagen-2510/1",), "form of the coefficients")
HEADING_FIELDS: Mapping[str, Kind] = {
    "name": Text(200, "name shown"),
    "kind": Text(200, "for the reader, in any words: submarine, auv"),
    "scale": Text(200, "for the reader, in any words: full, or that of a model"),
}
# Keys and tables that tell where numbers come from: no run and no message depends on them.
# fmt: off
DOCUMENTARY_TABLES = (
    "source", "nondimensional", "calibration", "derived", "reduction", "estimate", "terms",
    "validity", "errata", "extra", "equivalent_2510_nonlinear", "notes", "covariance", "fit",
)
# fmt: on
DOCUMENTARY_KEYS: Mapping[str, tuple[str, ...]] = {
    "": ("kind", "scale"),
    "vessel": ("body_height", "body_width", "note"),
    "propulsion": (
        "model",
        "propeller",
        "KT",
        "thrust_deduction_deep",
        "wake_fraction",
        "rps_limit",
        "Cd0",
        "Ct",
        "eta_constant",
        "max_rpm",
        "thrust_N_at_1500rpm",
        "torque_Nm_at_1500rpm",
        "axial_drag_dim",
        "note",
    ),
    "control_surfaces": (
        "x_plane_mix",
        "stern_plane_position",
        "sail_plane_position",
        "stern_plane_area_each",
        "sail_plane_span_total",
        "stall_effective_deg",
        "ballast",
        "trim",
        "note",
    ),
    "envelope": ("note",),
    "run": ("note",),
    "autopilot": ("note",),
    "ballast": ("note",),
    "plant": ("note",),
    "free_surface": ("note",),
    "wave_strips": ("note",),
    "scope": ("note",),
}
VESSEL_RECORDS: Mapping[str, type[Any]] = {
    "fluid": Fluid,
    "vessel": Hull,
    "propulsion": Propulsion,
    "control_surfaces": Surfaces,
    "envelope": Envelope,
    "compact": CompactTerms,
    "reduce": HeldTerms,
    "run": RunDefaults,
    "autopilot": Autopilot,
    "ballast": Ballast,
    "plant": Plant,
    "free_surface": FreeSurface,
    "wave_strips": WaveStrips,
    "scope": Scope,
}
OPTIONAL_TABLES = (
    "reduce",
    "autopilot",
    "ballast",
    "plant",
    "free_surface",
    "wave_strips",
    "scope",
)
WHOLE_TABLES = ("compensation.modified", "compensation.basic")  # never filled key by key
KNOWN_KEYS = (
    "schema",
    *HEADING_FIELDS,
    *VESSEL_RECORDS,
    "coefficients",
    "compensation",
    *DOCUMENTARY_TABLES,
)


@dataclass(frozen=True, kw_only=True)
class VesselFile:
    """A vessel file as a whole, in its own units, with the defaults used."""

    path: Path
    text: str
    name: str
    fluid: Fluid
    hull: Hull
    propulsion: Propulsion
    thrust: ThrustRows  # the rows of propulsion, with what the file leaves out
    envelope: Envelope
    surfaces: Surfaces
    coefficients: Mapping[str, float]  # [-] all 122, prime system, zero where absent
    absent: tuple[str, ...]  # coefficients the file does not give
    compensation: Mapping[str, Mapping[str, float]]  # [-] by equation set, by coefficient
    compact: CompactTerms
    reduce: HeldTerms | None
    run: RunDefaults
    autopilot: Autopilot | None
    ballast: Ballast | None
    plant: Plant | None
    free_surface: FreeSurface | None
    wave_strips: WaveStrips | None
    scope: Scope | None
    defaulted: tuple[str, ...]  # tables, or table.key, taken from the defaults file
    remarks: tuple[str, ...]  # unusual, not wrong
    notes: tuple[str, ...]  # what the file itself says of its boat

    @property
    def has_compact_set(self) -> bool:
        """Return whether the file defines a compact set of its own."""
        lacking = {*self.defaulted}
        return not ({"compact", "compact.extra_terms"} & lacking) or not (
            {"compensation", "compensation.modified"} & lacking
        )

    @property
    def own_equations(self) -> str:
        """Return the set that this boat is flown by, full without a compact one."""
        return "modified" if self.has_compact_set else "full"


def load_vessel(name_or_path: str) -> VesselFile:
    """Return the shipped vessel of that name or the one in that file. ConfigError if it is wrong.

    Whatever has a path separator or ends in .toml is a path.
    """
    path = path_named(name_or_path, "vessels")
    return parse_vessel(read_text(path), path)


def parse_vessel(text: str, path: Path) -> VesselFile:
    """Return the vessel written in ``text``, which came from ``path``; ConfigError if it is wrong.

    The error lists all wrong values. Values that do not fit together are looked for only when each
    one is right by itself.
    """
    return read_vessel(parse_toml(text, path.name), text, path)


def with_defaults(table: Mapping[str, Any]) -> tuple[dict[str, Any], list[str]]:
    """Return a vessel's tables completed by the defaults, and the names of those keys."""
    defaults = shipped_path("", "defaults")
    return _fill_defaults(table, _defaults(read_text(defaults), defaults.name), "")


@cache
def _defaults(text: str, file: str) -> Mapping[str, Any]:
    """Return the tables of the defaults file. Callers share them and must not change them."""
    return parse_toml(text, file)


def read_vessel(given: Mapping[str, Any], text: str, path: Path) -> VesselFile:
    """Return the vessel of parsed tables, which came from ``text``; ConfigError as above."""
    position = Position(path.name, "")
    table, defaulted = with_defaults(given)
    parts = _read_parts(table, position)
    absent = tuple(term.key for term in COEFFICIENTS if term.key not in parts["coefficients"])
    parts["coefficients"] = dict.fromkeys(absent, 0.0) | parts["coefficients"]
    problems = _fit_problems(parts, position)
    raise_problems(problems)
    parts["vessel"] = with_deepest_order(parts["vessel"])
    thrust = _thrust(parts)
    remarks = {
        "vessel": plausibility.stated_remarks(parts["vessel"], parts["fluid"]),
        "propulsion": [
            *plausibility.thrust_remarks(thrust.ahead),
            *joint_remarks(thrust, _thrust_scale(parts)),
        ],
        "wave_strips": _strip_remarks(parts),
        "ballast": _tank_remarks(parts),
    }
    coefficients = parts.pop("coefficients")
    return VesselFile(
        path=path,
        text=text,
        name=table.get("name", path.stem),
        hull=parts.pop("vessel"),
        thrust=thrust,
        surfaces=parts.pop("control_surfaces"),
        coefficients={term.key: coefficients[term.key] for term in COEFFICIENTS},
        absent=absent,
        defaulted=tuple(defaulted),
        remarks=tuple(_name_positions(remarks, position)),
        notes=_notes(table.get("notes")),
        **{**dict.fromkeys(OPTIONAL_TABLES), **parts},
    )


def _notes(table: object) -> tuple[str, ...]:
    """Return the sentences of a file's notes, which may hold anything else too."""
    values = table.values() if isinstance(table, Mapping) else ()
    return tuple(text for text in values if isinstance(text, str))


def _tank_remarks(parts: Mapping[str, Any]) -> list[str]:
    """Return what is unusual about the tanks, if there are any."""
    if "ballast" not in parts:
        return []
    hull, fluid = parts["vessel"], parts["fluid"]
    return ballast_remarks(parts["ballast"], hull.buoyancy / (fluid.rho * fluid.g))


def _thrust(parts: Mapping[str, Any]) -> ThrustRows:
    """Return the thrust rows in use."""
    astern = parts["envelope"].drag_astern
    return thrust_of(parts["propulsion"].sets, DRAG_ASTERN if astern is None else astern)


def _thrust_scale(parts: Mapping[str, Any]) -> float:
    """Return rho/2 L^2 times the largest command speed squared [N]."""
    largest = parts["propulsion"].max_ordered_speed_kn * KNOT
    return float(0.5 * parts["fluid"].rho * (parts["vessel"].length * largest) ** 2)


def _strip_remarks(parts: Mapping[str, Any]) -> list[str]:
    """Return which added masses of the strips are not those of the coefficients."""
    table = parts.get("wave_strips")
    hull, fluid, coefficients = parts["vessel"], parts["fluid"], parts["coefficients"]
    return plausibility.wave_strip_remarks(table, coefficients, hull, fluid) if table else []


def with_deepest_order(hull: Hull) -> Hull:
    """Return the hull with a deepest order. It is the test depth where the file gives none."""
    deepest = hull.test_depth_m if hull.max_depth_m is None else hull.max_depth_m
    return replace(hull, max_depth_m=deepest)


def _fill_defaults(
    given: Mapping[str, Any], defaults: Mapping[str, Any], inside: str
) -> tuple[dict[str, Any], list[str]]:
    """Return ``given`` completed by ``defaults``, and the names of the keys added."""
    table = dict(given)
    names = []
    for key, default in defaults.items():
        if key not in given:
            table[key] = default
            names.append(inside + key)
        elif inside + key in WHOLE_TABLES:
            continue
        elif isinstance(default, Mapping) and isinstance(given[key], Mapping):
            table[key], deeper = _fill_defaults(given[key], default, f"{inside}{key}.")
            names += deeper
    return table, names


def _read_parts(table: Mapping[str, Any], position: Position) -> dict[str, Any]:
    """Return the checked tables by name; ConfigError with all that is wrong in any of them."""
    problems = _heading_problems(table, position)
    parts: dict[str, Any] = {}
    for name, record in VESSEL_RECORDS.items():
        if name in table or name not in OPTIONAL_TABLES:
            with collecting(problems):
                known = DOCUMENTARY_KEYS.get(name, ())
                parts[name] = read_record(record, table.get(name, {}), position.inside(name), known)
    with collecting(problems):
        if "coefficients" not in table:
            raise ConfigError(position.problem("lacks the table [coefficients]"))
        here = position.inside("coefficients")
        parts["coefficients"] = read_coefficients(table["coefficients"], here)
    with collecting(problems):
        extra = parts["compact"].extra_terms if "compact" in parts else EXTRA_TERMS
        here = position.inside("compensation")
        parts["compensation"] = read_compensation(table.get("compensation", {}), here, extra)
    raise_problems(problems)
    return parts


def _heading_problems(table: Mapping[str, Any], position: Position) -> list[str]:
    """Return the faults at the top level; ConfigError at once if it is another kind of file."""
    if table.get("schema") in (NOMOTO_SCHEMA, SHIP_FILE_SCHEMA):
        message = "is a ship, not a boat: trainer boat manoeuvre flies it"
        raise ConfigError(position.wrong("schema", table["schema"], message))
    if "schema" in table:
        VESSEL_SCHEMA.read("schema", table["schema"], position)
    problems: list[str] = []
    for key, value in table.items():
        if key in HEADING_FIELDS:
            with collecting(problems):
                HEADING_FIELDS[key].read(key, value, position)
        elif key in DOCUMENTARY_TABLES:
            problems += find_infinite(value, key, position)
        elif key not in KNOWN_KEYS and isinstance(value, Mapping):
            text = f"[{quote_key(key)}]: no such table{nearest(key, KNOWN_KEYS)}"
            problems.append(position.problem(text))
        elif key not in KNOWN_KEYS:
            problems.append(position.wrong(key, value, f"no such key{nearest(key, KNOWN_KEYS)}"))
    return problems


def _fit_problems(parts: Mapping[str, Any], position: Position) -> list[str]:
    """Return what does not fit together among checked tables, with file and table."""
    fluid, hull = parts["fluid"], parts["vessel"]
    problems = {
        "vessel": plausibility.hull_problems(hull, fluid),
        "coefficients": plausibility.added_mass_problems(parts["coefficients"], hull, fluid),
        "propulsion": plausibility.propulsion_problems(parts["propulsion"]),
        "run": plausibility.run_problems(parts["run"], hull),
        "envelope": plausibility.envelope_problems(parts["envelope"]),
    }
    if not problems["propulsion"]:
        problems["propulsion"] = thrust_problems(_thrust(parts), _thrust_scale(parts))
    if "autopilot" in parts:
        problems["autopilot"] = plausibility.autopilot_problems(
            parts["autopilot"], parts["coefficients"]
        )
    if "ballast" in parts:
        problems["ballast"] = ballast_problems(parts["ballast"])
    if "plant" in parts:
        problems["plant"] = plant_problems(parts["plant"])
    if "free_surface" in parts:
        problems["free_surface"] = plausibility.free_surface_problems(parts["free_surface"])
    if "wave_strips" in parts:
        strips = parts["wave_strips"]
        problems["wave_strips"] = plausibility.wave_strip_problems(strips, hull, fluid)
    return _name_positions(problems, position)


def _name_positions(found: Mapping[str, list[str]], position: Position) -> list[str]:
    """Return problems with file and table in front."""
    return [position.inside(name).problem(text) for name, texts in found.items() for text in texts]
