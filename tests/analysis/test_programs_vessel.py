"""The engineer's programs that ask a vessel file, against an independent implementation."""

import json
import math
import re
from collections.abc import Iterable
from dataclasses import replace
from itertools import product
from typing import Any

import numpy as np
import pytest
from helpers.places import DATA
from hypothesis import given, settings
from hypothesis import strategies as st

from trainer.analysis import check
from trainer.analysis.programs import characteristic, tanks, thrust
from trainer.analysis.programs import constants as constants_program
from trainer.analysis.programs import neutral as neutral_program
from trainer.analysis.programs.characteristic import (
    HORIZONTAL_STATES,
    LinearSystem,
    MeanMotions,
    PlaneLaw,
    depth_loop,
    horizontal_system,
    vertical_system,
)
from trainer.analysis.programs.neutral import (
    MAX_FLOW_SLOPE,
    fold_speeds,
    level_flight,
    report_neutral,
    required_couple,
    side_equations,
    trim_at,
)
from trainer.boat.assemble import Method, fit_out
from trainer.boat.boat import Boat
from trainer.boat.depths import near_surface, surface_at
from trainer.config.boat.vessel import VesselFile, load_vessel, parse_vessel
from trainer.config.boat.vessel_records import Fluid
from trainer.config.files import ConfigError
from trainer.core import propulsion
from trainer.core.kernel import Numbers
from trainer.core.rates import rates
from trainer.core.scheme import equations_alone
from trainer.core.sea.free_surface import surface_forces
from trainer.core.terms import COEFFICIENTS, TERM_TABLE
from trainer.core.vessel import VESSEL
from trainer.units import KNOT

VECTORS = DATA / "vectors"
NEUTRAL, ROOTS, TOOLS = (
    json.loads((VECTORS / f"{name}.json").read_text()) for name in ("neutral", "roots", "tools")
)
FOOT = 0.3048
KNOT_FT = 1.68780986  # [ft/s] as the vectors have it
PLANES = {"s": "stern", "b": "bow"}
REPORT_LAW = PlaneLaw(0.008, 3.5, 0.012, 2.0)  # in feet
SI_REFSUB = load_vessel(str(VECTORS / "full-refsub.vessel.toml"))


def in_own_units(coefficients: dict[str, float], body: dict[str, float]) -> VesselFile:
    """Return a boat of the vectors in the units they have: the programs ask for no others."""
    keys = {term.mnemonic: term.key for term in TERM_TABLE}
    by_key = {keys[name]: value for name, value in coefficients.items()}
    hull = replace(
        SI_REFSUB.hull,
        length=body["L"],
        mass=body["MASS"],
        weight=body["W"],
        buoyancy=body["B"],
        cg=(body["XG"], body["YG"], body["ZG"]),
        cb=(body["XB"], body["YB"], body["ZB"]),
        Ix=body["IX"],
        Iy=body["IY"],
        Iz=body["IZ"],
        Ixy=body["IXY"],
        Iyz=body["IYZ"],
        Ixz=body["IXZ"],
    )
    return replace(
        SI_REFSUB,
        fluid=Fluid(rho=body["RHO"], g=body["G"]),
        hull=hull,
        coefficients={term.key: by_key[term.key] for term in COEFFICIENTS},
    )


def exact_boat(file: VesselFile, equations: str = "full") -> Boat:
    """Return a boat whose rates are of the moment, as the programs take them."""
    return Boat(file, Method(equations, "exact", "exact", "adams2", 0.5))


def boat_of(vectors: dict[str, Any], name: str) -> VesselFile:
    return in_own_units(vectors["sets"][name]["coef"], vectors["sets"][name]["phys"])


REFSUB = boat_of(NEUTRAL, "refsub")


def in_order(values: Iterable[complex]) -> list[complex]:
    return sorted(values, key=lambda s: (round(s.real, 10), s.imag))


def roots_of(modes: list[dict[str, float]]) -> list[complex]:
    return in_order(complex(mode["re"], mode["im"]) for mode in modes)


# --- neutral: EC470


@pytest.mark.parametrize("case", NEUTRAL["ec470"], ids=lambda case: f"{case['plane']}{case['u']}")
def test_the_flattest_neutral_flight_is_that_of_the_reference(case: dict[str, Any]) -> None:
    slope, angle = level_flight(REFSUB, PLANES[case["plane"]], case["u"])[0]

    assert slope * case["u"] == pytest.approx(case["w"], rel=1e-8)
    assert math.atan(slope) == pytest.approx(case["theta"], rel=1e-8)
    assert angle == pytest.approx(case["delta"], rel=1e-8)


@pytest.mark.parametrize("case", NEUTRAL["full_trim"], ids=lambda case: f"{case['knots']:g} kn")
def test_the_trim_of_the_boats_own_equations_is_that_of_the_reference(
    case: dict[str, Any],
) -> None:
    boat = exact_boat(SI_REFSUB)

    found = trim_at(boat, case["u"] * FOOT)

    assert found is not None
    assert found.w_m_s == pytest.approx(case["w"] * FOOT, rel=1e-8)
    assert math.radians(found.pitch_deg) == pytest.approx(case["theta"], rel=1e-8)
    assert math.radians(found.stern_planes_deg) == pytest.approx(case["ds"], rel=1e-8)
    assert found.u_c_m_s == pytest.approx(case["uc"] * FOOT, rel=1e-8)


@pytest.mark.parametrize(("letter", "plane"), PLANES.items())
def test_the_critical_speed_is_that_of_the_reference(letter: str, plane: str) -> None:
    expected = NEUTRAL["critical_speed"]["refsub"][letter]

    assert check.critical_speed(REFSUB, plane) == pytest.approx(expected, rel=1e-8)


def normal_force_and_moment(
    file: VesselFile, plane: str, t: float, angle: float, speed: float
) -> tuple[float, float]:
    """Return both lines of EC470 over u^2, as printed in the model document."""
    c, hull = file.coefficients, file.hull
    R2 = 2.0 * (hull.cb[2] * hull.buoyancy - hull.cg[2] * hull.weight)
    R2 /= file.fluid.rho * hull.length**3

    def line(axis: str) -> float:
        return (
            c[f"{axis}_waw"] * t * abs(t)
            + c[f"{axis}_ww"] * t * t
            + c[f"{axis}_w"] * t
            + c[f"{axis}_aw"] * abs(t)
            + c[f"{axis}_star"]
            + c[f"{axis}_d{plane[0]}"] * angle
        )

    return line("Z"), line("M") + R2 * math.sin(math.atan(t)) / speed**2


coefficient = st.floats(-0.05, 0.05).filter(lambda x: abs(x) > 1e-4)


@pytest.mark.long
@settings(max_examples=60)
@given(
    st.fixed_dictionaries(
        dict.fromkeys(("Z_waw", "M_waw", "Z_ww", "M_aw", "Z_w", "M_w", "M_ds"), coefficient)
    ),
    st.floats(1e-5, 1e-3),
    st.floats(3.0, 30.0),
)
def test_every_neutral_flight_of_any_hull_is_found_and_none_else(
    given_: dict[str, float], lift: float, speed: float
) -> None:
    hull = replace(REFSUB, coefficients={**REFSUB.coefficients, **given_, "Z_star": lift})

    found = level_flight(hull, "stern", speed)

    for t, angle in found:
        force, moment = normal_force_and_moment(hull, "stern", t, angle, speed)
        assert abs(force) + abs(moment) < 1e-12 * (1.0 + t * t)
    # a fine search for changes of sign misses only pairs that lie closer than it looks
    expected = 0
    for side in side_equations(hull, "stern"):
        grid = np.geomspace(1e-7, MAX_FLOW_SLOPE, 20001)
        excess = np.array([required_couple(side, t) for t in grid]) - side.couple / speed**2
        expected += int(np.count_nonzero(np.diff(np.sign(excess))))
    assert len(found) in (expected, expected + 2)
    assert [abs(t) for t, _ in found] == sorted(abs(t) for t, _ in found)


@pytest.mark.parametrize("plane", PLANES.values())
def test_two_neutral_flights_meet_and_vanish_at_the_fold_speed(plane: str) -> None:
    (fold,) = fold_speeds(REFSUB, plane)

    below, above = (len(level_flight(REFSUB, plane, fold * near)) for near in (0.999, 1.001))

    assert {below, above} == {1, 3}


def test_the_planes_reverse_at_the_fold_just_below_their_critical_speed() -> None:
    (fold,), critical = fold_speeds(REFSUB, "stern"), check.critical_speed(REFSUB, "stern")
    assert critical is not None
    assert 0.9 * critical < fold < critical  # the hull's own lift moves one from the other

    (w_low, low), (w_high, high) = (
        level_flight(REFSUB, "stern", fold * near)[0] for near in (0.999, 1.001)
    )

    assert low < 0.0 < high  # the angle that holds this hull level changes its sign
    assert w_high < 0.0 < w_low  # and so does its w


def test_a_hull_the_same_above_and_below_flies_level_with_planes_at_zero() -> None:
    assert (0.0, 0.0) in level_flight(load_vessel("remus100"), "stern", 1.5)


def test_a_boat_without_bow_planes_has_no_level_flight_by_them() -> None:
    file = load_vessel("remus100")

    assert level_flight(file, "bow", 1.5) == []
    assert any("-2.3" in remark for remark in report_neutral(file, [3.0]).remarks)


# --- modes: EC140, EC200, EC320


@pytest.mark.parametrize("case", ROOTS["cases"], ids=lambda case: f"{case['u']:.1f} ft/s")
@pytest.mark.parametrize(
    ("plane", "key"), [(vertical_system, "longitudinal"), (horizontal_system, "lateral")]
)
def test_polynomials_and_roots_are_those_of_the_reference(
    case: dict[str, Any], plane: Any, key: str
) -> None:
    linear = plane(boat_of(ROOTS, case["set"]), case["u"])

    assert linear.polynomial == pytest.approx(case[key]["poly"], rel=1e-8)
    assert in_order(linear.eigenvalues) == pytest.approx(roots_of(case[key]["modes"]), rel=1e-8)


@pytest.mark.parametrize("case", ROOTS["cases"], ids=lambda case: f"{case['u']:.1f} ft/s")
def test_a_mean_angle_of_attack_changes_the_cubic_as_in_the_reference(
    case: dict[str, Any],
) -> None:
    wanted = case["longitudinal_wbar"]

    linear = vertical_system(boat_of(ROOTS, case["set"]), case["u"], MeanMotions(w=wanted["wbar"]))

    assert linear.polynomial == pytest.approx(wanted["poly"], rel=1e-8)


def test_the_rescue_vehicle_in_its_own_system_of_units_has_the_published_roots() -> None:
    case = ROOTS["dsrv"]
    linear = vertical_system(in_own_units(case["coef"], case["phys"]), case["u"])

    assert linear.polynomial == pytest.approx(case["poly"], rel=1e-8)
    assert in_order(linear.eigenvalues) == pytest.approx(roots_of(case["modes"]), rel=1e-8)


def rates_in_the_loop(case: dict[str, Any], motion: Numbers) -> Numbers:
    """Return w', q', theta', z' of the full set, planes by the law of 1969 at its signs."""
    speed = case["knots"] * KNOT_FT
    records = fit_out(boat_of(ROOTS, case["set"]), Method("full", "exact", "exact", "adams2", 1.0))
    s = records.state[0]
    s.u = s.u_c = speed
    s.w, s.q, s.theta, s.z = motion
    climb = s.u * math.sin(s.theta) - s.w * math.cos(s.theta)
    angle = -REPORT_LAW.depth * s.z + REPORT_LAW.pitch * s.theta
    angle += REPORT_LAW.climb * climb + REPORT_LAW.pitch_rate * s.q
    s.delta_s, s.delta_b = case["sign_ds"] * angle, case["sign_db"] * angle
    rates(*records._replace(scheme=equations_alone(records.scheme)))
    return np.array([s.wdot, s.qdot, s.thetadot, s.zdot])


def differentiated(case: dict[str, Any], step: float) -> Numbers:
    """Return the loop's matrix by central differences about straight level flight."""
    steps = step * np.eye(4)
    changes = [rates_in_the_loop(case, x) - rates_in_the_loop(case, -x) for x in steps]
    return np.transpose(changes) / (2.0 * step)


def depth_loop_of(case: dict[str, Any]) -> LinearSystem:
    """Return the depth loop of a case of the vectors."""
    file, speed = boat_of(ROOTS, case["set"]), case["knots"] * KNOT_FT
    return depth_loop(file, speed, case["sign_ds"], case["sign_db"], REPORT_LAW)


def loop_name(case: dict[str, Any]) -> str:
    """Return what a case of the depth loop is called."""
    return f"{case['knots']}{case['sign_ds']}{case['sign_db']}"


# The reference differentiates by central steps of 1e-6 ft/s and rad. A kink at zero comes through
# such a step as its slope there: w|w| as 1e-6 w, |q| delta_s as 1e-6 delta_s. Differentiated in
# that way our full set gives the reference's roots; what is exact differs from both.
@pytest.mark.parametrize("case", ROOTS["autopilot_closed_loop"], ids=loop_name)
def test_the_depth_loop_of_1969_by_the_steps_of_the_reference_has_its_roots(
    case: dict[str, Any],
) -> None:
    expected = in_order(complex(*pair) for pair in case["eig"])

    by_steps = in_order(np.linalg.eigvals(differentiated(case, 1e-6)))

    assert by_steps == pytest.approx(expected, rel=1e-9)


@pytest.mark.parametrize("case", ROOTS["autopilot_closed_loop"], ids=loop_name)
def test_the_depth_loop_of_1969_is_what_differences_tend_to(case: dict[str, Any]) -> None:
    exact = in_order(depth_loop_of(case).eigenvalues)
    near, far = (in_order(np.linalg.eigvals(differentiated(case, h))) for h in (5e-5, 1e-4))

    extrapolated = [2.0 * a - b for a, b in zip(near, far, strict=True)]  # the kink is of order h

    assert extrapolated == pytest.approx(exact, rel=1e-8)


def test_the_quasi_linear_coefficients_are_those_of_the_polynomials() -> None:
    file, speed = load_vessel("bb2"), 5.0
    means = MeanMotions(v=0.4, w=0.2, p=0.03, q=0.01, r=0.02)
    stand_in = replace(
        file,
        coefficients={**file.coefficients, **characteristic.quasi_linear(file, speed, means)},
    )

    for plane in (vertical_system, horizontal_system):
        assert plane(stand_in, speed).polynomial == pytest.approx(
            plane(file, speed, means).polynomial, rel=1e-12
        )
        assert plane(file, speed).polynomial != pytest.approx(
            plane(file, speed, means).polynomial, rel=1e-3
        )


def test_a_mean_rate_of_roll_damps_roll_by_its_quadratic_term() -> None:
    file = in_own_units(
        {**ROOTS["sets"]["refsub"]["coef"], "KPAP": -1e-6, "YPAP": 2e-6},
        ROOTS["sets"]["refsub"]["phys"],
    )
    scale = 0.5 * file.fluid.rho * file.hull.length**4
    still, rolling = (horizontal_system(file, 17.0, MeanMotions(p=p)) for p in (0.0, 0.05))

    change = (rolling.F - still.F)[:, HORIZONTAL_STATES.index("p")]

    expected = [2e-6 * scale * 0.05, -1e-6 * scale * file.hull.length * 0.05, 0.0, 0.0]
    assert change == pytest.approx(expected, rel=1e-9)
    assert np.count_nonzero(rolling.F - still.F) == 2
    assert rolling.polynomial[1] / rolling.polynomial[0] > still.polynomial[1] / still.polynomial[0]


def test_stern_planes_alone_keep_depth_above_their_critical_speed_only() -> None:
    file = load_vessel("bb2")
    critical = check.critical_speed(file, "stern")
    assert critical is not None

    slow, fast = (
        max(depth_loop(file, critical * near, 1.0, 0.0).eigenvalues.real) for near in (0.9, 1.1)
    )

    assert slow > 0.0 > fast


def test_roots_are_named_and_measured() -> None:
    (at_10,) = characteristic.report_modes(load_vessel("bb2"), [10.0], MeanMotions()).speeds

    assert [root.name for root in at_10.horizontal.roots] == ["sway-yaw", "spiral", "roll"]
    roll = at_10.horizontal.roots[-1]
    assert roll.frequency_rad_s == pytest.approx(abs(complex(roll.real, roll.imaginary)))
    assert roll.damping_ratio == pytest.approx(-roll.real / roll.frequency_rad_s)
    assert roll.period_s == pytest.approx(2.0 * math.pi / roll.imaginary)
    assert all(root.stable for root in at_10.depth_loop.roots)


# --- thrust: ZC300


@pytest.mark.parametrize("case", TOOLS["thrust"], ids=lambda case: f"{case['u']} {case['uc']}")
def test_thrust_and_acceleration_are_those_of_the_reference(case: dict[str, Any]) -> None:
    file = boat_of(TOOLS, "refsub")
    small = 1e-10 * 0.5 * file.fluid.rho * file.hull.length**2  # where thrust equals drag

    found = thrust.table_entry(file, case["u"], case["uc"])

    assert found.row == case["row"]
    assert found.thrust_N == pytest.approx(case["thrust"], rel=1e-10, abs=small)
    assert found.acceleration_m_s2 == pytest.approx(case["accel"], rel=1e-10, abs=1e-12)
    assert found.as_flown_m_s2 == pytest.approx(case["accel_added_mass"], rel=1e-10, abs=1e-12)


@pytest.mark.parametrize("name", ["bb2", "sdv-mk9", "remus100", "refsub"])
def test_the_thrust_of_the_table_is_the_one_that_is_flown(name: str) -> None:
    file = SI_REFSUB if name == "refsub" else load_vessel(name)
    boat = exact_boat(file)

    for u, u_c in product((-2.0, 0.0, 0.5, 3.0, 8.0), (-6.0, -0.1, 0.0, 0.2, 1.5, 4.0, 9.0)):
        boat.state.u, boat.state.u_c = u, u_c
        of = propulsion.thrust if u >= 0.0 else propulsion.thrust_astern
        flown = of(boat.records.vessel, boat.records.state)
        assert thrust.thrust(file, u, u_c) == pytest.approx(flown, rel=1e-12, abs=1e-9)


def test_rows_that_join_are_said_to_join_and_others_by_how_much_they_do_not() -> None:
    assert [one.jump for one in thrust.breaks(SI_REFSUB)] == pytest.approx([0.0, 0.0], abs=1e-15)
    sets = SI_REFSUB.thrust.ahead
    apart = replace(sets[0], a=sets[0].a + 1e-3)
    other = SI_REFSUB.thrust._replace(ahead=(apart, *sets[1:]))

    broken = thrust.breaks(replace(SI_REFSUB, thrust=other))[0]

    assert (broken.eta, broken.jump) == (0.5, pytest.approx(1e-3))  # type: ignore[comparison-overlap]


# --- tanks: EC430


def test_the_reference_tanks_have_the_reference_balance_through_any_filling() -> None:
    case = TOOLS["tanks"]
    hull, full = tanks.Weight(case["W0"], *case["r0"]), [tanks.Weight(*r) for r in case["tanks"]]
    now, found = tanks.balance(hull, full), tanks.limits(hull, full)

    assert now.weight == pytest.approx(case["W"], rel=1e-10)
    assert now.centre == pytest.approx(case["rG"], rel=1e-10)
    assert now.moments == pytest.approx(case["moments"], rel=1e-10)
    for name, limit in (
        ("W", found.weight),
        ("xG", found.x_g),
        ("yG", found.y_g),
        ("zG", found.z_g),
    ):
        assert limit == pytest.approx(case["limits"][name], rel=1e-10, abs=1e-12)


def test_as_filled_at_the_start_a_boat_has_the_weight_and_centre_of_its_file() -> None:
    file = load_vessel("bb2")

    now = tanks.report_fillings(file, {}).now

    assert now.weight == pytest.approx(file.hull.weight, rel=1e-14)
    assert now.centre == pytest.approx(file.hull.cg, abs=1e-14)


def test_a_tonne_pumped_into_a_tank_weighs_a_tonne_there() -> None:
    file = load_vessel("bb2")
    share = 1000.0 / (60.0 * file.fluid.rho)  # of the auxiliary tank's 60 m3, at x = -1 m

    before, after = (
        tanks.report_fillings(file, {"auxiliary": fill}).now for fill in (0.5, 0.5 + share)
    )

    assert after.weight - before.weight == pytest.approx(1000.0 * file.fluid.g)
    assert after.moments[0] - before.moments[0] == pytest.approx(-1000.0 * file.fluid.g)


def test_every_filling_lies_within_the_outline_and_every_corner_is_a_filling() -> None:
    file = load_vessel("bb2")
    report = tanks.report_fillings(file, {})
    pumped = [tank.full for tank in report.tanks if tank.kind == "pumped"]
    kept = [tank.contents for tank in report.tanks if tank.kind != "pumped"]
    corners = np.array(report.ranges[0].outline)
    edges = np.diff(corners, axis=0)
    whole = []
    for fill in product((0.0, 0.3, 1.0), repeat=len(pumped)):
        full = [
            tank._replace(weight=share * tank.weight)
            for tank, share in zip(pumped, fill, strict=True)
        ]
        now = tanks.balance(report.hull, [*kept, *full])
        whole.append((now.weight - file.hull.buoyancy, now.moments[0]))
    places = np.array(whole)

    # the outline runs round anticlockwise: inside is to the left of every edge
    for corner, (dx, dy) in zip(corners, edges, strict=False):
        left = dx * (places[:, 1] - corner[1]) - dy * (places[:, 0] - corner[0])
        assert left.min() > -1.0  # [N2 m] of 1e11
    for corner in corners:
        assert np.hypot(*(places - corner).T).min() < 1e-3


@pytest.mark.parametrize(
    ("fills", "said"),
    [
        ({"auxilary": 0.5}, "no such tank; nearest is auxiliary; this boat has trim_forward"),
        ({"auxiliary": 1.5}, "auxiliary=1.5: must be within 0"),
        ({"auxiliary": math.nan}, "auxiliary=nan: must be within 0"),
    ],
)
def test_a_filling_that_cannot_be_is_refused_by_name(fills: dict[str, float], said: str) -> None:
    with pytest.raises(ConfigError, match=said):
        tanks.report_fillings(load_vessel("bb2"), fills)


def test_a_boat_without_tanks_is_said_to_have_none() -> None:
    with pytest.raises(ConfigError, match=r"remus100.toml: has no table \[ballast\]"):
        tanks.report_fillings(load_vessel("remus100"), {})


def test_speeds_are_in_knots_on_the_page() -> None:
    (point,) = thrust.survey_thrust(load_vessel("bb2"), [10.0], [15.0]).points

    assert (point.u_kn, point.u_c_kn) == (pytest.approx(10.0), pytest.approx(15.0))  # type: ignore[comparison-overlap]
    assert point.thrust_N == thrust.thrust(load_vessel("bb2"), 10.0 * KNOT, 15.0 * KNOT)


# --- every constant: EB920's listing and EC790


def test_the_listing_has_every_number_of_the_vessel_record() -> None:
    report = constants_program.list_vessel_constants(load_vessel("bb2"))
    found = {one.symbol for group in report.groups.values() for one in group}
    found |= {one.symbol for one in report.coefficients}

    blocks = {"whole", "limit", "added"}  # other names of numbers that are listed already
    assert found == set(VESSEL.names or ()) - blocks


@pytest.mark.parametrize("name", ["bb2", "sdv-mk9", "remus100", "refsub"])
def test_a_listed_constant_is_the_one_that_is_flown(name: str) -> None:
    file = SI_REFSUB if name == "refsub" else load_vessel(name)
    flown = exact_boat(file).vessel
    report = constants_program.list_vessel_constants(file)

    for one in (one for group in report.groups.values() for one in group):
        part = np.asarray(flown[one.symbol], float)
        rows = np.array(one.values)
        kept = part.reshape(-1, part.shape[-1]) if part.ndim else part.reshape(1, 1)
        assert (kept[: len(rows), : rows.shape[-1]] == rows).all() if rows.size else not kept.any()
    for coefficient in report.coefficients:
        assert coefficient.value == flown[coefficient.symbol]
        given_ = file.coefficients.get(coefficient.symbol)
        assert given_ is None or coefficient.prime == pytest.approx(given_, rel=1e-13, abs=1e-18)


def test_a_constant_says_where_it_comes_from() -> None:
    report = constants_program.list_vessel_constants(load_vessel("remus100"))
    of = {one.symbol: one for group in report.groups.values() for one in group}

    assert (of["rho"].origin, of["rho"].unit, of["rho"].key) == ("file", "kg/m3", "fluid.rho")
    assert of["I_xy"].origin in ("file", "default")
    assert of["tested"].origin == "absent"
    assert of["cross_arm"].origin == "derived"
    assert {one.origin for one in report.coefficients} == {"file", "absent"}
    file = parse_vessel(SI_REFSUB.text.replace("Ixy", "# Ixy"), SI_REFSUB.path)
    assert constants_program.origin_of(file, "vessel.Ixy") == "default"
    assert constants_program.origin_of(SI_REFSUB, "control_surfaces.tail") == "default"


@pytest.mark.parametrize("name", ["bb2", "sdv-mk9", "remus100"])
def test_the_listing_fits_a_terminal_and_has_every_coefficient_by_both_names(name: str) -> None:
    page = constants_program.render(constants_program.list_vessel_constants(load_vessel(name)))

    assert page.isascii()
    assert max(map(len, page.splitlines())) <= 79
    for term in TERM_TABLE:
        assert re.search(rf"^  {term.key} +{term.mnemonic} ", page, re.MULTILINE)


def test_the_compact_constants_are_those_of_both_sets() -> None:
    file = load_vessel("bb2")
    report = {one.symbol: one for one in constants_program.list_vessel_constants(file).compact}
    area = 0.5 * file.fluid.rho * file.hull.length**2

    for kept in ("modified", "basic"):
        flown = Boat(file, Method(kept, "lagged", "exact", "adams2", 0.5)).records.compact[0]
        for symbol, one in report.items():
            assert getattr(one, kept) == flown[symbol]
    assert report["T5"].unit == "1/(kg m2)"
    assert report["Z_w"].modified == pytest.approx(
        area * file.coefficients["Z_w"] * file.compensation["modified"].get("Z_w", 1.0)
    )
    assert report["Z_waw"].basic == 0.0 != report["Z_waw"].modified


# --- the calm surface: Tables 12 and 13


def surface_of(file: VesselFile, u: float, depth: float, w: float = 0.0) -> tuple[float, float]:
    """Return the force [N] and moment [N m] that a tick of the core has from the surface."""
    boat = exact_boat(file)
    boat.state.u, boat.state.w, boat.state.z = u, w, depth
    force = np.zeros(6)
    surface_forces(boat.records.vessel, boat.records.state, force)
    assert np.count_nonzero(force[[0, 1, 3, 5]]) == 0
    return float(force[2]), float(force[4])


def uneven() -> VesselFile:
    """Return BB2 with a surface that is felt by speed, which her own tables do not show."""
    file = load_vessel("bb2")
    assert file.free_surface is not None
    rows = [
        replace(
            row, Z_star=tuple(by * z for z in row.Z_star), M_star=tuple(by * m for m in row.M_star)
        )
        for row, by in zip(file.free_surface.rows, (0.5, 1.0, 2.0), strict=True)
    ]
    return replace(file, free_surface=replace(file.free_surface, rows=tuple(rows)))


def slanting() -> VesselFile:
    """BB2 with a surface that changes Z_w and M_w as well."""
    file = load_vessel("bb2")
    assert file.free_surface is not None
    Z_w, M_w = (8.4e-4, 7e-4, 6e-4, 0.0), (-8.7e-4, -8e-4, -5e-4, 0.0)
    return replace(file, free_surface=replace(file.free_surface, Z_w=Z_w, M_w=M_w))


@pytest.mark.parametrize("depth", [11.0, 14.2, 30.0, 35.0624, 60.0])
def test_a_surface_that_changes_z_w_and_m_w_pushes_as_their_differences(depth: float) -> None:
    file, level = slanting(), load_vessel("bb2")
    pushed, plain = (np.array(surface_of(one, 3.0, depth, w=0.2)) for one in (file, level))

    near = near_surface(file, 3.0, depth).coefficients
    area, arm = 0.5 * file.fluid.rho * file.hull.length**2, file.hull.length
    Z = area * (near["Z_w"] - level.coefficients["Z_w"]) * 3.0 * 0.2
    M = area * arm * (near["M_w"] - level.coefficients["M_w"]) * 3.0 * 0.2
    assert (depth < 35.0) == (Z != 0.0)
    assert pushed - plain == pytest.approx([Z, M], rel=1e-9, abs=1e-6)


def test_modes_near_a_surface_that_changes_z_w_and_m_w_are_of_these() -> None:
    (plain,) = characteristic.report_modes(load_vessel("bb2"), [6.0], MeanMotions(), 16.0).speeds
    (slant,) = characteristic.report_modes(slanting(), [6.0], MeanMotions(), 16.0).speeds

    near = near_surface(slanting(), 6.0 * KNOT, 16.0).coefficients
    assert (slant.adjusted["Z_w"], slant.adjusted["M_w"]) == (near["Z_w"], near["M_w"])
    assert slant.vertical != plain.vertical
    assert slant.horizontal == plain.horizontal


@pytest.mark.parametrize("depth", [11.0, 13.8724, 14.2, 16.0, 30.0, 35.0624, 60.0])
@pytest.mark.parametrize("knots", [1.0, 4.5, 8.0, 10.0, 15.0])
@pytest.mark.parametrize("file", [load_vessel("bb2"), uneven()], ids=["even", "by speed"])
def test_the_surface_of_the_programs_is_that_of_the_core(
    file: VesselFile, knots: float, depth: float
) -> None:
    found = surface_at(file, knots * KNOT, depth)

    expected = surface_of(file, knots * KNOT, depth)

    assert (found.Z_N, found.M_N_m) == pytest.approx(expected, rel=1e-12, abs=1e-6)


def test_modes_near_the_surface_feel_how_its_force_changes_with_depth() -> None:
    file, speed, depth = load_vessel("bb2"), 6.0 * KNOT, 16.0
    deep = characteristic.with_depth(vertical_system(file, speed), speed)

    near = characteristic.under_surface(deep, file, speed, depth)

    low, high = (np.array(surface_of(file, speed, depth + h)) for h in (-0.1, 0.1))
    assert (near.F - deep.F)[:2, 3] == pytest.approx((high - low) / 0.2, rel=1e-9)
    assert np.count_nonzero(near.F - deep.F) == 2
    assert len(near.polynomial) == 5
    assert np.prod(near.eigenvalues).real == pytest.approx(
        near.polynomial[-1] / near.polynomial[0], rel=1e-9
    )


def test_a_boat_whose_suction_fades_downwards_leaves_her_depth_by_herself() -> None:
    (deep,) = characteristic.report_modes(load_vessel("bb2"), [6.0], MeanMotions(), 40.0).speeds
    (near,) = characteristic.report_modes(load_vessel("bb2"), [6.0], MeanMotions(), 20.0).speeds

    assert min(root.frequency_rad_s for root in deep.vertical.roots) == pytest.approx(0.0, abs=1e-9)
    assert max(root.real for root in near.vertical.roots) > 1e-3
    assert all(root.stable for root in near.depth_loop.roots)


@pytest.mark.parametrize("plane", PLANES.values())
@pytest.mark.parametrize("knots", [4.0, 8.0])
def test_neutral_angles_near_the_surface_balance_its_force_and_moment(
    plane: str, knots: float
) -> None:
    file, speed = load_vessel("bb2"), knots * KNOT
    area = 0.5 * file.fluid.rho * file.hull.length**2 * speed**2
    Z, M = surface_of(file, speed, 15.0)

    (flight,) = (one for one in report_neutral(file, [knots], 15.0).flights if one.plane == plane)

    assert flight.solutions
    for one in flight.solutions:
        angle = math.radians(one.plane_deg)
        force, moment = normal_force_and_moment(file, plane, one.w_m_s / speed, angle, speed)
        assert force + Z / area == pytest.approx(0.0, abs=1e-12)
        assert moment + M / area / file.hull.length == pytest.approx(0.0, abs=1e-12)


@pytest.mark.parametrize("vessel", [load_vessel("bb2"), slanting()], ids=["level", "slanting"])
@pytest.mark.parametrize("equations", ["full", "modified"])
def test_the_trim_near_the_surface_leaves_no_acceleration_there(
    equations: str, vessel: VesselFile
) -> None:
    file, speed = vessel, 6.0 * KNOT
    boat = exact_boat(file, equations)
    deep_water = boat.vessel.tobytes(), boat.records.compact.tobytes()

    found = trim_at(boat, speed, 15.0)

    assert (boat.vessel.tobytes(), boat.records.compact.tobytes()) == deep_water

    assert found is not None
    deep = trim_at(Boat(file, boat.method), speed)
    assert deep is not None
    assert abs(found.stern_planes_deg - deep.stern_planes_deg) > 0.5
    r, force = boat.records, np.zeros(6)
    surface_forces(r.vessel, r.state, force)
    r.scratch["external"][0] = force
    rates(*r._replace(scheme=equations_alone(r.scheme)))
    assert abs(boat.state.rates[:6]).max() < 1e-10
    assert boat.state.zdot == pytest.approx(0.0, abs=1e-10)


def test_a_fold_near_the_surface_is_felt_at_its_own_speed() -> None:
    file = uneven()

    folds = neutral_program.fold_speeds_at(file, "stern", 15.0)

    assert folds
    for speed in folds:
        there = near_surface(file, speed, 15.0)
        assert min(abs(one / speed - 1.0) for one in fold_speeds(there, "stern")) < 1e-8


@pytest.mark.parametrize(
    ("name", "depth", "said"),
    [
        ("remus100", 5.0, r"remus100.toml: has no table \[free_surface\]"),
        ("bb2", 2.0, r"--depth 2 m: the hull is covered from \d+.\d\d m down"),
    ],
)
def test_a_depth_of_which_nothing_is_known_is_refused(name: str, depth: float, said: str) -> None:
    with pytest.raises(ConfigError, match=said):
        report_neutral(load_vessel(name), [3.0], depth)
    with pytest.raises(ConfigError, match=said):
        characteristic.report_modes(load_vessel(name), [3.0], MeanMotions(), depth)


def test_where_the_tables_of_the_surface_end_it_is_said() -> None:
    file = load_vessel("bb2")

    above, inside, below = (
        characteristic.report_modes(file, [6.0], MeanMotions(), depth).remarks
        for depth in (12.0, 20.0, 50.0)
    )

    assert "begin at 13.87" in above[0]
    assert inside == ()
    assert "not felt from 35.06" in below[0]
