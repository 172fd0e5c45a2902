"""What ``trainer boat check`` finds in a boat; its verdict on a step is what then happens."""

import json
import math
import re
import time
from dataclasses import asdict, replace

import numpy as np
import pytest
from helpers.places import DATA, ROOT

from trainer.analysis import check as check_module
from trainer.analysis.check import (
    CheckReport,
    check_vessel,
    compare_turns,
    round_speeds,
    straight_flights,
)
from trainer.analysis.check_page import render
from trainer.analysis.guide.programme import own_method
from trainer.analysis.manoeuvres.flight import fly_manoeuvre
from trainer.analysis.manoeuvres.submarine import Submarine
from trainer.analysis.manoeuvres.turns import ClimbingTurn
from trainer.analysis.manoeuvres.vehicle import DIVE
from trainer.boat.assemble import Method, scheme_record
from trainer.boat.boat import Boat
from trainer.boat.linear import bring_to, measure_response, modes
from trainer.boat.stability import (
    StepVerdict,
    boat_responses,
    growth_factors,
    largest_step,
    leading_motion,
    stable_step,
    tick_map,
)
from trainer.config.boat.propulsion import thrust_of
from trainer.config.boat.vessel import VesselFile, load_vessel
from trainer.core.integrators import advance
from trainer.core.kernel import Record
from trainer.core.scheme import INTEGRATOR_NAMES
from trainer.core.state import MOTION, PAST_CYCLES
from trainer.units import KNOT

INTEGRATION = json.loads((DATA / "integration.json").read_text())
# methods whose intervals an independent program has, by its names
PUBLISHED = {"euler": "euler", "adams2": "ab2", "best2": "best12", "rk4": "rk4"}
FOOT = 0.3048
REMUS_SPEEDS = [speed * KNOT for speed in (2.0, 2.5, 3.0, 3.5, 4.0, 4.5)]


def scheme(integrator: str) -> Record:
    return scheme_record(Method("full", "lagged", "exact", integrator, 0.5))


def flown(
    name: str, integrator: str, step: float, equations: str = "full", rates: str = "lagged"
) -> Boat:
    return Boat(load_vessel(name), Method(equations, rates, "exact", integrator, step))


def refsub() -> VesselFile:
    return load_vessel(str(DATA / "vectors" / "full-refsub.vessel.toml"))


@pytest.fixture(scope="module")
def bb2() -> CheckReport:
    return check_vessel(load_vessel("bb2"))


@pytest.fixture(scope="module")
def remus() -> CheckReport:
    return check_vessel(load_vessel("remus100"))


# --- stability regions


@pytest.mark.parametrize("case", INTEGRATION["max_h"], ids=lambda case: str(case["lam"]))
@pytest.mark.parametrize(("integrator", "key"), [("adams2", "ab2"), ("euler", "euler")])
def test_largest_steps_are_those_of_an_independent_program(
    case: dict[str, list[float]], integrator: str, key: str
) -> None:
    assert largest_step(scheme(integrator), complex(*case["lam"])) == pytest.approx(
        case[key], rel=1e-9
    )


# -(4/7)(1 + 2 a3)/(1 - a3) of a parabola through positions and the closed formula of three with a3,
# errata D6: the report's Table 1 has -.82; of Adams-Bashforth the intervals of any textbook
INTERVALS = {
    **{ours: INTEGRATION["real_interval"][key] for ours, key in PUBLISHED.items()},
    "bdf2": -4 / 7,
    "bdf3": -4 / 7 * (15 / 9),
    "o30c31": -4 / 7 * (1.2532 / 0.8734),
    "adams3": -6 / 11,
    "adams4": -3 / 10,
    "heun": -2.0,
    "abm2": -2.0,
    "abm3": -1.72878,
    "abm4": -1.2848,
    "hamming4": -0.5,
    "rk2": -2.0,
    "rk3": -2.512745,
}


@pytest.mark.parametrize("integrator", INTERVALS)
def test_a_real_mode_has_the_published_interval(integrator: str) -> None:
    near = 1e-9 if integrator in PUBLISHED else 1e-4

    assert largest_step(scheme(integrator), -2.0 + 0.0j) == pytest.approx(
        -0.5 * INTERVALS[integrator], rel=near
    )


def test_the_manual_has_every_method_with_its_interval() -> None:
    lines = (ROOT / "docs" / "engineer.md").read_text(encoding="utf-8").splitlines()
    told: dict[str, str] = {}
    for line in lines:
        cells = [cell.strip() for cell in line.split("|")]
        names = re.findall(r"`(\w+)`", cells[1]) if len(cells) == 8 else []
        told |= dict(zip(names, cells[5].split(", ") if names else (), strict=True))

    assert told == {
        name: f"{largest_step(scheme(name), -1.0 + 0j):.3f}" for name in INTEGRATOR_NAMES
    }


ORDERS = {
    "euler": 1,
    "best2": 1,
    "adams2": 2,
    "adams3": 3,
    "adams4": 4,
    "heun": 2,
    "abm2": 2,
    "abm3": 3,
    "abm4": 4,
    "hamming4": 4,
    "o30c31": 2,
    "bdf2": 2,
    "bdf3": 3,
    "rk2": 2,
    "rk3": 3,
    "rk4": 4,
    "rkv": 4,
}


def test_every_named_method_has_its_order_once_it_has_a_past() -> None:
    assert set(ORDERS) == set(INTEGRATOR_NAMES)
    for integrator, order in ORDERS.items():
        steps = np.array([-0.02, -0.01])
        wrong = abs(growth_factors(scheme(integrator), steps.astype(complex)) - np.exp(steps))
        assert np.log2(wrong[0] / wrong[1]) == pytest.approx(order + 1, abs=0.35), integrator


@pytest.mark.parametrize("point", INTEGRATION["ab2_boundary"], ids=lambda p: f"{p['theta']:.2f}")
def test_the_boundary_of_adams_2_is_where_it_should_be(point: dict[str, list[float]]) -> None:
    mu = complex(*point["mu"])

    assert growth_factors(scheme("adams2"), np.array([mu]))[0] == pytest.approx(1.0, abs=1e-10)
    assert largest_step(scheme("adams2"), mu) == pytest.approx(1.0, abs=1e-7)


@pytest.mark.parametrize(("ratio", "frequency"), [(0.1, 0.5), (0.5, 3.0), (0.9, 0.1)])
def test_euler_takes_an_oscillator_up_to_twice_its_damping(ratio: float, frequency: float) -> None:
    # |1 + h lambda| = 1 at h = -2 Re lambda/|lambda|^2 = 2 ratio/frequency
    root = frequency * complex(-ratio, math.sqrt(1.0 - ratio * ratio))

    assert largest_step(scheme("euler"), root) == pytest.approx(2.0 * ratio / frequency, rel=1e-9)


def test_a_multistep_method_of_the_users_own_has_its_own_region() -> None:
    assert largest_step(scheme("a=1;b=1.5,-0.5"), -1.0 + 0j) == pytest.approx(1.0, rel=1e-9)
    # leap-frog (a = 0, 1; b = 2) damps nothing at any step
    assert largest_step(scheme("a=0,1;b=2"), -1.0 + 0j) == pytest.approx(0.0, abs=1e-9)


# --- the boat's own modes


def test_roots_are_those_of_the_published_determinants() -> None:
    # vectors/roots.json, refsub at 5 kn, w = theta = 0 and u frozen
    boat = Boat(refsub(), Method("full", "lagged", "exact", "adams2", 0.5))
    boat.state.u = boat.state.u_c = 8.4390493 * FOOT
    response = measure_response(boat)

    def part(*names: str) -> list[tuple[str, complex]]:
        places = [response.names.index(name) for name in names]
        found = modes(response.nature[np.ix_(places, places)], names)
        return [(mode.name, mode.eigenvalue) for mode in found]

    for found, expected in (
        (
            part("v", "p", "r", "phi"),
            [
                ("sway-yaw", -0.107775433902 + 0j),
                ("spiral", -0.0148240472743 + 0j),
                ("roll", -0.0532878504613 + 0.433854883633j),
            ],
        ),
        (
            part("w", "q", "theta"),
            [
                ("heave", -0.0251746028617 + 0j),
                ("pitch", -0.0372048581534 + 0.032796135515j),
            ],
        ),
    ):
        assert [name for name, _ in found] == [name for name, _ in expected]
        for (_, root), (_, wanted) in zip(found, expected, strict=True):
            # the difference quotient sees 1e-5 m/s of v|v|
            assert root == pytest.approx(wanted, rel=5e-5)


@pytest.mark.parametrize("equations", ["full", "modified", "basic", "longitudinal"])
def test_lagging_the_accelerations_does_not_change_the_boats_nature(equations: str) -> None:
    exact, lagged = (
        boat_responses(flown("bb2", "adams2", 0.5, equations, rates), [5.0])[5.0]
        for rates in ("exact", "lagged")
    )

    assert not exact.G.any()
    assert lagged.G.any()
    assert lagged.nature == pytest.approx(exact.nature, rel=1e-6, abs=1e-8)


def test_bb2_damps_every_mode_and_rolls_in_13_4_seconds(bb2: CheckReport) -> None:
    at_10 = next(flight for flight in bb2.flights if flight.speed_kn == 10.0)
    roll = next(row for row in at_10.modes if row.name == "roll")

    assert all(row.stable for flight in bb2.flights for row in flight.modes)
    assert roll.period_s == pytest.approx(13.4, abs=0.1)
    # root -0.081 +- 0.468 i
    assert roll.damping_ratio == pytest.approx(0.17, abs=0.005)
    assert {row.name for row in at_10.modes} == {"surge", "pitch", "sway-yaw", "spiral", "roll"}


def test_remus_is_unstable_by_nature_and_no_step_is_given_for_that(remus: CheckReport) -> None:
    for flight in remus.flights:
        spiral = next(row for row in flight.modes if row.name == "spiral")
        assert spiral.real > 0.4
        assert not spiral.stable
        assert spiral.largest_s == {}
    assert "UNSTABLE BY NATURE" in render(remus)
    assert "UNSTABLE BY NATURE" not in render(check_vessel(refsub()))


def test_modes_of_a_speed_without_trim_are_marked() -> None:
    slow, fast = straight_flights(load_vessel("remus100"), [2.0, 3.0])

    assert (slow.trimmed, fast.trimmed) == (False, True)


def test_without_trim_a_boat_is_put_into_level_flight() -> None:
    boat = flown("remus100", "adams2", 0.05)

    assert not bring_to(boat, 2.0 * KNOT)

    s = boat.state
    assert s.u == s.u_c == 2.0 * KNOT
    assert not any(s[name] for name in ("v", "w", "phi", "theta", "delta_r", "delta_s", "delta_b"))


# --- what a tick does


@pytest.mark.parametrize("equations", ["full", "modified"])
@pytest.mark.parametrize(
    "integrator",
    [
        *("euler", "adams2", "adams3", "adams4", "best2", "rk2", "rk3", "rk4", "a=0.5,0.5;b=1.5"),
        *("heun", "abm4", "hamming4", "o30c31", "a=0.5,0.5;b=1.5;c=0.25,0.75;d=1,0.5,0.25"),
    ],
)
def test_the_map_is_what_the_core_does_to_a_small_disturbance(
    equations: str, integrator: str
) -> None:
    boat = flown("bb2", integrator, 0.7, equations)
    assert bring_to(boat, 6.0)
    response = measure_response(boat)
    places = [MOTION.index(name) for name in response.names]
    s = boat.state
    s.z = 1000.0
    trim = np.array(s.motion)
    s.rates[:] = s.past_rates[:] = 0.0
    s.past_motion[:] = trim
    s.history = float(PAST_CYCLES)
    tick = tick_map(response, boat.records.scheme, 0.7)
    disturbance = np.zeros(len(tick))
    disturbance[:8] = 1e-6 * np.array([1.0, -2.0, 1.5, 0.2, 0.1, -0.1, 0.3, -0.2])
    s.motion[places] += disturbance[:8]

    for _ in range(6):
        advance(*boat.records)
        disturbance = tick @ disturbance

    assert (s.motion - trim)[places] == pytest.approx(disturbance[:8], rel=1e-3, abs=1e-10)


@pytest.mark.parametrize(
    ("name", "integrator", "speed"),
    [
        ("bb2", "adams2", 3.0),
        ("bb2", "euler", 3.0),
        ("sdv-mk9", "adams2", 6.0),
    ],
)
def test_roll_decays_just_below_the_largest_step_and_grows_just_above(
    name: str, integrator: str, speed: float
) -> None:
    file = load_vessel(name)
    limit = stable_step(flown(name, integrator, 0.1), [speed * KNOT]).largest

    def late_over_early(step: float) -> float:
        boat = Boat(file, Method("full", "lagged", "exact", integrator, step))
        assert bring_to(boat, speed * KNOT)
        boat.state.rates[:] = 0.0
        boat.state.z = 1000.0
        upright = float(boat.state.phi)
        boat.state.phi += 1e-7
        heel = []
        for _ in range(600):
            advance(*boat.records)
            heel.append(abs(float(boat.state.phi) - upright))
        return max(heel[-100:]) / max(heel[200:300])

    assert late_over_early(0.96 * limit) < 0.97
    assert late_over_early(1.04 * limit) > 1.03


def test_bb2_flies_at_half_and_one_second_by_adams_and_not_by_euler(bb2: CheckReport) -> None:
    assert bb2.stable
    assert {(v.step_s, v.stable) for v in bb2.verdicts} == {(0.5, True), (1.0, True)}
    assert not stable_step(flown("bb2", "euler", 0.5), [5.0 * KNOT]).ok


def test_remus_flies_at_a_twentieth_of_a_second_but_not_at_half(remus: CheckReport) -> None:
    for equations in ("full", "modified"):
        short = stable_step(flown("remus100", "adams2", 0.05, equations), REMUS_SPEEDS)
        long = stable_step(flown("remus100", "adams2", 0.5, equations), REMUS_SPEEDS)

        assert short.ok
        assert not long.ok
        assert long.worst.startswith("roll at ")
        assert 0.05 < short.largest == long.largest < 0.1
    assert not remus.stable
    assert all(verdict.stable == (verdict.step_s < 0.1) for verdict in remus.verdicts)
    assert "NOT STABLE" in render(remus)


def test_the_vessels_own_step_is_judged_too() -> None:
    file = load_vessel("bb2")
    slow = replace(file, run=replace(file.run, step_s=2.0))

    report = check_vessel(slow)

    assert not report.stable
    assert {v.step_s for v in report.verdicts if not v.stable} == {2.0}


def test_the_root_to_blame_is_called_by_its_motion() -> None:
    boat = flown("bb2", "adams2", 0.5)
    response = boat_responses(boat, [10.0 * KNOT])[10.0 * KNOT]
    tick = tick_map(response, boat.records.scheme, 0.5)
    roots = np.linalg.eigvals(tick)
    groups = {"heave": "pitch", "spiral": "sway-yaw"}

    for mode in modes(response.nature, response.names):
        root = roots[np.argmin(abs(roots - np.exp(0.5 * mode.eigenvalue)))]
        assert leading_motion(response, tick, root) == groups.get(mode.name, mode.name)


def test_the_variable_method_is_stable_at_any_step() -> None:
    answer = stable_step(flown("bb2", "rkv", 1.5), [3.0 * KNOT, 20.0 * KNOT])

    assert answer == StepVerdict(ok=True, largest=math.inf, worst="nothing")


def test_the_longitudinal_set_has_no_roll_to_fear() -> None:
    boat = flown("bb2", "adams2", 1.5, "longitudinal")
    answer = stable_step(boat, [3.0 * KNOT, 20.0 * KNOT])

    assert measure_response(boat).names == ("u", "w", "q", "theta")
    assert answer.ok
    assert answer.largest > 2.0


@pytest.mark.clock
def test_asking_leaves_the_boat_as_it_was_and_takes_no_time() -> None:
    boat = flown("bb2", "adams2", 0.5, "modified")
    boat.start(10.0 * KNOT, 60.0, 0.3)
    before = boat.snapshot()
    speeds = [speed * KNOT for speed in (3.0, 5.0, 10.0, 15.0, 20.0)]
    stable_step(boat, speeds)

    start = time.thread_time()
    stable_step(boat, speeds)

    assert time.thread_time() - start < 0.5  # [s] of processor: 0.01, however busy the machine is
    assert boat.snapshot().tobytes() == before.tobytes()


# --- the hull


def test_bb2_has_its_margins_of_stability(bb2: CheckReport) -> None:
    assert bb2.margins == pytest.approx({"Gv": 0.452, "Gh": 0.414}, rel=0.01)


def test_margins_follow_suboffs_convention() -> None:
    # Gv = 1 - .01 (-.005 + m')/(-.02 * -.004), Gh = 1 - (-.01) (.005 - m')/(-.02 * -.004), m' = .02
    file = refsub()
    given = {"M_w": 0.01, "Z_q": -0.005, "Z_w": -0.02, "M_q": -0.004}
    given |= {"N_v": -0.01, "Y_r": 0.005, "Y_v": -0.02, "N_r": -0.004}
    mass = 0.02 * 0.5 * file.fluid.rho * file.hull.length**3
    boat = replace(
        file,
        coefficients={**file.coefficients, **given},
        hull=replace(file.hull, mass=mass),
    )

    assert check_module.margins(boat) == pytest.approx({"Gv": -0.875, "Gh": -0.875})


def test_a_boat_without_damping_has_no_margins() -> None:
    file = refsub()
    boat = replace(file, coefficients={**file.coefficients, "M_q": 0.0, "N_r": 0.0})

    assert check_module.margins(boat) == {"Gv": None, "Gh": None}


def test_planes_reverse_at_their_critical_speed_and_absent_ones_have_none(
    bb2: CheckReport, remus: CheckReport
) -> None:
    assert bb2.critical_speed_kn["stern"] == pytest.approx(4.8, abs=0.05)
    assert remus.critical_speed_kn["bow"] is None


def test_absent_coefficients_are_told_apart_by_what_the_compact_set_keeps(
    remus: CheckReport,
) -> None:
    assert "K_p" in remus.absent_but_kept["K"]
    assert "N_avr" in remus.absent_and_dropped["N"]
    assert "K_p" not in remus.absent_and_dropped["K"]
    assert "N_v" not in remus.absent_but_kept["N"]
    assert "a1" not in json.dumps(asdict(remus))


def test_what_differs_between_port_and_starboard_is_listed(bb2: CheckReport) -> None:
    assert bb2.asymmetries == {"K_star": -2e-5, "K_star_eta": -2e-5}
    file = refsub()
    tilted = replace(file, hull=replace(file.hull, cg=(0.0, 0.1, 0.3), Ixy=5.0))
    assert check_module.asymmetries(tilted) == {"y_G": 0.1, "I_xy": 5.0}


def test_an_impossible_mass_matrix_is_called_so() -> None:
    file = refsub()
    odd = replace(file, coefficients={**file.coefficients, "N_vdot": 0.05, "Y_rdot": 0.05})

    assert check_module.inertia(file, 0.5).definite
    assert not check_module.inertia(odd, 0.5).definite


def test_the_lagged_sweep_forgets_at_the_rate_given() -> None:
    # contraction: the error of the lagged accelerations after ten more sweeps, per sweep
    boat = flown("bb2", "adams2", 0.5)
    response = boat_responses(boat, [5.0])[5.0]
    rate = check_module.inertia(load_vessel("bb2"), 0.5).contraction["full"]
    error = np.ones(8)
    sizes = []
    for _ in range(6):
        error = response.G @ error
        sizes.append(float(np.linalg.norm(error)))

    assert sizes[-1] / sizes[-2] == pytest.approx(rate, rel=0.01)
    assert rate < 0.1


# --- the turn, the speeds and the page


def test_bb2_turns_as_published_by_the_full_set_and_tighter_by_the_compact(
    bb2: CheckReport,
) -> None:
    turn = bb2.turn
    assert turn.full is not None
    assert turn.modified is not None
    assert turn.full.diameter_m == pytest.approx(255.0, rel=0.02)
    assert turn.full.speed_kn == pytest.approx(6.18, rel=0.02)
    assert turn.full.yaw_rate_deg_s == pytest.approx(1.428, rel=0.02)
    assert turn.full.heel_deg == pytest.approx(2.1, rel=0.05)
    change = 100.0 * (turn.modified.diameter_m / turn.full.diameter_m - 1.0)
    assert turn.percent["diameter_m"] == pytest.approx(change)


def test_a_turn_that_cannot_be_flown_says_why() -> None:
    file = load_vessel("remus100")  # 2 kn do not hold its buoyancy down
    turn = compare_turns(replace(file, run=replace(file.run, start_speed_kn=2.0)))

    assert turn.full is None
    assert "no straight level flight at 2 kn" in turn.problem


def test_a_turn_that_loses_its_numbers_says_where(monkeypatch: pytest.MonkeyPatch) -> None:
    # a boat in trim hardly can any more
    monkeypatch.setattr("trainer.analysis.check.Boat.fly", lambda *_: 4)
    turn = compare_turns(load_vessel("sdv-mk9"))

    assert turn.full is None
    assert "pdot is out of all bounds" in turn.problem


def test_a_turn_that_never_settles_is_given_up(bb2: CheckReport) -> None:
    file = refsub()
    crawling = compare_turns(replace(file, run=replace(file.run, start_speed_kn=0.1)))

    assert "not steady after 10000 s" in crawling.problem
    assert "cannot be compared" in render(replace(bb2, turn=crawling))


@pytest.mark.parametrize(
    ("ends", "speeds"),
    [
        ((3.0, 20.0), (3.0, 5.0, 10.0, 15.0, 20.0)),
        ((1.0, 6.0), (1.0, 2.0, 3.0, 4.0, 5.0, 6.0)),
        ((2.2, 4.5), (2.2, 2.5, 3.0, 3.5, 4.0, 4.5)),
        ((0.1, 60.0), (0.1, 10.0, 20.0, 30.0, 40.0, 50.0, 60.0)),
    ],
)
def test_speeds_are_round_between_the_ends(
    ends: tuple[float, float], speeds: tuple[float, ...]
) -> None:
    assert round_speeds(*ends) == pytest.approx(speeds)


def test_a_body_that_nothing_damps_may_take_any_step() -> None:
    file = refsub()
    still = tuple(replace(row, a=0.0, b=0.0, c=0.0) for row in file.propulsion.sets)
    brick = replace(
        file,
        coefficients=dict.fromkeys(file.coefficients, 0.0),
        propulsion=replace(file.propulsion, sets=still),
        thrust=thrust_of(still, 1.2),
        hull=replace(file.hull, cg=(0.0, 0.0, 0.0), cb=(0.0, 0.0, 0.0)),
    )

    report = check_vessel(brick)

    assert report.stable
    assert report.largest_flown_s["full"]["adams2"] is None
    assert "largest: Adams 2 any, Euler any" in render(report)
    assert json.dumps(asdict(report), allow_nan=False)


def test_the_page_tells_the_boat_afloat_and_the_parts_of_a_step() -> None:
    report = check_vessel(load_vessel("bb2"))
    assert report.afloat.parts == {0.5: 2, 1.0: 4}
    assert report.afloat.period_s["heave"] == pytest.approx(8.83, abs=0.05)
    assert not report.clipped
    assert "steps are divided       0.5 s in 2, 1 s in 4" in render(report)


def test_a_key_that_is_cut_at_a_bound_is_told_with_both_figures() -> None:
    report = check_vessel(load_vessel("bb2"))
    (lift,) = report.bounded
    assert (lift.key, lift.given) == ("[envelope] sail_lift", 0.0393)
    assert lift.flown == pytest.approx(0.02644, abs=1e-5)
    assert "bound: [envelope] sail_lift 0.0393 is flown as 0.02644" in render(report)
    (drag,) = check_vessel(load_vessel("sdv-mk9")).bounded
    assert (drag.key, drag.given) == ("[coefficients] X_dsds", -0.01)
    assert drag.flown == pytest.approx(-0.01825)


def test_a_step_of_the_propeller_s_torque_is_told() -> None:
    """BB2 at eta = 2: K_star u^2 + K_star_eta u (u_c - u) inside is half of K_star u_c^2."""
    (seen,) = check_vessel(load_vessel("bb2")).remarks

    assert "-46.92 kN m by the coefficients, -93.85 kN m beyond their range" in seen
    assert "-0.14 deg of heel" in seen
    assert check_vessel(load_vessel("sdv-mk9")).remarks == ()


@pytest.mark.parametrize("equations", ["full", "modified"])
def test_remus_lists_to_port_by_her_propeller_s_torque(equations: str) -> None:
    """-0.543 N m at 1.5436 m/s over z_G W is 5.3 deg; she needs turns for more, and rudder."""
    file = load_vessel("remus100")
    boat = Submarine(file, own_method(file, equations))
    boat.start(1.5436)
    state, hull = boat.boat.state, file.hull

    torque = 0.5 * 1030.0 * hull.length**3 * 1.5436**2 * file.coefficients["K_star"]
    assert torque == pytest.approx(-0.543, rel=1e-3)
    assert math.degrees(torque / (hull.cg[2] * hull.weight)) == pytest.approx(-5.31, abs=0.01)
    assert math.degrees(state.phi) == pytest.approx(-5.52, abs=0.05)
    assert math.degrees(state.delta_r) == pytest.approx(-0.52, abs=0.02)


def test_remus_s_list_and_her_slow_turn_while_she_dives_are_told(remus: CheckReport) -> None:
    file = load_vessel("remus100")
    dive = ClimbingTurn(4.0, 3.0, direction=DIVE, duration_s=40.0)
    flight = fly_manoeuvre(Submarine(file, own_method(file, "full")), dive, 3.0 * KNOT)
    (rate,) = (one.value for one in dive.measures(flight) if one.name == "steady yaw rate")

    told = " ".join(render(remus).split())
    assert rate is not None
    assert math.degrees(rate) == pytest.approx(4.8, abs=0.05)
    assert "lists her to port: 5.3 deg at 1.54 m/s by K / (z_G W). Flown it is 5.5 deg" in told
    assert "turns at 4.8 deg/s where the source's law gives 6.3, 24 % less" in told
