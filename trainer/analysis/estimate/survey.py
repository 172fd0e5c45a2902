"""An estimated boat in figures: margins, critical speeds, a turn with bands, influences.

``trainer boat estimate`` shows them. Each is computed for drawn boats as well, and its band is what
the method's uncertainty makes of it. The influences say which numbers of the drawing matter most.
"""

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import MISSING, dataclass, fields
from itertools import product
from typing import Any, Final

import numpy as np

from trainer.analysis.check import critical_speeds, margins, straight_flights
from trainer.analysis.estimate.boat_file import (
    STABILITY_HEIGHTS,
    WrittenBoat,
    boat_tables,
    estimate_of,
    mass_of,
)
from trainer.analysis.estimate.coefficients import cross_flow_drag, hull_of
from trainer.analysis.estimate.uncertainty import drawn_tables, range_warnings
from trainer.analysis.manoeuvres.flight import fly_manoeuvre
from trainer.analysis.manoeuvres.submarine import Rig, Submarine
from trainer.analysis.manoeuvres.turns import Turn
from trainer.boat.assemble import Method
from trainer.config.boat.hull import HULL_TABLES, HullFile, Panels, list_defaults, read_hull
from trainer.config.boat.vessel import VesselFile, read_vessel
from trainer.config.files import ConfigError, parse_toml
from trainer.units import KNOT

DIAMETER_MEASURE: Final = "steady diameter"
MEASURE_UNITS: Final = {  # unit by name
    **dict.fromkeys((DIAMETER_MEASURE, "tactical diameter", "advance"), "m"),
    "steady speed, of the first": "-",
}
BAND_PERCENTILES: Final = {"68 %": (16.0, 84.0), "95 %": (2.5, 97.5)}
TURN_RUDDER_SHARE: Final = 0.5  # of the limit, the rudder in the turn
TURN_LENGTHS: Final = 60.0  # [lengths] of the turn, at its first speed
MAX_TURN_TICKS: Final = 20_000  # [ticks] of it, at any step
MIN_TURN_S: Final = 10.0  # [s]
INPUT_CHANGE: Final = 0.1  # of an input, up and down
STATION_SHIFT: Final = 0.01  # [lengths] of a station, aft and forward
SHIFTED_STATIONS: Final = ("le_root", "cg_from_nose")  # what is shifted
FOLLOWING_STATIONS: Final = {"le_root": "le_tip"}  # what is shifted with it
NOT_VARIED: Final = ("reference_length", "le_tip", "design_kn", "length", "rho", "nu")
KEPT_TABLES: Final = ("run", "autopilot")  # of the estimate, by boats of changed hulls
MAX_INPUTS: Final = 10  # inputs shown, those that matter most
# of the design speed: a stern plane reversal above it is reported
REVERSAL_SPEED_SHARE: Final = 0.7
MASS_SLACK: Final = 0.02  # of the mass against the displaced
FASTEST_FROUDE, LONGEST_BOAT_M = 1.5, 200.0  # [-], [m]: beyond them a unit is likely another


@dataclass(frozen=True)
class EstimateBand:
    """One figure: its estimate, and the bands of 68 % and 95 % of draws."""

    name: str
    unit: str
    value: float | None
    bands: dict[str, tuple[float, float] | None]  # by per cent


@dataclass(frozen=True)
class Influence:
    """The effect of one input on the steady diameter of the turn."""

    key: str
    value: float
    unit: str
    change: str  # how far it was moved, in words
    down: float | None  # [-] of the diameter, the input lower
    up: float | None

    @property
    def size(self) -> float:
        """Return the larger effect [-]."""
        return max(abs(each) for each in (self.down or 0.0, self.up or 0.0))


@dataclass(frozen=True)
class Survey:
    """All that ``trainer boat estimate`` says about a boat."""

    vessel: str
    path: str
    mass_kg: float
    displaced_kg: float
    step_s: float
    limit_deg: float  # of rudder and planes
    rate_deg_s: float
    margins: tuple[EstimateBand, ...]
    critical_speed_kn: dict[str, float | None]
    roll_period_s: float | None
    speed_kn: float
    rudder_deg: float
    turn: tuple[EstimateBand, ...]
    draws: int
    flown: int  # draws that could fly the turn
    influences: tuple[Influence, ...]
    defaulted: tuple[str, ...]
    warnings: tuple[str, ...]


def turns_of(written: WrittenBoat, draws: int) -> int:
    """Return how many turns a survey flies at most."""
    return 1 + draws + 2 * len(inputs_of(written.made.hull.file))


def survey_boat(written: WrittenBoat, draws: int, heard: Callable[[int], object]) -> Survey:
    """Return what there is to say about a boat, with ``draws`` of its coefficients.

    ``heard`` is called with the number of turns flown since its last call. Each boat is made when
    its turn comes, because boats of many panels take longer to make than to fly.
    """
    file, hull = written.file, written.made.hull
    tables = parse_toml(written.text, file.path.name)
    own_turn, turns, by_draw = fly_turn(file), [], []
    heard(1)
    for number in range(1, draws + 1):
        drawn = read_vessel(drawn_tables(written.made, tables, number), written.text, file.path)
        turns.append(fly_turn(drawn))
        by_draw.append(margins(drawn))
        heard(1)
    (flight,) = straight_flights(file, [file.run.start_speed_kn])
    rolls = (mode.period_s for mode in flight.modes if mode.name.startswith("roll"))
    flown = [each for each in turns if each is not None]
    critical = critical_speeds(file)
    return Survey(
        vessel=file.name,
        path=str(file.path),
        mass_kg=file.hull.mass,
        displaced_kg=hull.file.water.rho * hull.shape.volume,
        step_s=file.run.step_s,
        limit_deg=file.surfaces.rudder_limit_deg,
        rate_deg_s=file.surfaces.rate_deg_s,
        margins=tuple(
            _band(name, "-", value, [by_name[name] for by_name in by_draw])
            for name, value in margins(file).items()
        ),
        critical_speed_kn=critical,
        roll_period_s=next((period for period in rolls if period is not None), None),
        speed_kn=file.run.start_speed_kn,
        rudder_deg=math.degrees(half_rudder(file)),
        turn=tuple(
            _band(name, unit, (own_turn or {}).get(name), [each.get(name) for each in flown])
            for name, unit in MEASURE_UNITS.items()
        ),
        draws=draws,
        flown=len(flown),
        influences=tuple(influences(written, own_turn, heard)),
        defaulted=list_defaults(hull.file),
        warnings=tuple(warnings(written, critical)),
    )


def half_rudder(file: VesselFile) -> float:
    """Return half the rudder's limit [rad]."""
    return math.radians(TURN_RUDDER_SHARE * file.surfaces.rudder_limit_deg)


def fly_turn(file: VesselFile, rudder: float | None = None) -> dict[str, float] | None:
    """Return the measures of a turn by the full set, None without one.

    ``rudder`` [rad] is half the limit where it is not given.
    """
    method = Method("full", "lagged", "exact", "adams2", file.run.step_s)
    speed = file.run.start_speed_kn * KNOT
    time = min(TURN_LENGTHS * file.hull.length / speed, MAX_TURN_TICKS * method.step)
    rudder = half_rudder(file) if rudder is None else rudder
    turn = Turn(angle_deg=math.degrees(rudder), duration_s=max(time, MIN_TURN_S))
    boat = Submarine(file, method, Rig("own", "own", "trainer"))
    try:
        flight = fly_manoeuvre(boat, turn, speed)
    except ConfigError:
        return None
    if flight.lost:
        return None
    measured = {one.name: one.value for one in turn.measures(flight)}
    return {name: value for name in MEASURE_UNITS if (value := measured[name]) is not None}


def _band(name: str, unit: str, value: float | None, drawn: Sequence[float | None]) -> EstimateBand:
    """Return a figure with the bands of its draws."""
    values = np.array([each for each in drawn if each is not None and math.isfinite(each)])
    bands: dict[str, tuple[float, float] | None] = dict.fromkeys(BAND_PERCENTILES)
    if len(values) > 1:
        for band, ends in BAND_PERCENTILES.items():
            low, high = np.percentile(values, ends)
            bands[band] = (float(low), float(high))
    return EstimateBand(name, unit, value, bands)


@dataclass(frozen=True)
class HullInput:
    """A number of a hull file that can be changed."""

    key: str
    unit: str
    steps: tuple[str | int, ...]
    value: float
    shifted: bool  # else scaled


def inputs_of(file: HullFile) -> list[HullInput]:
    """Return the numbers of a hull, with defaults for those that its file lacks."""
    hull = hull_of(file)
    used = {
        ("mass", "mass"): mass_of(hull),
        ("mass", "cg_from_nose"): hull.shape.x_G,
        ("mass", "cb_above_cg"): STABILITY_HEIGHTS * float(hull.shape.height.max()),
        ("speed", "cross_flow_drag"): cross_flow_drag(hull),
    }
    inputs: list[HullInput] = []
    for table, record in HULL_TABLES.items():
        if table != "propeller" or file.propeller is not None:
            inputs += _inputs(record, file.tables.get(table, {}), (table,), used)
    if file.form.stations:
        inputs += [
            HullInput(f"hull.stations, {name}", "m", ("stations", k), 1.0, shifted=False)
            for k, name in ((1, "breadth"), (2, "height"))
        ]
    for i, row in enumerate(file.tables["surfaces"]):
        inputs += _inputs(Panels, row, ("surfaces", i), {})
    return inputs


def _inputs(
    record: type[Any],
    given: Mapping[str, Any],
    steps: tuple[str | int, ...],
    used: Mapping[tuple[Any, ...], float],
) -> Iterator[HullInput]:
    """Yield the numbers of one table."""
    for item in fields(record):
        default = None if item.default is MISSING else item.default
        where = (*steps, item.name)
        value = given.get(item.name, used.get(where, default))
        number = isinstance(value, int | float) and not isinstance(value, bool)
        if number and value and item.name not in NOT_VARIED:
            key = ".".join(str(step) for step in where)
            if steps[0] == "surfaces":
                key = f"{given['name']}: {item.name}"
            unit = item.metadata["kind"].form.unit
            yield HullInput(key, unit, where, float(value), item.name in SHIFTED_STATIONS)


def change_hull(file: HullFile, one: HullInput, sign: float) -> HullFile:
    """Return the hull with one input changed; ConfigError if there is no such hull."""
    tables: dict[str, Any] = {
        key: dict(value) if isinstance(value, Mapping) else value
        for key, value in file.tables.items()
    }
    if one.steps[0] == "stations":
        k = one.steps[1]
        tables["hull"]["stations"] = [
            [x * (1.0 + sign * INPUT_CHANGE) if j == k else x for j, x in enumerate(row)]
            for row in tables["hull"]["stations"]
        ]
        return read_hull(tables, file.path)
    shift = sign * STATION_SHIFT * file.length if one.shifted else sign * INPUT_CHANGE * one.value
    name = str(one.steps[-1])
    if one.steps[0] == "surfaces":
        tables["surfaces"] = [dict(row) for row in tables["surfaces"]]
        table = tables["surfaces"][one.steps[1]]
    else:
        table = tables.setdefault(str(one.steps[0]), {})
    table[name] = one.value + shift
    follower = FOLLOWING_STATIONS.get(name)
    if follower in table:
        table[follower] += shift
    return read_hull(tables, file.path)


def influences(
    written: WrittenBoat, turn: dict[str, float] | None, heard: Callable[[int], object]
) -> list[Influence]:
    """Return the ten inputs that move the steady diameter most."""
    own_diameter = (turn or {}).get(DIAMETER_MEASURE)
    if own_diameter is None:
        return []
    file = written.made.hull.file
    own_tables = parse_toml(written.text, written.file.path.name)
    kept: dict[str, Any] = {key: own_tables[key] for key in KEPT_TABLES if key in own_tables}
    rudder = half_rudder(written.file)
    effect: dict[HullInput, dict[float, float]] = {}
    for one, sign in product(inputs_of(file), (-1.0, 1.0)):
        boat = _changed_boat(written, kept, one, sign)
        changed_turn = None if boat is None else fly_turn(boat, rudder)
        if changed_turn is not None and DIAMETER_MEASURE in changed_turn:
            share = changed_turn[DIAMETER_MEASURE] / own_diameter - 1.0
            effect.setdefault(one, {})[sign] = share
        heard(1)
    ranked = []
    for one, by_sign in effect.items():
        change = f"{STATION_SHIFT * file.length:.3g} m" if one.shifted else f"{INPUT_CHANGE:.0%}"
        ends = by_sign.get(-1.0), by_sign.get(1.0)
        ranked.append(Influence(one.key, one.value, one.unit, change, *ends))
    return sorted(ranked, key=lambda each: -each.size)[:MAX_INPUTS]


def _changed_boat(
    written: WrittenBoat, kept: dict[str, Any], one: HullInput, sign: float
) -> VesselFile | None:
    """Return the boat of a changed hull, with those tables of the estimate; None without such."""
    try:
        made = estimate_of(hull_of(change_hull(written.made.hull.file, one, sign)))
        return read_vessel(boat_tables(made) | kept, "", written.file.path)
    except ConfigError:
        return None


def warnings(written: WrittenBoat, critical: Mapping[str, float | None]) -> Iterator[str]:
    """Yield what is unusual about a boat, in words."""
    file, hull = written.file, written.made.hull
    displaced = hull.file.water.rho * hull.shape.volume
    if abs(file.hull.mass / displaced - 1.0) > MASS_SLACK:
        yield (
            f"[mass] mass = {file.hull.mass:.6g} kg, the hull displaces {displaced:.6g} kg: "
            "one of them, or the drawing, is wrong"
        )
    for problem in range_warnings(hull):
        yield f"outside the range of the method, every sd is doubled: {problem}"
    yield from _unit_warnings(hull.file)
    planes = {"Gv": "stern planes", "Gh": "rudders"}
    for name, value in margins(file).items():
        if value is not None and value < 0.0:
            yield (
                f"{name} = {value:.2f}: unstable by itself, needs an autopilot or a helmsman; "
                f"larger {planes[name]}, or farther aft, would help; or the drawing lacks some"
            )
    stern = critical["stern"]
    if stern is not None and stern > REVERSAL_SPEED_SHARE * hull.file.speed.design_kn:
        yield (
            f"the stern planes reverse at {stern:.2g} kn, near the design speed: larger "
            "stern planes, or a centre of buoyancy less high above that of gravity"
        )
    if hull.file.mass.cb_above_cg is None:
        above = STABILITY_HEIGHTS * float(hull.shape.height.max())
        yield (
            f"[mass] cb_above_cg is taken as {above:.3g} m, give or take half: pitch and roll "
            "depend on it"
        )
    if abs(hull.shape.centroid - hull.shape.x_G) > MASS_SLACK * hull.shape.length:
        yield (
            f"[mass] cg_from_nose = {hull.shape.x_G:.4g} m, the volume's centre is at "
            f"{hull.shape.centroid:.4g} m: the boat is taken as trimmed level"
        )
    for problem in written.lacks:
        yield f"no gains were written: {problem}"


def _unit_warnings(file: HullFile) -> Iterator[str]:
    """Yield the numbers whose size suggests another unit."""
    design, length = file.speed.design_kn, file.form.length
    if design * KNOT / math.sqrt(9.81 * length) > FASTEST_FROUDE:
        yield (
            f"[speed] design_kn = {design:g} kn is fast for {length:g} m: "
            "is it in knots, and the length in m?"
        )
    if length > LONGEST_BOAT_M:
        yield f"[hull] length = {length:g} m: is it in feet? Then it is {0.3048 * length:.4g} m"
