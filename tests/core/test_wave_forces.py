"""Forces of waves and of the calm surface on the boat, and what of her shows."""

import json
from typing import Any

import numpy as np
import pytest
from helpers.boats import make_boat
from helpers.places import DATA
from numba import njit

from trainer.core.kernel import Record
from trainer.core.sea.cosine_sum import ANGLE_COS, ANGLE_SIN, DIRECTION_WEIGHTS, phase, prepare_sum
from trainer.core.sea.forces import suction, wave_forces
from trainer.core.sea.free_surface import deck_height, sail_height, surface_forces
from trainer.core.sea.sea import advance_sea, order_sea
from trainer.core.state import new_scratch, new_state
from trainer.core.vessel import STRIP_SHARES, STRIP_STATIONS, vessel_record

pytestmark = pytest.mark.core

VECTORS = json.loads((DATA / "waves.json").read_text(encoding="utf-8"))
X, Y, Z, K, M, N = range(6)
RHO, G, ELL, VOLUME = 1025.0, 9.81, 70.0, 4000.0
ADDED = {"X_udot": -0.0012, "Y_vdot": -0.03, "Z_wdot": -0.02}
K_WAVE = 0.03  # [1/m]
A_C, A_S = 0.8, -0.5  # [m] a cos A, a sin A
TABLE = 1e-3  # [-] of the strips' whole mass: their sums are read from a table


def a_vessel(**other: float) -> Record:
    """Return constants of a boat of which only what waves push on is known."""
    body = {
        **dict.fromkeys(("mass", "weight", "x_g", "y_g", "z_g", "x_b", "y_b", "z_b"), 0.0),
        **dict.fromkeys(("I_x", "I_y", "I_z", "I_xy", "I_yz", "I_xz"), 0.0),
        "rho": RHO,
        "g": G,
        "ell": ELL,
        "buoyancy": RHO * G * VOLUME,
    } | other
    return vessel_record(body, ADDED, (0.0, 0.0, 0.0))


def moved(added: str) -> float:
    """Return displaced and added mass [kg]."""
    return RHO * VOLUME - 0.5 * RHO * ELL**3 * ADDED[added]


def one_wave(depth: float = 30.0, direction: float = 0.0, **fields: float) -> Record:
    """Return the state under one long-crested wave, as the filter of 1969 gives it."""
    state = new_state()
    state["sea_1969"] = 1.0
    state["sea_height"], state["sea_omega"] = 4.0, np.sqrt(G * K_WAVE)
    state["sea_elevation"], state["sea_quadrature"] = A_C, A_S
    state["z"], state["sea_direction"] = depth, direction
    for name, value in fields.items():
        state[name] = value
    return state


def force_of(state: Record, vessel: Record | None = None, sea: Record | None = None) -> np.ndarray:
    """Return the wave forces [N, N m] on the boat."""
    force = np.zeros(6)
    wave_forces(
        a_vessel() if vessel is None else vessel,
        sea if sea is not None else new_scratch(),
        state,
        force,
    )
    return force


def as_a_box(vessel: Record) -> Record:
    """Give a boat's mass the shape of a box, by Gauss and Legendre's seven points."""
    nodes, weights = np.polynomial.legendre.leggauss(7)
    vessel["strips"][0] = [0.5 * nodes, *[0.5 * weights] * 3]
    return vessel


@pytest.mark.parametrize("case", VECTORS["force_component_project_extension"]["cases"])
def test_one_component_on_a_box_as_in_the_model_document(case: Any) -> None:
    table = VECTORS["force_component_project_extension"]
    phys, coef = table["phys"], table["coef"]
    g = 32.2  # of the waves; the boat's own is 32.174, kept in her displaced mass
    body = dict.fromkeys(("mass", "weight", "x_g", "y_g", "z_g", "x_b", "y_b", "z_b"), 0.0)
    body |= dict.fromkeys(("I_x", "I_y", "I_z", "I_xy", "I_yz", "I_xz"), 0.0)
    body |= {"rho": phys["RHO"], "g": g, "ell": phys["L"], "buoyancy": phys["B"] * g / phys["G"]}
    prime = {"X_udot": coef["XUD"], "Y_vdot": coef["YVD"], "Z_wdot": coef["ZWD"]}
    k, mu = case["w"] ** 2 / g, case["mu"]
    way = case["x"] * np.cos(mu) + case["y"] * np.sin(mu)
    angle = case["w"] * case["t"] - k * way + case["eps"]
    state = one_wave(case["depth"], mu, psi=case["psi"], sea_omega=case["w"])
    state["sea_elevation"] = case["a"] * np.cos(angle)
    state["sea_quadrature"] = case["a"] * np.sin(angle)
    vessel = as_a_box(vessel_record(body, prime, (0.0, 0.0, 0.0)))
    size = case["a"] * g * k * np.exp(-k * case["depth"])
    mass = phys["B"] / phys["G"] - 0.5 * phys["RHO"] * phys["L"] ** 3 * min(prime.values())
    whole = size * mass * np.array([1, 1, 1, 1, phys["L"] / 4, phys["L"] / 4])

    force = force_of(state, vessel)

    assert np.all(abs(force - case["force"]) < TABLE * whole)


def exact(vessel: Record, k: float, chi: float, depth: float) -> np.ndarray:
    """Return the forces on the strips by their sums, one by one."""
    c = vessel[0]
    x, *shares = c["strips"] * np.array([[c["ell"]], [1.0], [1.0], [1.0]])
    displaced = c["buoyancy"] / c["g"]
    m, a, b = (
        size * share
        for size, share in zip((displaced, -c["Z_wdot"], -c["Y_vdot"]), shares, strict=True)
    )
    swing = c["g"] * k * np.exp(-k * depth)
    c_i, s_i = np.cos(k * x * np.cos(chi)), np.sin(k * x * np.cos(chi))
    C = swing * (A_C * c_i + A_S * s_i)
    S = swing * (A_S * c_i - A_C * s_i)
    side = -np.sin(chi) * np.sum((m + b) * S)
    return np.array(
        [
            -np.cos(chi) * (1.0 - c["X_udot"] / displaced) * np.sum(m * S),
            side,
            np.sum((m + a) * C),
            -(c["K_vdot"] + c["z_b"] * displaced) * side / (displaced - c["Y_vdot"]),
            -np.sum((m + a) * x * C),
            -np.sin(chi) * np.sum((m + b) * x * S),
        ]
    )


@pytest.mark.parametrize("k", [1e-9, 0.003, 0.02, 0.0428, 0.12, 0.3])
@pytest.mark.parametrize("chi", [0.0, 0.7, 1.57, 2.5, np.pi, -2.0])
def test_one_wave_pushes_on_each_strip_of_bb2(k: float, chi: float) -> None:
    vessel = make_boat("bb2").records.vessel
    state = one_wave(15.0, chi, sea_omega=np.sqrt(G * k))
    expected = exact(vessel, k, chi, 15.0)
    swing = G * k * np.exp(-k * 15.0)
    whole = swing * 9.7e6 * np.array([1, 1, 1, 1, 16.0, 16.0])

    assert np.all(abs(force_of(state, vessel) - expected) < TABLE * whole)


def test_a_boat_that_the_water_takes_along_is_rolled_by_its_weight_alone() -> None:
    vessel = make_boat("bb2").records.vessel
    c = vessel[0]
    state = one_wave(15.0, 0.5 * np.pi, sea_omega=np.sqrt(G * 1e-6))
    force = force_of(state, vessel)
    displaced = c["buoyancy"] / c["g"]
    aside = force[Y] / (displaced - c["Y_vdot"])

    # what is left over the boat's own acceleration is the lever of its weight under its buoyancy,
    # since what hangs in it hangs along the water's own vertical
    left = force[K] + (c["K_vdot"] + c["z_g"] * displaced) * aside
    assert left == pytest.approx((c["z_g"] - c["z_b"]) * displaced * aside, rel=1e-9)


def test_waves_shorter_than_a_fifth_of_the_hull_push_on_no_part_of_it_lengthwise() -> None:
    short = one_wave(direction=0.0, sea_omega=np.sqrt(G * 33.0 / ELL), z=1.0)
    abeam = one_wave(direction=np.pi / 2, sea_omega=np.sqrt(G * 33.0 / ELL), z=1.0)

    assert not np.any(force_of(short))
    assert force_of(abeam)[Z] != 0.0


def test_the_strips_of_a_hull_that_gives_none_are_its_full_integral() -> None:
    # ellipsoid nose to 0.165 L, parallel to 0.715 L, cusped tail: section areas over the largest
    s = np.linspace(0.0, 1.0, 20_001)
    area = np.ones(s.size)
    area[s < 0.165] = 1.0 - ((0.165 - s[s < 0.165]) / 0.165) ** 2
    tail = np.clip((s - 0.715) / 0.285, 0.0, 1.0)
    area *= (1.0 - tail**2.3) ** 2.9
    x = np.trapezoid(area * s, s) / np.trapezoid(area, s) - s
    density = area / np.trapezoid(area, s)
    places, shares = np.array(STRIP_STATIONS), np.array(STRIP_SHARES)

    assert np.trapezoid(area, s) == pytest.approx(0.81, abs=0.01)
    for kappa in (1.0, 2.0, 4.2, 6.0, 8.4):  # the last: k = 0.12 at 70 m
        whole = np.trapezoid(density * np.exp(1j * kappa * x), s)
        pitch = np.trapezoid(density * x * np.exp(1j * kappa * x), s)
        assert abs(np.sum(shares * np.exp(1j * kappa * places)) - whole) < 0.006
        assert abs(np.sum(shares * places * np.exp(1j * kappa * places)) - pitch) < 0.025 * 0.17


def test_a_crest_overhead_pushes_down_by_hand() -> None:
    # beam sea: no averaging over the length; 9.81 * 0.03 * exp(-0.9) * 0.8 m of acceleration
    pushed = moved("Z_wdot") * G * K_WAVE * np.exp(-0.9) * A_C

    assert force_of(one_wave(direction=np.pi / 2))[Z] == pytest.approx(pushed, rel=1e-9)


def test_forces_fade_with_depth_as_the_waves_do() -> None:
    shallow, deep = (force_of(one_wave(depth, 0.7)) for depth in (20.0, 70.0))

    assert deep == pytest.approx(shallow * np.exp(-K_WAVE * 50.0), rel=1e-12)


@pytest.mark.laws
def test_head_and_following_seas_mirror() -> None:
    vessel = as_a_box(a_vessel())
    following, head = force_of(one_wave(), vessel), force_of(one_wave(direction=np.pi), vessel)
    signs = np.array([-1.0, 1.0, 1.0, 1.0, -1.0, 1.0])

    assert head == pytest.approx(signs * following, abs=1e-9 * np.abs(following).max())
    assert following[X] > 0.0
    assert following[M] != 0.0


@pytest.mark.laws
def test_seas_from_port_and_starboard_mirror() -> None:
    to_starboard, to_port = force_of(one_wave(direction=0.7)), force_of(one_wave(direction=-0.7))

    assert to_port == pytest.approx(to_starboard * [1, -1, 1, -1, 1, -1], rel=1e-12)
    assert to_starboard[Y] > 0.0


def test_only_the_relative_heading_counts() -> None:
    assert force_of(one_wave(direction=2.0, psi=1.3)) == pytest.approx(
        force_of(one_wave(direction=0.7)), rel=1e-12
    )


def test_the_cosine_sum_is_the_sum_of_its_components() -> None:
    state = one_wave(25.0, 0.4, psi=0.1, sea_cosines=1.0, sea_gamma=1.0, seed=4)
    state["sea_turned"], state["sea_along"], state["sea_across"] = 12.0, 3.0, -2.0
    sea = new_scratch()
    prepare_sum(1.0, 4.0, sea)
    total = np.zeros(6)
    for i in range(50):
        angle = np.arctan2(ANGLE_SIN[i // 10], ANGLE_COS[i // 10])
        omega = float(state["sea_omega"][0] * sea["relative"][0][i])
        angle_above = phase(sea, state, i)
        alone = one_wave(25.0, 0.4 + angle, psi=0.1, sea_omega=omega)
        alone["sea_elevation"] = DIRECTION_WEIGHTS[i // 10] * np.cos(angle_above)
        alone["sea_quadrature"] = DIRECTION_WEIGHTS[i // 10] * np.sin(angle_above)
        total += force_of(alone)

    assert force_of(state, sea=sea) == pytest.approx(total, rel=1e-12)


def test_suction_draws_the_boat_up_with_the_square_of_the_wave() -> None:
    plain, drawn = force_of(one_wave()), force_of(one_wave(sea_suction=1.0))
    swing = K_WAVE * np.exp(-0.9)
    up = moved("Z_wdot") * G * swing**2 * (A_C**2 + A_S**2)

    assert plain[Z] - drawn[Z] == pytest.approx(up, rel=1e-10)
    assert np.delete(drawn - plain, Z) == pytest.approx(0.0)


def test_suction_on_a_circular_cylinder_is_ogilvie_s() -> None:
    # added mass equal to the displaced: 2 pi rho g (k R)^2 a^2 exp(-2 k d) a metre
    radius = np.sqrt(VOLUME / (ELL * np.pi))
    vessel = a_vessel()
    vessel["Z_wdot"] = -RHO * VOLUME
    state, sucked = one_wave(direction=1.0), one_wave(direction=1.0, sea_suction=1.0)
    per_metre = (force_of(state, vessel) - force_of(sucked, vessel))[Z] / ELL
    square = A_C**2 + A_S**2

    assert per_metre == pytest.approx(
        2.0 * np.pi * RHO * G * (K_WAVE * radius) ** 2 * square * np.exp(-1.8), rel=1e-9
    )


def test_the_hull_s_lift_feels_the_water_s_own_vertical_speed() -> None:
    vessel = make_boat("bb2").records.vessel
    c = vessel[0]
    omega = np.sqrt(G * K_WAVE)
    down = G * K_WAVE * np.exp(-K_WAVE * 30.0) * A_S / omega  # [m/s]
    still = force_of(one_wave(), vessel)

    felt = force_of(one_wave(u=5.0), vessel) - still

    assert felt[Z] == pytest.approx(-float(c["Z_w"]) * 5.0 * down, rel=1e-9)
    assert felt[M] == pytest.approx(-float(c["M_w"]) * 5.0 * down, rel=1e-9)
    assert not np.any(felt[[X, Y, K, N]])
    assert force_of(one_wave(u=-5.0), vessel).tolist() == still.tolist()


# [kN], [kN/m] for Q = 8.129e6 kg: model document, section 5
SUCTIONS = [
    *((4, 18.0, 7.2, 1.28), (4, 20.0, 5.1, 0.87), (5, 18.0, 32.0, 4.1), (5, 22.0, 20.0, 2.3)),
    *((5, 25.0, 14.0, 1.6), (5, 30.0, 8.1, 0.85), (6, 30.0, 27.0, 2.2), (6, 40.0, 12.5, 0.90)),
]
SEA_OF_STATE = {4: (1.875, 0.918), 5: (3.25, 0.697), 6: (5.0, 0.562)}


@pytest.mark.parametrize(("state", "depth", "lift", "slope"), SUCTIONS)
def test_the_mean_suction_and_its_slope_are_those_of_the_spectrum(
    state: int, depth: float, lift: float, slope: float
) -> None:
    height, omega = SEA_OF_STATE[state]
    number = omega**2 / G
    x = np.linspace(0.3, 8.0, 20_001)
    squared = 5.0 * x**-5.0 * np.exp(-1.25 * x**-4.0 - 2.0 * number * depth * x**2)
    scale = 0.125 * G * (number * height) ** 2
    found = suction(G, omega, height, depth)

    assert found[0] == pytest.approx(scale * np.trapezoid(x**4 * squared, x), rel=4e-3)
    assert found[1] == pytest.approx(
        2.0 * number * scale * np.trapezoid(x**6 * squared, x), rel=4e-3
    )
    assert 8.129e3 * found[0] == pytest.approx(lift, rel=0.03)
    assert 8.129e3 * found[1] == pytest.approx(slope, rel=0.03)


def test_a_calm_draws_nothing_and_the_surface_no_more_than_just_below() -> None:
    assert suction(G, 0.7, 0.0, 18.0) == (0.0, 0.0)
    assert suction(G, 0.7, 3.0, 0.0) == suction(G, 0.7, 3.0, 0.3 * G / 0.49)


def test_the_taper_ends_the_waves_at_five_diameters() -> None:
    vessel = a_vessel()
    vessel["diameter"] = 10.0
    left = [
        force_of(one_wave(depth, sea_taper=1.0), vessel)[Z] / force_of(one_wave(depth), vessel)[Z]
        for depth in (20.0, 40.0, 45.0, 49.0, 50.0, 80.0)
    ]

    assert left == pytest.approx([1.0, 1.0, 0.5, 0.028, 0.0, 0.0])


@njit(cache=False)
def _forces(vessel: Any, sea: Any, state: Any, ticks: Any) -> Any:
    out = np.zeros((ticks, 6))
    for i in range(ticks):
        advance_sea(vessel, 0.5, sea, state)
        wave_forces(vessel, sea, state, out[i])
        state[0].tick += 1.0
    return out


def vertical_forces(
    generator: float, pull: float = 0.0, depth: float = 30.0, old: float = 0.0
) -> np.ndarray:
    """Return Z [N] by record and tick at a depth in a sea of 28 knots from ahead."""
    vessel = a_vessel()
    records = []
    for seed in range(8):
        state, sea = new_state(), new_scratch()
        state["seed"], state["z"] = seed, depth
        wanted = np.array([4.426, 0.5974, 1.0, np.pi, generator, pull, old, 0.0, 0.0])
        order_sea(vessel, 0.5, 0.0, wanted, sea, state)
        records.append(_forces(vessel, sea, state, 16_384)[:, Z])
    return np.array(records)


@pytest.mark.slow
def test_all_generators_give_the_vertical_force_the_same_spectrum_within_a_third() -> None:
    # The filters are long-crested with one length for all their waves, the sum has five
    # directions: they need not agree closer.
    omega = 2.0 * np.pi * np.fft.rfftfreq(16_384, 0.5)
    filtered, summed, old = (
        np.mean(np.abs(np.fft.rfft(force)) ** 2, axis=0)
        for force in (vertical_forces(0.0), vertical_forces(1.0), vertical_forces(0.0, old=1.0))
    )
    core = (omega > 0.45) & (omega < 0.8)
    for power in (filtered, old):
        half = [float(np.interp(0.5, np.cumsum(p) / np.sum(p), omega)) for p in (power, summed)]

        assert half[0] == pytest.approx(half[1], rel=0.12)
        assert 0.75 < np.sqrt(np.sum(power) / np.sum(summed)) < 1.34
        assert np.sum(power[core]) / np.sum(power) > 0.7
    assert np.sum(summed[core]) / np.sum(summed) > 0.7


@pytest.mark.long
@pytest.mark.parametrize("depth", [18.0, 30.0])
def test_the_waves_of_the_filter_push_nothing_slowly(depth: float) -> None:
    push = vertical_forces(0.0, depth=depth) * np.hanning(16_384)
    power = np.mean(np.abs(np.fft.rfft(push)) ** 2, axis=0)
    omega = 2.0 * np.pi * np.fft.rfftfreq(16_384, 0.5)

    # below a fifth of the peak's frequency; a leaking row lets 4 to 6 % of it through
    assert np.sqrt(np.sum(power[omega < 0.12]) / np.sum(power)) < 0.01


@pytest.mark.long
@pytest.mark.parametrize("generator", [0.0, 1.0])
def test_suction_varies_slowly_about_a_mean_that_lifts(generator: float) -> None:
    drawn = vertical_forces(generator, 1.0) - vertical_forces(generator, 0.0)
    power = np.mean(np.abs(np.fft.rfft(drawn - np.mean(drawn, axis=1, keepdims=True))) ** 2, axis=0)
    omega = 2.0 * np.pi * np.fft.rfftfreq(16_384, 0.5)

    assert np.all(drawn <= 0.0)
    # below the waves' own frequencies; the filter's pair of outputs leaves some at twice the peak
    assert np.sum(power[omega < 0.4]) / np.sum(power) > 0.6


@pytest.mark.long
@pytest.mark.parametrize("depth", [15.0, 30.0, 60.0])
def test_the_filter_s_mean_suction_is_the_spectrum_s(depth: float) -> None:
    drawn = vertical_forces(0.0, 1.0, depth) - vertical_forces(0.0, 0.0, depth)
    lift = suction(G, 0.5974, 4.426, depth)[0] * moved("Z_wdot")

    # eight records of 2.3 h scatter by 2 to 3 %; between two rows the filter has up to 3 % more
    assert -np.mean(drawn) == pytest.approx(lift, rel=0.1)


# The calm surface


def test_the_calm_surface_lifts_bb2_at_periscope_depth_and_not_deep() -> None:
    boat = make_boat()
    s = boat.state
    forces = {}
    for depth in (13.8724, 15.3724, 16.8724, 35.0624, 60.0):
        s.z, s.u = depth, 5.0
        forces[depth] = np.zeros(6)
        surface_forces(boat.records.vessel, boat.records.state, forces[depth])
    scale = 0.5 * 1025.0 * 70.2**2 * 25.0

    assert forces[13.8724][Z] == pytest.approx(-7.085e-4 * scale)
    assert forces[15.3724][Z] == pytest.approx(-1.149e-3 * scale)
    assert forces[15.3724][M] == pytest.approx(3.89e-5 * scale * 70.2)
    # half way between two depths, half way between their values
    assert forces[16.8724][Z] == pytest.approx(-0.5 * (1.149e-3 + 9.814e-4) * scale)
    assert not np.any(forces[35.0624])
    assert not np.any(forces[60.0])


def test_tables_of_the_calm_surface_are_bilinear_and_end_at_their_edges() -> None:
    vessel = a_vessel()
    vessel["surface_speeds"], vessel["surface_depths"] = 2, 3
    vessel["surface_speed"][0, :2] = [2.0, 6.0]
    vessel["surface_depth"][0, :3] = [10.0, 14.0, 30.0]
    vessel["surface_Z"][0, :2, :3] = [[8.0, 4.0, 0.0], [16.0, 12.0, 0.0]]
    state = new_state()

    def lift(speed: float, depth: float) -> float:
        state["u"], state["z"] = speed, depth
        force = np.zeros(6)
        surface_forces(vessel, state, force)
        return float(force[Z] / speed**2)

    # at 3 m/s and 11 m: 8 - 1 = 7 and 16 - 1 = 15, a quarter of the way: 9
    assert lift(3.0, 11.0) == pytest.approx(9.0)
    assert lift(3.0, 22.0) == pytest.approx(0.5 * (4.0 + 0.25 * 8.0))
    assert lift(-3.0, 11.0) == pytest.approx(9.0)
    assert lift(1.0, 5.0) == pytest.approx(8.0)
    assert lift(9.0, 10.0) == pytest.approx(16.0)
    assert lift(3.0, 29.999) == pytest.approx(0.0, abs=1e-3)


def test_the_sail_shows_before_the_deck() -> None:
    boat = make_boat()
    s, records = boat.state, boat.records
    s.z = 11.3724

    assert sail_height(records.vessel, records.state) == pytest.approx(0.0, abs=1e-12)
    assert deck_height(records.vessel, records.state) == pytest.approx(-5.6)

    s.eta_wave = -1.5  # a trough
    assert sail_height(records.vessel, records.state) == pytest.approx(1.5)

    s.theta, s.eta_wave = 0.2, 0.0  # bow up: 0.25 L sin 0.2 less what the deck leans
    raised = 0.25 * 70.2 * np.sin(0.2) + 5.7724 * np.cos(0.2) - 11.3724
    assert deck_height(records.vessel, records.state) == pytest.approx(raised)
    assert sail_height(records.vessel, records.state) > 0.0  # ahead of the centre of gravity

    s.theta = -0.2
    assert deck_height(records.vessel, records.state) == pytest.approx(raised)
    assert sail_height(records.vessel, records.state) < 0.0
