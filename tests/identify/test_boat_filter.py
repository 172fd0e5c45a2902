"""A boat's motion and its filter. Fixed numbers are of the model's section 12."""

import math
from dataclasses import replace

import numpy as np
import pytest

from trainer.boat.assemble import Method
from trainer.boat.boat import Boat
from trainer.config.boat.vessel import load_vessel
from trainer.core import full
from trainer.core.kernel import Numbers
from trainer.core.kinematics import attitude_of
from trainer.core.terms import COEFFICIENTS
from trainer.identify.boat.figures import sail_figures
from trainer.identify.boat.filter import (
    CHANNEL_COUNT,
    FilterResult,
    FilterStart,
    RecordNumbers,
    filter_record,
    predict_reading,
    sail_controls,
)
from trainer.identify.boat.matrices import invert_positive, root_of_covariance
from trainer.identify.boat.motion import (
    MOTION_COUNT,
    STATE,
    STATE_COUNT,
    BoatNumbers,
    write_rates,
)
from trainer.identify.boat.regressors import (
    ATOM_PLACES,
    FITTED_TERMS,
    PARAMETER_NAMES,
    split_factors,
)
from trainer.identify.boat.vessel import FittedVessel
from trainer.units import DEGREE

BB2 = FittedVessel(load_vessel("bb2"))
COUNT = 200
# the state at the last reading, of an independent program
LAST_STATE = (
    *(4.536341113, 0.262418932, -0.06638658573, 7.50766343e-4, 7.652155972e-4, -0.005575548589),
    *(-0.01915270461, -0.05043306366, -0.9658099782, 64.62289138),
)
MINUS_LOG_LIKELIHOOD = -3183.396537
SUMS = {  # of slopes times innovations, and of slopes squared, over variances
    "N_v": (7603.0, 2.63643e8),
    "Y_r": (1219.0, 2.19801e7),
    "N_dr": (311.78, 4.01066e8),
    "Z_w": (-95.30, 5.44977e5),
    "M_ds": (-4471.4, 1.65099e8),
    "K_p": (-3490.2, 1.93719e8),
    "M_qdot": (-2440.2, 4.06318e8),
    "a1": (4344.0, 1.47028e9),
    "z_b": (45.60, 6.53227e4),
}
ERRORS = np.array([0.05, 0.2 * DEGREE, 0.1 * DEGREE, 0.2 * DEGREE, 0.1])


def fixed_record(noise: float = 1.0) -> RecordNumbers:
    """Return the record of section 12, its errors times ``noise``."""
    k = np.arange(float(COUNT))
    inputs = np.column_stack(
        [
            0.15 * np.sin(0.05 * k),
            0.05 * np.sin(0.08 * k),
            0.03 * np.cos(0.06 * k),
            5.0 + 0.2 * np.sin(0.02 * k),
        ]
    )
    empty = RecordNumbers(np.zeros((0, CHANNEL_COUNT)), inputs, 1.0, 2)
    states = sail_controls(BB2.numbers(BB2.values), empty, fixed_start().state)
    readings = np.full((COUNT, CHANNEL_COUNT), np.nan)
    for channel, at in enumerate((STATE.U, STATE.PSI, STATE.THETA, STATE.PHI, STATE.Z)):
        wave = noise * ERRORS[channel] * np.sin((channel + 1) * k * k)
        readings[:, channel] = states[:, at] + wave
    readings[np.arange(COUNT) % 7 == 3, 0] = np.nan
    readings[1::2, 4] = np.nan
    return empty._replace(readings=readings)


def fixed_start() -> FilterStart:
    """Return the start of section 12."""
    state = np.zeros(STATE_COUNT)
    state[STATE.U], state[STATE.Z] = 5.0, 60.0
    motion = [0.3, 0.2, 0.2, 0.005, 0.005, 0.005, DEGREE, DEGREE, DEGREE, 1.0]
    sd = np.array([*motion, 1e-3, 0.01, 0.2 * DEGREE, 0.5 * DEGREE, 0.02, 0.0, 0.0])
    disturbance = np.array([3e-3, 3e-3, 3e-3, 1e-4, 5e-5, 3e-5])
    errors = np.append(ERRORS, np.zeros(CHANNEL_COUNT - len(ERRORS)))
    return FilterStart(state, np.diag(sd**2), disturbance, np.zeros(7), errors, math.inf)


def run_fixed(values: np.ndarray, count: int, noise: float = 1.0) -> FilterResult:
    found: FilterResult = filter_record(
        BB2.numbers(values), fixed_record(noise), fixed_start(), count
    )
    return found


def test_a_boat_sails_as_an_independent_program_has_it() -> None:
    empty = fixed_record()
    states = sail_controls(BB2.numbers(BB2.values), empty, fixed_start().state)
    assert states[-1, :MOTION_COUNT] == pytest.approx(LAST_STATE, rel=1e-9)


@pytest.mark.long
def test_the_likelihood_is_that_of_the_statement() -> None:
    found = run_fixed(BB2.values, 0)
    assert found.cost == pytest.approx(MINUS_LOG_LIKELIHOOD, abs=1e-3)
    assert int(np.isfinite(found.innovations).sum()) == 871


@pytest.mark.long
def test_slopes_and_information_are_those_of_the_statement() -> None:
    found = run_fixed(BB2.values, len(PARAMETER_NAMES))
    for name, (gradient, information) in SUMS.items():
        j = PARAMETER_NAMES.index(name)
        assert found.gradient[j] == pytest.approx(gradient, rel=1e-3), name
        assert found.information[j, j] == pytest.approx(information, rel=1e-3), name
    assert (found.information == found.information.T).all()


@pytest.mark.long
def test_slopes_cost_no_digit_of_the_likelihood() -> None:
    assert run_fixed(BB2.values, 0).cost == run_fixed(BB2.values, len(PARAMETER_NAMES)).cost


@pytest.mark.long
@pytest.mark.parametrize("name", ["N_v", "Z_w", "N_dr", "M_qdot", "b1", "z_b"])
def test_slopes_are_those_of_innovations_where_the_gain_hardly_moves(name: str) -> None:
    j = PARAMETER_NAMES.index(name)
    change = np.zeros(len(PARAMETER_NAMES))
    change[j] = 1e-4 * abs(BB2.values[j])
    up, down = (run_fixed(BB2.values + sign * change, 0, noise=0.0) for sign in (1.0, -1.0))
    here = run_fixed(BB2.values, len(PARAMETER_NAMES), noise=0.0)
    slope = (up.innovations - down.innovations) / (2.0 * change[j])
    assert np.nansum(slope**2 / here.variances) == pytest.approx(here.information[j, j], rel=2e-3)


def test_all_terms_push_as_in_the_full_set() -> None:
    rng = np.random.default_rng(3)
    random = {term.key: 1e-2 * float(rng.normal()) for term in COEFFICIENTS}
    hull = replace(BB2.file.hull, cg=(0.3, 0.05, 0.1), cb=(0.2, -0.04, -0.5), Ixz=2e6, Ixy=1e6)
    file = replace(BB2.file, coefficients=random, hull=replace(hull, Iyz=-3e6))
    vessel = FittedVessel(file)
    boat = Boat(file, Method("full", "exact", "exact", "rk4", 0.1))
    boat.state.weight = hull.weight
    boat.state.x_g, boat.state.y_g, boat.state.z_g = hull.cg
    record, state, force, matrix = boat.records.vessel, boat.state, np.zeros(6), np.eye(6)
    atoms, scratch, rate = np.zeros(ATOM_PLACES.RDOT + 1), np.zeros(6), np.zeros(MOTION_COUNT)
    for _ in range(10):
        x = np.zeros(STATE_COUNT)
        x[:9] = rng.normal(size=9) * [0.5, 0.5, 0.5, 0.02, 0.02, 0.02, 0.2, 0.2, 1.0]
        x[STATE.U] += 5.0
        control = np.append(rng.normal(size=3) * 0.2, 5.5)
        names = ("u", "v", "w", "p", "q", "r", "phi", "theta", "psi")
        for name, value in zip(names, x[:9], strict=True):
            state[name] = value
        state.delta_r, state.delta_s, state.delta_b, state.u_c = control
        write_rates(vessel.numbers(vessel.values), x, control, atoms, scratch, rate)
        attitude = attitude_of(0, boat.records.state)
        full.forces(record, attitude, boat.records.state, force)
        full.inertia(record, boat.records.state, matrix)
        assert rate[:6] == pytest.approx(np.linalg.solve(matrix, force), rel=1e-9, abs=1e-12)


def test_every_term_has_the_factors_that_its_table_prints() -> None:
    factors = {term.key: split_factors(term) for term in FITTED_TERMS}
    assert factors["a1"] == ["u", "|u|"]
    assert factors["Z_ww"] == ["|w|", "(v^2+w^2)^0.5"]
    assert factors["X_drdr_eta"] == ["u", "u", "dr", "dr", "(eta-1)"]
    assert len(factors) == 125
    assert PARAMETER_NAMES[-1] == "z_b"


@pytest.mark.parametrize("channel", range(CHANNEL_COUNT))
def test_the_slopes_of_a_reading_are_its_differences(channel: int) -> None:
    x = np.linspace(0.1, 0.9, STATE_COUNT)
    h, other = np.zeros(STATE_COUNT), np.zeros(STATE_COUNT)
    here = predict_reading(x, channel, h)
    for i in range(STATE_COUNT):
        moved = x.copy()
        moved[i] += 1e-6
        assert h[i] == pytest.approx(
            (predict_reading(moved, channel, other) - here) / 1e-6, abs=1e-5
        )


@pytest.mark.long
def test_a_boat_that_is_lost_has_no_likelihood() -> None:
    values = BB2.values.copy()
    values[PARAMETER_NAMES.index("a1")] = 1.0  # drag that drives it
    assert run_fixed(values, 0).cost == math.inf


def test_roots_and_inverses_are_exact_and_take_a_singular_matrix() -> None:
    rng = np.random.default_rng(1)
    thin = rng.normal(size=(6, 3))
    singular, whole = thin @ thin.T, thin @ thin.T + np.eye(6)
    assert root_of_covariance(singular) @ root_of_covariance(singular).T == pytest.approx(
        singular, abs=1e-9
    )
    assert invert_positive(whole) == pytest.approx(np.linalg.inv(whole), rel=1e-10)


def heave_at_middle(w: float, state: Numbers, boat: BoatNumbers, record: RecordNumbers) -> float:
    """Return the heave [m/s] at the middle of the first step, of a boat that begins with ``w``."""
    begun = state.copy()
    begun[STATE.W] = w
    whole = record._replace(interval=record.interval / record.steps, steps=1)
    return 0.5 * float(w + sail_controls(boat, whole, begun)[1, STATE.W])


def test_no_slope_is_taken_across_the_sign_of_heave() -> None:
    """A force has a step there (Z_waq), and the slope across it would be that of a wall."""
    values = BB2.values.copy()
    values[PARAMETER_NAMES.index("Z_waq")] = -0.008
    boat, record = BB2.numbers(values), fixed_record(0.0)
    still = np.repeat(record.inputs[:1], 2, axis=0)
    record = record._replace(readings=np.full((2, CHANNEL_COUNT), np.nan), inputs=still)
    state = fixed_start().state.copy()
    state[[STATE.V, STATE.Q]] = 0.8, 0.01
    low, high = -0.5, 0.5
    for _ in range(60):  # until the heave at the middle is a hair below zero
        between = 0.5 * (low + high)
        above = heave_at_middle(between, state, boat, record) > -5e-7
        low, high = (low, between) if above else (between, high)
    assert -1e-6 < heave_at_middle(low, state, boat, record) < 0.0
    ends = []
    for w in (low, low - 1e-3):
        state[STATE.W] = w
        start = fixed_start()._replace(state=state.copy())
        ends.append(filter_record(boat, record, start, 0).covariance)
    assert ends[0] == pytest.approx(ends[1], rel=0.01, abs=1e-6)


def test_a_boat_that_lacks_inertia_sails_no_figure() -> None:
    values = BB2.values.copy()
    assert BB2.has_inertia(values)
    values[PARAMETER_NAMES.index("K_pdot")] = 1e-3
    assert not BB2.has_inertia(values)
    sailed = [*sail_figures(BB2.with_values(values))]
    assert sailed
    assert all(flight is None for _, _, flight in sailed)
