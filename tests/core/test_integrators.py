"""Order, start and limits of the integrators."""

import math

import numpy as np
import pytest
from helpers.boats import make_boat, start_boat, take_in_hand, take_ticks

from trainer.boat.assemble import read_integrator, set_integrator
from trainer.boat.boat import Boat
from trainer.config.files import ConfigError
from trainer.core.integrators import adams, advance, multistep
from trainer.core.scheme import (
    INTEGRATORS,
    PAIRS,
    PARABOLA,
    TRAPEZOID,
    Multistep,
    PredictorCorrector,
    new_scheme,
    set_multistep,
    set_pair,
)
from trainer.core.state import MOTION, new_state

pytestmark = pytest.mark.core

# a moment in a turn and climb from which no velocity changes sign for ten seconds, so that the
# terms with |.| stay smooth (model document, section 11)
MOMENT = {"u": 5.0, "v": 0.4, "w": 0.3, "p": 0.004, "q": 0.006, "r": -0.02, "phi": -0.05}
SPAN = 8.0  # [s]


def flown(boat: Boat) -> np.ndarray:
    """Return the motion at the end of the span, from the moment, controls held."""
    s = boat.state
    for name, value in MOMENT.items():
        s[name] = value
    s.theta, s.u_c, s.delta_r, s.delta_s, s.z = 0.1, 5.1, -0.1, -0.05, 100.0
    for _ in range(round(SPAN / boat.method.step)):
        advance(*boat.records)
    return np.array(s.motion)


def observed_order(integrator: str, rates: str, h: float) -> float:
    """Return the order by Richardson: differences of runs at h, h/2 and h/4."""
    coarse, middle, fine = (
        flown(make_boat("bb2", "full", rates, integrator, h / n)) for n in (1, 2, 4)
    )
    return math.log2(np.linalg.norm(coarse - middle) / np.linalg.norm(middle - fine))


@pytest.mark.long
@pytest.mark.parametrize(
    ("integrator", "rates", "order", "h"),
    [
        ("euler", "exact", 1.0, 0.05),
        ("adams2", "exact", 2.0, 0.05),
        ("best2", "exact", 1.0, 0.05),
        ("adams3", "exact", 2.0, 0.05),  # the start by Euler holds it to 2
        ("adams4", "exact", 2.0, 0.05),
        ("heun", "exact", 2.0, 0.05),
        ("abm2", "exact", 2.0, 0.05),
        ("abm3", "exact", 2.0, 0.05),
        ("abm4", "exact", 2.0, 0.05),
        ("hamming4", "exact", 2.0, 0.05),
        ("o30c31", "exact", 2.0, 0.05),
        ("bdf2", "exact", 2.0, 0.05),
        ("bdf3", "exact", 2.0, 0.05),
        ("rk2", "exact", 2.0, 0.25),
        ("rk3", "exact", 3.0, 0.25),
        ("rk4", "exact", 4.0, 0.5),
        ("adams2", "lagged", 1.0, 0.0125),  # errata C27: formally first order
        ("abm4", "lagged", 1.0, 0.0125),
        ("rk4", "lagged", 1.0, 0.05),
    ],
)
def test_each_method_has_its_order(integrator: str, rates: str, order: float, h: float) -> None:
    assert observed_order(integrator, rates, h) == pytest.approx(order, abs=0.2)


@pytest.mark.long
def test_lagged_rates_cost_no_more_than_adams_itself_at_half_a_second() -> None:
    true = flown(make_boat("bb2", "full", "exact", "rk4", 0.05))
    exact = flown(make_boat("bb2", "full", "exact", "adams2", 0.5))
    lagged = flown(make_boat("bb2", "full", "lagged", "adams2", 0.5))

    assert np.linalg.norm(lagged - true) < 2.0 * np.linalg.norm(exact - true)


@pytest.mark.laws
def test_adams_by_hand() -> None:
    scheme = new_scheme(0.5, 0, exact=True, trig=0)
    state = new_state()
    s = state[0]
    s.u, s.udot = 3.0, 0.2
    adams(scheme, state)
    assert s.u == 3.0 + 0.5 * 0.2  # the past rate is the present one: Euler

    s.udot = 0.4
    adams(scheme, state)
    # 3.1 + 0.25 (3 * 0.4 - 0.2) = 3.35
    assert s.u == pytest.approx(3.35, rel=1e-15)


def test_a_method_that_looks_back_on_motion_is_given_by_its_coefficients() -> None:
    # the midpoint rule X_n = X_n-2 + 2 h X'_n-1 on a steady rate goes along the line
    scheme = new_scheme(0.5, 0, exact=True, trig=0)
    set_integrator(scheme, "a=0,1;b=2")
    state = new_state()
    s = state[0]
    s.x, s.xdot = 10.0, 4.0

    for _ in range(10):
        multistep(scheme, state)

    assert s.x == pytest.approx(10.0 + 5.0 * 4.0, rel=1e-15)


def test_the_named_adams_is_the_one_of_the_report() -> None:
    assert read_integrator("a=1;b=1.5,-0.5") == INTEGRATORS["adams2"]


@pytest.mark.parametrize(
    ("text", "why"),
    [
        ("adms2", "give one of euler, adams2"),
        ("a=1", "give one of"),
        ("a=1;b=x", "give one of"),
        ("a=1;b=1;c=2", "give one of"),
        ("a=1;b=1;e=2;d=1", "give one of"),
        ("a=1;b=nan", "^--integrator 'a=1;b=nan': b = nan: must be finite$"),
        ("a=nan;b=1", "a = nan: must be finite"),
        ("a=1;b=1.5,inf", "b = 1.5,inf: must be finite"),
        ("a=1;b=1;c=1;d=nan", "d = nan: must be finite"),
        ("d=nan", "d = nan: must be finite"),
        ("a=1;b=1e400", "b = 1e400: must be finite"),
    ],
)
def test_an_unreadable_method_is_refused(text: str, why: str) -> None:
    with pytest.raises(ConfigError, match=why):
        read_integrator(text)


@pytest.mark.parametrize(
    ("method", "why"),
    [
        (Multistep((1.0,), (1.5,)), "consistency needs 0"),
        (Multistep((0.9,), (0.9,)), "consistency needs 1"),
        (Multistep((-4.0, 5.0), (4.0, 2.0)), "not zero-stable"),
        (Multistep((1.0,), (0.2,) * 5), "looks back 1 to 4"),
    ],
)
def test_a_method_that_cannot_work_is_refused(method: Multistep, why: str) -> None:
    with pytest.raises(ValueError, match=why):
        set_multistep(new_scheme(0.5, 0, exact=True, trig=0), method)


@pytest.mark.parametrize(
    ("pair", "why"),
    [
        # the predictor may be unstable by itself, but not inconsistent; the corrector neither
        (PredictorCorrector(PARABOLA, Multistep((-4.0, 5.0), (4.0, 2.0))), "not zero-stable"),
        (PredictorCorrector(PARABOLA, Multistep((1.0,), (0.5, 0.4))), "consistency needs 0"),
        (PredictorCorrector(Multistep((1.0,), (0.9,)), TRAPEZOID), "consistency needs 0"),
        (
            PredictorCorrector(PARABOLA, Multistep((1.0,), (0.0, 0.5, 0.5, 0.0, 0.0, 0.0))),
            "looks back 1 to 4",
        ),
    ],
)
def test_a_pair_that_cannot_work_is_refused(pair: PredictorCorrector, why: str) -> None:
    with pytest.raises(ValueError, match=why):
        set_pair(new_scheme(0.5, 0, exact=True, trig=0), pair)


def test_a_pair_is_given_by_its_coefficients() -> None:
    assert read_integrator("a=1;b=1;c=1;d=0.5,0.5") == PAIRS["heun"]


@pytest.mark.long
def test_variable_runge_kutta_keeps_its_tolerance() -> None:
    true = flown(make_boat("bb2", "full", "exact", "rk4", 0.01))
    free = flown(make_boat("bb2", "full", "exact", "rkv", 2.0))

    assert np.abs(free - true)[:6] == pytest.approx(0.0, abs=5e-3)
    assert (free != true).any()


@pytest.mark.long
@pytest.mark.parametrize("step", [0.5, 1.0])
def test_adams_gives_the_same_turn_at_half_a_second_and_one(step: float) -> None:
    turns = []
    for integrator, rates, h in (("rk4", "exact", 0.1), ("adams2", "lagged", step)):
        boat = start_boat(10 * 1852 / 3600, rates=rates, integrator=integrator, step=h)
        take_in_hand(boat)
        boat.state.ordered_r = -math.radians(15.0)
        take_ticks(boat, round(900 / h))
        s = boat.state
        turns.append([s.u, s.v, s.psidot, s.phi])

    assert turns[1] == pytest.approx(turns[0], rel=1e-3)


def test_history_fills_from_the_present_after_a_jump() -> None:
    boat = start_boat(5.0)
    boat.state.udot = 99.0
    boat.state.history = 0.0
    speed = boat.state.u

    boat.tick()

    assert boat.state.u == pytest.approx(speed, abs=1e-6)
    assert list(boat.state.past_rates[0]) == list(boat.state.past_rates[1])
    assert len(MOTION) == 12
