"""The vessel file of an estimated boat: every number with its unit and its basis.

``trainer boat estimate -o`` writes it. It flies at once, because the gains are designed here too.
Its table [estimate] has the standard deviations, from which ``trainer boat sweep`` draws boats.
"""

# long: one file, table by table
import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from itertools import pairwise
from pathlib import Path
from typing import Any, Final

from trainer import __version__
from trainer.analysis.check import EQUATION_SETS, round_speeds
from trainer.analysis.estimate.coefficients import (
    PLATE_DRAG,
    UNFITTED_FACTORS,
    Hull,
    cross_flow_drag,
    hull_of,
    on_both,
    panel_lift,
    plate_mass,
    resistance,
    revolutions,
    strip_masses,
)
from trainer.analysis.estimate.geometry import Panel, integral, panels_of_surface
from trainer.analysis.estimate.uncertainty import (
    Estimate,
    coefficient_origins,
    estimate_hull,
    range_warnings,
)
from trainer.analysis.gains import design_gains
from trainer.boat.assemble import Method, scheme_record
from trainer.boat.boat import Boat
from trainer.boat.stability import boat_responses, stable_at
from trainer.config.boat.coefficients import FORCE_AXES
from trainer.config.boat.hull import (
    BOW_CONTROL,
    RUDDER_CONTROL,
    STERN_CONTROL,
    X_CONTROL,
    list_defaults,
    load_hull,
)
from trainer.config.boat.plausibility import MASS_PRIME_RANGE
from trainer.config.boat.vessel import VesselFile, parse_vessel
from trainer.config.files import ConfigError, format_key, path_named, raise_problems, toml_value
from trainer.core.kernel import Numbers
from trainer.core.terms import COEFFICIENTS, TERM_TABLE
from trainer.units import KNOT

GRAVITY_M_S2: Final = 9.81  # [m/s2]
ROLL_RADIUS, PITCH_RADIUS = 0.36, 0.25  # [breadths], [lengths]: BB2 0.358, 0.251
STABILITY_HEIGHTS: Final = 0.05  # [heights] of the centre of buoyancy above that of gravity
PLANE_RATE_DEG_S: Final = 7.1  # [deg/s] of planes of a boat of 70 m
REFERENCE_LENGTH_M: Final = 70.0  # [m] the boat whose times are scaled
DEAD_TIME, TIME_CONSTANT = 3.0, 6.0  # [s] of its engine; own estimates
TELEGRAPH_BELLS: Final = {  # shares of the design speed; own estimates
    "ahead_one_third": 0.4,
    "ahead_two_thirds": 0.7,
    "ahead_standard": 0.85,
    "ahead_full": 1.0,
    "ahead_flank": 1.2,
    "astern_one_third": -0.25,
    "astern_two_thirds": -0.4,
    "astern_full": -0.6,
}
SLOWEST_GAIN_SPEED, FASTEST_GAIN_SPEED = 0.4, 1.2  # [design speeds] between which gains are made
TRIED_STEPS_S: Final = (0.5, 0.2, 0.1, 0.05, 0.02, 0.01, 0.005, 0.002)  # [s] the longest first
MAX_STEP_LENGTHS: Final = 0.1  # lengths run in a step, at most
# [rad] of a free roll in a step, at most: Adams feeds it by 0.9 % a cycle
MAX_ROLL_STEP_RAD: Final = 0.18
WAVE_STRIPS: Final = 7  # of the hull in waves
# [lengths] from the centre of gravity to that of the volume: with strips 0.005 off the centre of
# buoyancy a vessel file is refused
MAX_TRIM_ARM_LENGTHS: Final = 0.004
WIDE_STRIPS: Final = 5  # of the hull beyond the range of the coefficients
START_DEPTH_LENGTHS: Final = 0.85  # [lengths] of the start
MIN_START_DEPTH_M: Final = 5.0  # [m] of it
FIRST_KEY: Final = "schema"  # the key that a vessel file begins with
MASS_SLACK: Final = 0.3  # of the mass against the displaced
FILE_HEAD: Final = """\
# {name}: estimated from the drawing of its hull by `trainer boat estimate`, version {version}.
# Nothing here is measured. docs/own-hull.md says how it was made and how far it may be trusted.
# Body axes: x forward, y starboard, z down; the origin on the hull's axis, abeam of the centre of
# gravity. Each coefficient has its standard deviation (sd) and what it rests on."""
STUDY_TEXT: Final = """\
# Bands of a turn: draws of all coefficients of an estimated boat. Any other manoeuvre, or an
# exercise, may stand in the place of the turn: docs/sweeps.md.
schema = "sweep/1"
name = "Turns of an estimated boat"
vessel = {boat}
measures = ["advance", "tactical diameter", "steady diameter"]

[method]
equations = "full"

[manoeuvre]
name = "turning-circle"
angle_deg = {rudder:g}

[sample]
plan = "monte-carlo"
members = 200
seed = 1

[[vary]]
name = "draw"
key = "vessel"
distribution = "estimate"
"""


def open_hull(name_or_path: str) -> Hull:
    """Return a shipped hull by its name, or that of a file; ConfigError."""
    return check_hull(hull_of(load_hull(path_named(name_or_path, "hulls"))))


def check_hull(hull: Hull) -> Hull:
    """Return the hull; ConfigError with all that its shape and its panels forbid."""
    raise_problems([*_hull_problems(hull), *_part_problems(hull)])
    return hull


def _hull_problems(hull: Hull) -> Iterator[str]:
    """Yield why no boat has this shape, and why this hull cannot have the mass."""
    length, position = hull.file.form.length, hull.file.position
    prime = hull.shape.volume / (0.5 * length**3)
    if prime < MASS_PRIME_RANGE[0]:
        breadth = float(hull.shape.breadth.max())
        most = length * math.sqrt(prime / MASS_PRIME_RANGE[0]) / breadth
        problem = f"{length / breadth:.0f} breadths, must be at most {most:.0f}: is it in feet?"
        yield position.inside("hull").wrong("length", length, problem)
    given_mass, displaced = hull.file.mass.mass, hull.file.water.rho * hull.shape.volume
    if given_mass is not None and abs(given_mass / displaced - 1.0) > MASS_SLACK:
        problem = (
            f"must be rho V = {displaced:.6g} kg within {MASS_SLACK:.0%}, "
            f"{(1.0 - MASS_SLACK) * displaced:.6g} to {(1.0 + MASS_SLACK) * displaced:.6g} kg"
        )
        yield position.inside("mass").wrong("mass", given_mass, problem)


def _part_problems(hull: Hull) -> Iterator[str]:
    """Yield which panels lie inside the hull, and why the propeller cannot drive the boat."""
    for i, surface in enumerate(hull.file.surfaces):
        position = hull.file.position.inside(f"surfaces[{i}]")
        panel = next(panels_of_surface(surface, hull.shape))
        if panel.span <= 0.0:
            problem = f"must be above the hull's radius there, {panel.root:.4g} m"
            yield position.wrong("tip_radius", surface.tip_radius, problem)
        elif surface.moving_area is not None and surface.moving_area > panel.area * (1.0 + 1e-9):
            problem = f"must be at most the panel's area, {panel.area:.4g} m2"
            yield position.wrong("moving_area", surface.moving_area, problem)
    p, position = hull.file.propeller, hull.file.position.inside("propeller")
    if p is None:
        return
    widest = float(max(hull.shape.breadth.max(), hull.shape.height.max()))
    if p.diameter > widest:
        problem = f"must be at most the hull's greatest breadth, {widest:.4g} m"
        yield position.wrong("diameter", p.diameter, problem)
    elif revolutions(hull, resistance(hull)) is None:
        problem = (
            "no revolutions give the thrust that the hull needs; usual is [0.45, -0.36, -0.09]"
        )
        yield position.wrong("KT", list(p.KT), problem)


def round_to_digits(value: float) -> float:
    """Return a number to six digits."""
    return float(f"{value:.6g}") + 0.0


def mass_of(hull: Hull) -> float:
    """Return the boat's mass [kg], neutral where the file gives none."""
    given_mass = hull.file.mass.mass
    return hull.file.water.rho * hull.shape.volume if given_mass is None else given_mass


def estimate_of(hull: Hull) -> Estimate:
    """Return the estimate of a hull with its own mass."""
    return estimate_hull(hull, mass_of(hull))


def boat_tables(made: Estimate) -> dict[str, Any]:
    """Return the tables of the vessel, without gains."""
    hull, controls = made.hull, made.hull.file.controls
    kinds, rate = {panel.control for panel in hull.panels}, controls.rate_deg_s
    if rate is None:
        rate = PLANE_RATE_DEG_S * math.sqrt(REFERENCE_LENGTH_M / hull.ell)
    return {
        FIRST_KEY: "gertler-hagen-2510/1",
        "name": hull.file.name,
        "kind": "estimated from its drawing",
        "fluid": {"rho": hull.file.water.rho, "g": GRAVITY_M_S2},
        "vessel": _body(made),
        "propulsion": _propulsion(made),
        "control_surfaces": {
            "rudder_limit_deg": controls.limit_deg,
            "stern_plane_limit_deg": controls.limit_deg,
            "bow_plane_limit_deg": controls.limit_deg if BOW_CONTROL in kinds else 0.0,
            "rate_deg_s": round_to_digits(min(rate, 1000.0)),
            "time_constant_s": 0.0,
            "tail": "x" if X_CONTROL in kinds else "cruciform",
        },
        "envelope": _envelope(made),
        "run": _run(hull, TRIED_STEPS_S[0]),
        **_waves(made),
        "coefficients": {term.key: round_to_digits(made.values[term.key]) for term in COEFFICIENTS},
    }


def _body(made: Estimate) -> dict[str, Any]:
    """Return mass, centres and inertia; the origin is on the axis, abeam of the CG."""
    hull, mass, mass_table = made.hull, made.mass, made.hull.file.mass
    s = hull.shape
    breadth, height = float(s.breadth.max()), float(s.height.max())
    above = STABILITY_HEIGHTS * height if mass_table.cb_above_cg is None else mass_table.cb_above_cg
    pitch = mass * (PITCH_RADIUS * hull.ell) ** 2 if mass_table.Iy is None else mass_table.Iy
    table: dict[str, Any] = {
        "length": hull.ell,
        "mass": mass,
        "weight": mass * GRAVITY_M_S2,
        "buoyancy": mass * GRAVITY_M_S2,
        "cg": [0.0, 0.0, round_to_digits(mass_table.cg_below_axis)],
        "cb": [0.0, 0.0, round_to_digits(mass_table.cg_below_axis - above)],
        "Ix": mass * (ROLL_RADIUS * breadth) ** 2 if mass_table.Ix is None else mass_table.Ix,
        "Iy": pitch,
        "Iz": pitch if mass_table.Iz is None else mass_table.Iz,
        "beam": breadth,
        "cg_from_nose": s.x_G,
    }
    return {
        key: each if isinstance(each, list) else round_to_digits(each)
        for key, each in table.items()
    }


def _propulsion(made: Estimate) -> dict[str, Any]:
    """Return thrust rows, engine and bells."""
    hull, p = made.hull, made.hull.file.propeller
    design, scale = hull.file.speed.design_kn, math.sqrt(hull.ell / REFERENCE_LENGTH_M)
    table: dict[str, Any] = {}
    turns = revolutions(hull, resistance(hull))
    if p is not None and turns is not None:
        table = {
            "rps_per_mps": round_to_digits(turns),
            "propeller_diameter": p.diameter,
            "KT": [*p.KT],
            "KQ": [*p.KQ],
        }
    rows = []
    for suffix, least in (("1", 0.0), ("3", -99.0)):  # ahead, and with the engine astern
        terms = {name: round_to_digits(made.values[f"{name}{suffix}"]) for name in "abc"}
        rows.append({"eta_min": least, **terms})
    for row in rows:  # the sum is zero to the last bit, and the rows join
        row["a"] = -(rows[0]["b"] + rows[0]["c"])
    return {
        **table,
        "dead_time_s": round_to_digits(DEAD_TIME * scale),
        "time_constant_s": round_to_digits(TIME_CONSTANT * scale),
        "max_ordered_speed_kn": round_to_digits(FASTEST_GAIN_SPEED * design),
        "bells_kn": {
            name: round_to_digits(share * design) for name, share in TELEGRAPH_BELLS.items()
        },
        "sets": rows,
    }


def _envelope(made: Estimate) -> dict[str, Any]:
    """Return the table of forces beyond the range of the coefficients."""
    hull, s, c = made.hull, made.hull.shape, made.values
    drag = cross_flow_drag(hull) / s.ell**2
    tail = [panel for panel in hull.panels if panel.aft]
    sails = [panel for panel in hull.panels if panel.sail]
    bare = estimate_hull(Hull(hull.file, s, ()), made.mass).values
    edges = [s.length * (1.0 - i / WIDE_STRIPS) for i in range(WIDE_STRIPS + 1)]
    means = [_between(hull, s.breadth, fore, aft) / (aft - fore) for aft, fore in pairwise(edges)]
    table: dict[str, Any] = {
        "hull_share_horizontal": round_to_digits(min(1.0, abs(bare["Y_v"]) / abs(c["Y_v"]))),
        "hull_share_vertical": round_to_digits(min(1.0, abs(bare["Z_w"]) / abs(c["Z_w"]))),
        "strip_width": [round_to_digits(WIDE_STRIPS * mean / sum(means)) for mean in means],
        "crossflow_y": round_to_digits(drag * integral(s.height, s.x)),
        "crossflow_z": round_to_digits(drag * integral(s.breadth, s.x)),
    }
    if tail:
        at = sum(p.area * p.ahead(0.5) for p in tail) / sum(p.area for p in tail)
        table["tail_place"] = round_to_digits(max(at / s.ell, -0.6))
        for key, axis in (("tail_y", 0), ("tail_z", 1)):
            area = sum(p.area * abs(p.normal[axis]) for p in tail)
            table[key] = round_to_digits(PLATE_DRAG * area / s.ell**2)
    if sails:
        area = sum(p.area for p in sails)
        at, up = (
            sum(p.area * x for p, x in zip(sails, distances, strict=True)) / area
            for distances in ([p.ahead(0.5) for p in sails], [p.arm * p.normal[0] for p in sails])
        )
        mass = sum(plate_mass(p) * on_both(p.radius_ratio) * p.normal[0] ** 2 for p in sails)
        table |= {
            "sail_place": [round_to_digits(at), round_to_digits(-up)],
            "sail_y": round_to_digits(PLATE_DRAG * area / s.ell**2),
            **_sail_lift(made, sails),
            "sail_added_mass": round_to_digits(hull.file.water.rho * mass),
        }
    return table


def _sail_lift(made: Estimate, sails: list[Panel]) -> dict[str, Any]:
    """Return the sails' lift slope and where it acts, by their part of Y_v, N_v and K_v."""
    sailing = replace(made.hull, panels=tuple(sails))
    part, ell = panel_lift(sailing, UNFITTED_FACTORS | dict(made.constants)), made.hull.ell
    at = ell * part["N_v"] / part["Y_v"], -ell * part["K_v"] / part["Y_v"]
    return {
        "sail_lift": round_to_digits(-part["Y_v"]),
        "sail_lift_place": [*map(round_to_digits, at)],
    }


def _between(hull: Hull, values: Numbers, fore: float, aft: float) -> float:
    """Return an integral of one of the hull's numbers from ``fore`` to ``aft`` [m]."""
    s = hull.shape
    inside = (s.x >= fore) & (s.x <= aft)
    return integral(values[inside], s.x[inside])


def _run(hull: Hull, step: float) -> dict[str, Any]:
    """Return step, start and speeds."""
    design = hull.file.speed.design_kn
    depth = max(MIN_START_DEPTH_M, round(START_DEPTH_LENGTHS * hull.ell))
    ends = SLOWEST_GAIN_SPEED * design, FASTEST_GAIN_SPEED * design
    return {
        "step_s": step,
        "start_speed_kn": design,
        "start_depth_m": round_to_digits(depth),
        "speed_range_kn": [*map(round_to_digits, ends)],
    }


def _waves(made: Estimate) -> dict[str, Any]:
    """Return the strips for wave forces, none where buoyancy lies off the weight."""
    hull, s = made.hull, made.hull.shape
    if abs(s.centroid - s.x_G) > MAX_TRIM_ARM_LENGTHS * s.ell:
        return {}
    across, down = strip_masses(s)
    edges = [s.length * i / WAVE_STRIPS for i in range(WAVE_STRIPS + 1)]
    parts = list(pairwise(edges))
    volumes = [_between(hull, s.area, *part) for part in parts]
    per = made.mass / sum(volumes)
    k3 = 0.5 * hull.file.water.rho * s.ell**3
    added = {}
    ways = ("added_down_kg", "Z_wdot", down), ("added_side_kg", "Y_vdot", across)
    for key, coefficient, widths in ways:
        strips = [_between(hull, widths, *part) for part in parts]
        whole = -k3 * made.values[coefficient]
        added[key] = [round_to_digits(whole * each / sum(strips)) for each in strips]
    centres = [
        s.x_G - _between(hull, s.area * s.x, *part) / volume
        for part, volume in zip(parts, volumes, strict=True)
    ]
    return {
        "wave_strips": {
            "x_m": [round_to_digits(x) for x in centres],
            "displaced_kg": [round_to_digits(per * volume) for volume in volumes],
            **added,
        }
    }


def table_lines(name: str, table: Mapping[str, Any]) -> Iterator[str]:
    """Yield a table, its values first, then the tables in it."""
    inner = []
    yield from ("", f"[{name}]")
    for key, value in table.items():
        first = next(iter(value), None) if isinstance(value, list) else value
        if isinstance(first, Mapping):
            inner.append((f"{name}.{format_key(key)}", value))
        elif isinstance(first, list):  # a list of lists has a row a line
            yield f"{format_key(key)} = ["
            yield from (f"  {toml_value(row)}," for row in value)
            yield "]"
        else:
            yield f"{format_key(key)} = {toml_value(value)}"
    for where, value in inner:
        if isinstance(value, Mapping):
            yield from table_lines(where, value)
            continue
        for row in value:
            yield from ("", f"[[{where}]]")
            yield from (f"{format_key(k)} = {toml_value(x)}" for k, x in row.items())


def _coefficient_lines(made: Estimate, values: Mapping[str, float]) -> Iterator[str]:
    """Yield the coefficients by axis, each with its deviation and what it rests on."""
    for axis in FORCE_AXES:
        yield from ("", f"[coefficients.{axis}]")
        for term in COEFFICIENTS:
            if term.equation == axis:
                sd = f"sd {made.sd[term.key]:.2g}"
                note = f"# L^{term.power}, {sd}; {coefficient_origins()[term.key]}"
                yield f"{term.key} = {toml_value(values[term.key])}   {note}"


def boat_text(made: Estimate, tables: Mapping[str, Any]) -> str:
    """Return the vessel file of an estimate, without gains."""
    lines = FILE_HEAD.format(name=made.hull.file.name, version=__version__).splitlines()
    for key, value in tables.items():
        if key == "coefficients":
            lines += _coefficient_lines(made, value)
        elif isinstance(value, Mapping):
            lines += table_lines(key, value)
        else:
            lines.append(f"{key} = {toml_value(value)}")
    documentation = {  # what draws need, and what the reader should know
        "by": f"trainer boat estimate, version {__version__}",
        "outside": [*range_warnings(made.hull)],
        "defaulted": [*list_defaults(made.hull.file)],
        "covariance": [[round_to_digits(x) for x in row] for row in made.covariance.tolist()],
        "constants": {name: round_to_digits(x) for name, x in made.constants.items()},
        "sd": {term.key: float(f"{made.sd[term.key]:.3g}") for term in TERM_TABLE},
        "hull": dict(made.hull.file.tables),
    }
    return "\n".join([*lines, *table_lines("estimate", documentation)]) + "\n"


@dataclass(frozen=True)
class WrittenBoat:
    """The text of a vessel file, and the facts to print about the boat."""

    made: Estimate
    text: str
    file: VesselFile
    lacks: tuple[str, ...]  # what it could not be given, in words


def write_boat(hull: Hull, path: Path) -> WrittenBoat:
    """Return the boat of a hull, with a step and gains; ConfigError without one."""
    made = estimate_of(hull)
    tables = boat_tables(made)
    steps = stable_steps(parse_vessel(boat_text(made, tables), path))
    tables["run"] = _run(hull, steps[0] if steps else TRIED_STEPS_S[-1])
    kinds = {panel.control for panel in hull.panels}
    lacking = [name for name in (RUDDER_CONTROL, STERN_CONTROL) if not {name, X_CONTROL} & kinds]
    problem = "" if steps else f"no step of {TRIED_STEPS_S[-1]:g} s or longer is stable"
    if lacking:
        problem = f"no panel has control = {' or '.join(lacking)}"
    for step in [] if problem else steps:
        with_step = {**tables, "run": _run(hull, step)}
        try:
            gains = design_gains(parse_vessel(boat_text(made, with_step), path))
            text = boat_text(made, {**with_step, "autopilot": gains})
            return WrittenBoat(made, text, parse_vessel(text, path), ())
        except ConfigError as wrong:
            problem = problem or wrong.problems[0]
    text = boat_text(made, tables)
    return WrittenBoat(made, text, parse_vessel(text, path), (problem,))


def stable_steps(file: VesselFile) -> list[float]:
    """Return the steps [s] that are stable by all equation sets, the longest first."""
    speeds = [speed * KNOT for speed in round_speeds(*file.run.speed_range_kn)]
    flights, schemes = [], []
    for equations in EQUATION_SETS:
        method = Method(equations, "lagged", "exact", "adams2", file.run.step_s)
        flights.append(boat_responses(Boat(file, method), speeds).values())
        schemes.append(scheme_record(method))
    run = MAX_STEP_LENGTHS * file.hull.length / (file.run.start_speed_kn * KNOT)
    most = min(run, MAX_ROLL_STEP_RAD / max(roll_frequency(file), 1e-9))
    pairs, longest = [*zip(flights, schemes, strict=True)], max(most, TRIED_STEPS_S[-1])
    steps = [step for step in TRIED_STEPS_S if step <= longest]
    return [step for step in steps if all(stable_at(*pair, step) for pair in pairs)]


def roll_frequency(file: VesselFile) -> float:
    """Return the frequency [rad/s] of the free roll at rest; 0: it capsizes."""
    hull = file.hull
    righting = hull.weight * hull.cg[2] - hull.buoyancy * hull.cb[2]
    water = 0.5 * file.fluid.rho * hull.length**5 * file.coefficients["K_pdot"]
    return math.sqrt(max(righting, 0.0) / (hull.Ix - water))


def study_text(boat: str, rudder: float) -> str:
    """Return a study of turns of draws of a boat; ``rudder`` in degrees."""
    name = boat if "/" in boat else f"./{boat}"
    return STUDY_TEXT.format(boat=toml_value(name), rudder=rudder)
