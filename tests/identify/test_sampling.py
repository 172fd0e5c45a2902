"""Ship models and their exact sampling, against the golden vectors, scipy and arithmetic."""

import json
from typing import Any

import numpy as np
import pytest
from helpers.places import DATA
from numpy.testing import assert_allclose

from trainer.config.files import ConfigError
from trainer.identify.model.models import MODEL_1, MODELS, Blocks, Plant, Ship
from trainer.identify.model.nomoto import nomoto, transfer
from trainer.identify.model.sampled import COMPLEX_STEP, sample_systems, step_aside

VECTORS = json.loads((DATA / "identification" / "discretisation.json").read_text())
A, B, R1 = (np.array(VECTORS[key]) for key in ("A", "B", "R1"))
NO_OUTPUT = {"C": np.zeros((0, 3)), "D": np.zeros((0, 2)), "R12": np.zeros((3, 0))}
SHIP = Ship(160.93, 4.5, 60.0, 70.0)
# every model at numbers that make all of its entries count
FULL = {
    "1": MODEL_1.vector(
        m11=1.9,
        m12=0.03,
        m21=0.02,
        m22=0.1,
        Y_v=-1.1,
        Y_r=-0.56,
        N_v=-0.1,
        N_r=-0.13,
        Y_psi=0.01,
        l_psi=0.2,
        Y_delta=0.5,
        l_delta=0.3,
        Y_0=1e-3,
        N_0=1e-4,
        R1_Y=1e-3,
        R1_N=1e-5,
        R1_YN=0.4,
        R2_r=1e-4,
        R2_psi=0.1,
        R2_v1=0.02,
        R2_v2=0.03,
        lag=0.5,
        v1_0=0.1,
        v2_0=0.2,
        r_0=0.01,
        P11=0.1,
        P22=0.1,
        P33=0.1,
    ),
    "2": MODELS["2"].vector(a1=2.0, a2=1.0, a3=0.1, c1=0.4, c2=1.0, c3=0.01, R1_1=1e-3, R2_v=0.1),
    "3": MODELS["3"].vector(a1=2.0, a2=1.0, a3=0.1, b1=-1.0, b2=-0.9, R1_1=1e-9, R1_2=1e-7),
    "nomoto1": MODELS["nomoto1"].vector(K=-0.05, T=20.0, delta_0=1.0, R1_r=1e-7, lag=0.2),
    "nomoto2": MODELS["nomoto2"].vector(K=-0.05, T1=40.0, T2=5.0, T3=8.0, R1_1=1e-9, R1_2=1e-7),
}


def blocks(A: Any, B: Any, readings: Any, R1: Any, lag: Any = 0.0, R2: Any = None) -> Any:
    """Return one system with inputs B and no constant column."""
    x, y = len(A), len(readings["C"])
    drift = np.zeros((1, x + y, x + B.shape[1] + 1), complex)
    drift[0, :x, :x], drift[0, :x, x:-1] = A, B
    drift[0, x:, :x], drift[0, x:, x:-1] = readings["C"], readings["D"]
    noise = np.zeros((1, x + y, x + y), complex)
    noise[0, :x, :x], noise[0, :x, x:] = R1, readings["R12"]
    noise[0, x:, :x] = np.array(readings["R12"]).T
    noise[0, x:, x:] = np.zeros((y, y)) if R2 is None else R2
    return Blocks(drift, noise, np.zeros((1, x, x + 1), complex), np.array([lag], complex))


def plant(name: Any, period: Any = 6.0) -> Any:
    model = MODELS[name]
    outputs = tuple(output for output in model.outputs if output != "sway" or name == "2")
    return Plant(model, SHIP, outputs, period)


@pytest.mark.parametrize("case", VECTORS["cosdy"], ids=lambda case: f"lag {case['tau']}")
def test_a_rudder_that_lags_inside_the_interval_is_sampled_exactly(case: Any) -> None:
    found = sample_systems(
        blocks(A, B, NO_OUTPUT, R1, case["tau"]), np.array([30.0]), "instantaneous"
    )
    mean = found.mean[0, 0].real
    assert_allclose(mean[:, :3], case["Phi"], rtol=1e-11, atol=1e-20)
    assert_allclose(mean[:, 3:5], case["Gamma1"], rtol=1e-11, atol=1e-20)
    assert_allclose(mean[:, 5:7], case["Gamma2"], rtol=1e-11, atol=1e-20)


@pytest.mark.parametrize("case", VECTORS["noise_cov"], ids=lambda case: f"{case['T']} s")
def test_noise_gathered_over_an_interval_is_exact(case: Any) -> None:
    found = sample_systems(blocks(A, B, NO_OUTPUT, R1), np.array([case["T"]]), "instantaneous")
    assert_allclose(found.noise[0, 0].real, case["Q"], rtol=1e-10, atol=1e-25)


def test_an_unstable_ship_is_sampled_as_well() -> None:
    case = VECTORS["unstable"]
    system = blocks(np.array(case["A"]), B, NO_OUTPUT, np.array(case["R1"]))
    found = sample_systems(system, np.array([case["T"]]), "instantaneous")
    assert_allclose(found.mean[0, 0, :, :3].real, case["Phi"], rtol=1e-11, atol=1e-20)
    assert_allclose(found.noise[0, 0].real, case["Q"], rtol=1e-11)


def test_readings_summed_over_the_interval_are_exact() -> None:
    case = VECTORS["integrating"]
    readings = {key: np.array(case[key]) for key in ("C", "D", "R12")}
    system = blocks(A, B, readings, R1, R2=np.array(case["R2"]))
    found = sample_systems(system, np.array([VECTORS["T"]]), "integrating")
    mean, noise, out = found.mean[0, 0].real, found.noise[0, 0].real, case["out"]
    for name, value in (
        *(("Phi", mean[:3, :3]), ("Gam", mean[:3, 5:7]), ("C", mean[3:, :3])),
        *(("D", mean[3:, 5:7]), ("R1", noise[:3, :3]), ("R12", noise[:3, 3:])),
        ("R2", noise[3:, 3:]),
    ):
        assert_allclose(value, out[name], rtol=1e-10, atol=1e-18, err_msg=name)


def test_a_lag_inside_an_interval_of_summed_readings_is_two_intervals() -> None:
    case = VECTORS["integrating"]
    readings = {key: np.array(case[key]) for key in ("C", "D", "R12")}
    whole = blocks(A, B, readings, R1, lag=12.0, R2=np.array(case["R2"]))
    lagging = sample_systems(whole, np.array([30.0]), "integrating").mean[0, 0].real
    part = blocks(A, B, readings, R1, R2=np.array(case["R2"]))
    old, new = sample_systems(part, np.array([12.0, 18.0]), "integrating").mean[0].real

    assert_allclose(lagging[3:, 3:5], old[3:, 5:7] + new[3:, :3] @ old[:3, 5:7], rtol=1e-11)
    assert_allclose(lagging[3:, :3], old[3:, :3] + new[3:, :3] @ old[:3, :3], rtol=1e-11)


def test_sampling_agrees_with_the_matrix_exponential_of_scipy() -> None:
    linalg = pytest.importorskip("scipy.linalg")
    stream = np.random.default_rng(3)
    for _ in range(20):
        matrix, inputs = stream.normal(size=(3, 3)), stream.normal(size=(3, 2))
        step = float(stream.uniform(0.01, 8.0))
        found = sample_systems(
            blocks(matrix, inputs, NO_OUTPUT, R1), np.array([step]), "instantaneous"
        )
        whole = np.zeros((5, 5))
        whole[:3, :3], whole[:3, 3:] = matrix, inputs
        expected = linalg.expm(whole * step)
        assert_allclose(found.mean[0, 0, :, :3].real, expected[:3, :3], rtol=1e-9, atol=1e-9)
        assert_allclose(found.mean[0, 0, :, 5:7].real, expected[:3, 3:], rtol=1e-9, atol=1e-9)


def test_matrices_that_are_discrete_already_are_taken_as_they_are() -> None:
    system = blocks(A, B, NO_OUTPUT, R1)
    found = sample_systems(system, np.array([1.0, 2.0]), "discrete")
    for m in range(2):
        assert_allclose(found.mean[0, m, :, :3].real, A)
        assert_allclose(found.mean[0, m, :, 5:7].real, B)
        assert_allclose(found.noise[0, m].real, R1)


def test_times_that_do_not_rise_are_refused() -> None:
    with pytest.raises(ConfigError, match="later than the one before"):
        sample_systems(blocks(A, B, NO_OUTPUT, R1), np.array([1.0, 0.0]), "instantaneous")


@pytest.mark.parametrize("name", MODELS)
@pytest.mark.parametrize("sampling", ["instantaneous", "integrating"])
def test_slopes_of_the_sampled_matrices_are_those_of_differences(name: Any, sampling: Any) -> None:
    ship, theta = plant(name), FULL[name]
    intervals = np.array([6.0, 11.0])
    places = [place for place in range(len(theta)) if theta[place] != 0.0]
    found = sample_systems(ship.blocks(step_aside(theta, places)), intervals, sampling)
    for row, place in enumerate(places, start=1):
        step = 1e-3 * abs(theta[place])
        sides = []
        for side in (2, 1, -1, -2):
            moved = theta.astype(complex)
            moved[place] += side * step
            sides.append(sample_systems(ship.blocks(moved[None]), intervals, sampling).mean[0].real)
        expected = (8 * (sides[1] - sides[2]) - (sides[0] - sides[3])) / (12 * step)
        slope = found.mean[row].imag / COMPLEX_STEP
        # the differences' own rounding, and their error of order step^4
        noise = 1e-12 * np.max(np.abs(found.mean[0])) / step
        size = np.max(np.abs(expected))
        assert_allclose(slope, expected, atol=1e-7 * size + noise, err_msg=ship.model.names[place])


@pytest.mark.parametrize(("name", "row"), [("1", 1), ("3", 1), ("nomoto2", 1)])
def test_each_model_has_the_transfer_function_that_its_document_says(name: Any, row: Any) -> None:
    """Rudder to yaw rate at s = 0.03i: C (s - A)^-1 B against the formula of the model."""
    ship, theta, s = plant(name), FULL[name].copy(), 0.03j
    model, k = ship.model, SHIP.speed / SHIP.length
    for wind in ("Y_psi", "l_psi", "a3"):
        if wind in model.names:
            theta[model.index(wind)] = 0.0
    drift = ship.blocks(theta.astype(complex)[None]).drift[0]
    x = model.states
    found = np.linalg.solve(s * np.eye(x) - drift[:x, :x], drift[:x, x])[row] * 180.0 / np.pi
    p = dict(zip(model.names, theta, strict=True))
    if name == "1":
        f = transfer(drift[:2, :2].real, drift[:2, 3].real * 180.0 / np.pi)
        n = nomoto(f)
        K, T1, T2, T3 = n.K, n.T1, n.T2, n.T3
        expected = K * (1 + T3 * s) / ((1 + T1 * s) * (1 + T2 * s))
    elif name == "3":
        over = (k**2 * p["b1"] * s + k**3 * p["b2"]) * s
        expected = over / (s**3 + k * p["a1"] * s**2 + k**2 * p["a2"] * s)
    else:
        expected = -0.05 * (1 + 8.0 * s) / ((1 + 40.0 * s) * (1 + 5.0 * s))
    assert found == pytest.approx(expected, rel=1e-9)


def test_model_1_by_hand() -> None:
    # no coupling: v' = (Y_v/V v + (L/V) Y_r r + Y_delta delta)/((L/V^2) m11)
    theta = MODEL_1.vector(m11=2.0, m22=0.1, Y_v=-1.0, Y_r=-0.5, Y_delta=0.3, l_delta=0.4, N_r=-0.2)
    ship = Plant(MODEL_1, Ship(100.0, 5.0, 40.0), ("bow_sway", "yaw_rate"), 1.0)
    drift = ship.blocks(theta.astype(complex)[None]).drift[0].real
    assert drift[0, 0] == pytest.approx(-1.0 / 5.0 / (4.0 * 2.0))
    assert drift[0, 1] == pytest.approx(20.0 * -0.5 / (4.0 * 2.0))
    assert drift[0, 3] == pytest.approx(np.pi / 180.0 * 0.3 / (4.0 * 2.0))
    assert drift[1, 1] == pytest.approx(20.0 * -0.2 / (400.0 * 0.1))
    # positive helm turns to port
    assert drift[1, 3] == pytest.approx(-np.pi / 180.0 * 0.3 * 0.4 / (400.0 * 0.1))
    # the bow log reads v + 40 r in knots
    assert drift[3, :2] == pytest.approx([3600.0 / 1852.0, 40.0 * 3600.0 / 1852.0])


def test_a_parameter_is_found_by_name_and_by_number_and_a_wrong_one_names_the_nearest() -> None:
    assert MODEL_1.index("theta12") == MODEL_1.index("l_delta") == 11
    with pytest.raises(ConfigError, match="nearest is Y_delta"):
        MODEL_1.index("Y_delt")
    with pytest.raises(ConfigError, match="theta1 to theta34"):
        MODEL_1.index("theta35")


def test_two_sways_that_share_a_bias_are_refused() -> None:
    with pytest.raises(ConfigError, match="bow_sway and sway"):
        Plant(MODEL_1, SHIP, ("sway", "bow_sway"), 1.0)
    with pytest.raises(ConfigError, match="no output 'sway'; it has yaw_rate, heading"):
        Plant(MODELS["3"], SHIP, ("sway",), 1.0)
