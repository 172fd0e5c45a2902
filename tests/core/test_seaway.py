"""The sea: its spectrum, the filter of 1969, the cosine sum, and that it changes without a jump."""

import json
import os
import subprocess
import sys
from typing import Any

import numpy as np
import pytest
from helpers.places import DATA, TESTS
from numba import njit

from trainer.config.world.sea import HEIGHT_FACTOR
from trainer.core.sea.cosine_sum import (
    ANGLE_COS,
    ANGLE_SIN,
    DIRECTION_WEIGHTS,
    VARIANCE_SHARE,
    phase,
    prepare_sum,
)
from trainer.core.sea.filter_1969 import (
    G_OF_TABLE,
    PEAK_FACTOR,
    corner,
    filter_noise,
    prepare_filter,
)
from trainer.core.sea.sea import advance_sea, order_sea
from trainer.core.state import STATE, new_scratch, new_state
from trainer.core.vessel import VESSEL
from trainer.units import KNOT

pytestmark = pytest.mark.core

VECTORS = json.loads((DATA / "waves.json").read_text(encoding="utf-8"))
G = 9.81
FILTER, COSINES, FILTER_1969 = 0.0, 1.0, -1.0
GENERATORS = (FILTER, COSINES, FILTER_1969)


def sea_by(
    height: float, omega: float, generator: float, gamma: float = 1.0, direction: float = 0.0
) -> np.ndarray:
    """Return the settings of a sea; ``generator`` is one of three, or a share of cosines."""
    shares = max(generator, 0.0), 0.0, float(generator == FILTER_1969), float(gamma >= 1.8)
    return np.array([height, omega, gamma, direction, *shares, 0.0])


def by_wind(wind: float, generator: float = FILTER, direction: float = 0.0) -> np.ndarray:
    """Return the settings of a fully developed sea of ``wind`` [kn]."""
    speed = wind * KNOT
    height, omega = HEIGHT_FACTOR * speed**2 / G, PEAK_FACTOR * G / speed
    return sea_by(height, omega, generator, direction=direction)


class Waves:
    """A sea at work over a boat that may be given a velocity."""

    def __init__(self, settings: np.ndarray, h: float = 0.5, seed: int = 1) -> None:
        self.h = h
        self.vessel = np.zeros(1, VESSEL)
        self.vessel["g"] = G
        self.sea = new_scratch()
        self.state = new_state()
        self.state["seed"] = seed
        self.order(settings, 0.0)

    def order(self, settings: np.ndarray, ramp: float) -> None:
        order_sea(self.vessel, self.h, ramp, settings, self.sea, self.state)

    def run(self, ticks: int) -> np.ndarray:
        """Return the elevation [m] at each of ``ticks`` ticks."""
        return _record(self.vessel, self.h, self.sea, self.state, ticks)  # type: ignore[no-any-return]


@njit(cache=False)
def _record(vessel: Any, h: Any, sea: Any, state: Any, ticks: Any) -> Any:
    eta = np.empty(ticks)
    for i in range(ticks):
        advance_sea(vessel, h, sea, state)
        state[0].tick += 1.0
        eta[i] = state[0].eta_wave
    return eta


FILTERS = [
    pytest.param(case, form, id=f"{case['knots']} kn {form['h']} s")
    for case in VECTORS["filters"]
    for form in case["discrete"]
]


@pytest.mark.parametrize(("case", "form"), FILTERS)
def test_the_filter_of_1969_is_that_of_the_reference_in_bilinear_form(case: Any, form: Any) -> None:
    sea = new_scratch()
    prepare_filter(G_OF_TABLE, PEAK_FACTOR * G_OF_TABLE / (case["knots"] * KNOT), form["h"], sea)
    low, high = form["sections_b0b1b2a1a2"][:2]
    power = float(sea["elevation_power"][0]) / case["wl"] ** 4

    assert sea["low"][0] == pytest.approx(low[3:], rel=1e-8)
    assert sea["high"][0] == pytest.approx(high[3:], rel=1e-8)
    assert power == pytest.approx(form["output_variance_unit_noise"], rel=1e-8)


@pytest.mark.parametrize("wind", [10.0, 20.0, 33.9, 37.5, 46.1, 60.0])
def test_other_winds_have_similar_frequencies(wind: float) -> None:
    peak = PEAK_FACTOR * G / (wind * KNOT)

    assert corner(peak, G, 0) == pytest.approx(0.90 * G / (wind * KNOT), rel=1e-12)
    assert corner(peak, G, 1) == pytest.approx(0.50 * G / (wind * KNOT), rel=1e-12)


def test_a_wind_that_rises_through_one_of_the_table_s_changes_the_filter_evenly() -> None:
    winds = np.linspace(33.5, 36.5, 301)
    products = [corner(PEAK_FACTOR * G / (wind * KNOT), G, 0) * wind * KNOT / G for wind in winds]

    assert max(abs(np.diff(products))) < 3e-4
    assert min(products) == pytest.approx(0.8806, abs=1e-3)


@pytest.mark.parametrize("h", [0.05, 0.5, 2.0])
@pytest.mark.parametrize("wind", [10.0, 20.0, 35.0, 60.0])
def test_the_noise_is_scaled_to_the_exact_variance_of_the_discrete_filter(
    wind: float, h: float
) -> None:
    waves = Waves(by_wind(wind, FILTER_1969), h)
    state = new_state()
    outputs = []
    for n in range(40_000):
        filter_noise(waves.sea, float(n == 0), state)
        outputs.append((float(state["sea_elevation"][0]), float(state["sea_quadrature"][0])))
        if n > 100 and max(map(abs, state["sea_memory"][0])) < 1e-14:
            break
    response = np.array(outputs)

    # each output of noise of variance 1 has variance 1, and they are not correlated
    assert response.T @ response == pytest.approx(np.eye(2), abs=1e-9)


def test_steps_too_long_for_the_shortest_waves_keep_the_variance_and_stay_stable() -> None:
    eta = Waves(by_wind(10.0, FILTER_1969), h=2.0).run(20_000)

    assert np.var(eta) == pytest.approx((by_wind(10.0)[0] / 4.0) ** 2, rel=0.05)


@pytest.mark.slow
@pytest.mark.parametrize("generator", GENERATORS)
@pytest.mark.parametrize("wind", [20.0, 40.0])
def test_ten_hours_of_waves_have_the_ordered_height(wind: float, generator: float) -> None:
    # one record scatters by about 2 % in variance at 20 kn and 3 % at 40: the mean of sixteen
    variances = [np.var(Waves(by_wind(wind, generator), seed=s).run(72_000)) for s in range(16)]
    ordered = (0.2092 * (wind * KNOT) ** 2 / G / 4.0) ** 2

    assert np.mean(variances) == pytest.approx(ordered, rel=0.03)
    assert np.median(np.abs(np.array(variances) / ordered - 1.0)) < 0.03


@pytest.mark.long
@pytest.mark.parametrize("generator", GENERATORS)
def test_the_sea_is_fully_there_at_the_first_tick(generator: float) -> None:
    first = [Waves(by_wind(30.0, generator), seed=s).run(1)[0] for s in range(2000)]
    ordered = (by_wind(30.0)[0] / 4.0) ** 2

    # the variance of 2000 samples scatters by sqrt(2/2000) = 3.2 %
    assert np.mean(np.square(first)) == pytest.approx(ordered, rel=0.13)
    assert abs(np.mean(first)) < 4.0 * np.sqrt(ordered / 2000)


# The cosine sum


def test_the_cosine_sum_has_the_whole_variance_in_the_report_s_shares() -> None:
    shares = 0.5 * np.square(DIRECTION_WEIGHTS) * 10

    assert np.sum(shares) == pytest.approx(1.0, rel=1e-12)
    assert shares == pytest.approx(2.0 / np.pi * np.array(VECTORS["direction_weights"]["exact"]))


def test_each_component_has_a_frequency_of_its_own_inside_its_band() -> None:
    sea = new_scratch()
    prepare_sum(1.0, 5.0, sea)
    part = np.exp(-1.25 * sea["relative"][0] ** -4.0) / VARIANCE_SHARE

    assert np.floor(part * 10).astype(int).tolist() == [*range(10)] * 5
    assert len(set(part)) == 50


def test_a_peaked_spectrum_weights_the_components_by_how_much_it_exceeds_the_flat_one() -> None:
    sea, flat = new_scratch(), new_scratch()
    prepare_sum(3.3, 5.0, sea)
    prepare_sum(1.0, 5.0, flat)
    x = sea["relative"][0]
    width = np.where(x <= 1.0, 0.07, 0.09)
    excess = 3.3 ** np.exp(-0.5 * ((x - 1.0) / width) ** 2)
    variance = np.square(flat["amplitude"][0]) * excess

    assert x.tolist() == flat["relative"][0].tolist()
    assert np.square(sea["amplitude"][0]) == pytest.approx(2.0 * variance / np.sum(variance))


def test_a_boat_that_runs_with_a_wave_stays_on_it() -> None:
    waves = Waves(by_wind(30.0, COSINES, direction=0.4))
    waves.run(1)
    ahead = 20 + 3  # band 3 of the middle direction
    omega = float(waves.state["sea_omega"][0] * waves.sea["relative"][0][ahead])
    waves.state["through_north"], waves.state["through_east"] = (
        G / omega * np.cos(0.4),
        G / omega * np.sin(0.4),
    )
    before = phase(waves.sea, waves.state, ahead)
    waves.run(200)

    assert phase(waves.sea, waves.state, ahead) == pytest.approx(before, abs=1e-10)


def test_the_phase_is_that_of_a_wave_at_the_boat_s_place() -> None:
    # w t - k (x cos mu + y sin mu) + eps, model document section 10, at a steady speed
    waves = Waves(by_wind(30.0, COSINES, direction=0.4))
    waves.state["through_north"], waves.state["through_east"] = 3.0, -2.0
    waves.run(400)
    time = float(waves.state["sea_turned"][0] / waves.state["sea_omega"][0])
    for i in (3, 17, 42):
        omega = float(waves.state["sea_omega"][0] * waves.sea["relative"][0][i])
        way = 0.4 + np.arctan2(ANGLE_SIN[i // 10], ANGLE_COS[i // 10])
        along = time * (3.0 * np.cos(way) - 2.0 * np.sin(way))
        expected = omega * time - omega**2 / G * along + float(waves.sea["phase_start"][0][i])

        assert phase(waves.sea, waves.state, i) == pytest.approx(expected, rel=1e-12, abs=1e-9)


def median_frequency(record: np.ndarray, h: float) -> float:
    """Return the frequency [rad/s] below which half of the variance lies."""
    power = np.abs(np.fft.rfft(record)) ** 2
    part = np.cumsum(power) / np.sum(power)
    return float(np.interp(0.5, part, 2.0 * np.pi * np.fft.rfftfreq(record.size, h)))


@pytest.mark.long
@pytest.mark.parametrize("generator", GENERATORS)
def test_head_seas_are_met_faster_than_following_seas(generator: float) -> None:
    met = {}
    for speed in (-6.0, 0.0, 6.0):
        waves = Waves(by_wind(30.0, generator))
        waves.state["through_north"] = speed
        eta = waves.run(14_400)
        met[speed] = median_frequency(eta, 0.5)
        ordered = by_wind(30.0)[0] / 4.0
        assert np.std(eta) == pytest.approx(ordered, rel=0.12)

    # the peak wave, 0.56 rad/s, is met at 0.56 +- 0.56^2 6/9.81 = 0.75 and 0.37 rad/s
    assert met[-6.0] > 1.2 * met[0.0]
    assert met[6.0] < 0.8 * met[0.0]


@pytest.mark.long
def test_half_of_each_generator_has_the_whole_height() -> None:
    waves = Waves(by_wind(20.0, 0.5))
    spread = np.mean([np.var(Waves(by_wind(20.0, 0.5), seed=s).run(36_000)) for s in range(8)])

    assert 4.0 * np.sqrt(spread) == pytest.approx(float(waves.state["sea_height"][0]), rel=0.04)


# Changes


CHANGES = {
    "height": (4.0, 0.5, None, 1.0, 0.0),
    "period": (2.0, 0.9, None, 1.0, 0.0),
    "peakedness": (2.0, 0.5, None, 5.0, 0.0),
    "direction": (2.0, 0.5, None, 1.0, 2.5),
    "to filter": (2.0, 0.5, FILTER, 1.0, 0.0),
    "to cosines": (2.0, 0.5, COSINES, 1.0, 0.0),
    "to filter of 1969": (2.0, 0.5, FILTER_1969, 1.0, 0.0),
    "to calm": (0.0, 0.5, None, 1.0, 0.0),
}


@pytest.mark.parametrize("generator", GENERATORS)
@pytest.mark.parametrize("change", CHANGES)
def test_an_ordered_change_comes_about_in_its_time_without_a_jump(
    change: str, generator: float
) -> None:
    settings = sea_by(2.0, 0.5, generator)
    height, omega, other_generator, gamma, direction = CHANGES[change]
    chosen = generator if other_generator is None else other_generator
    wanted = sea_by(height or 0.0, omega or 0.0, chosen, gamma or 1.0, direction or 0.0)
    same, other = Waves(settings), Waves(settings)
    for waves in (same, other):
        waves.state["through_north"] = 5.0
        waves.run(100)
    other.order(wanted, 60.0)
    first = [abs(float(other.run(1)[0] - same.run(1)[0])) for _ in range(2)]
    other.run(118)

    # a step of 0.5 s is 1/120 of the ramp; a share of the variance goes in by its square root
    mixed = change.startswith("to ") and change != "to calm"
    limit = 0.2 if mixed or (change, generator) == ("peakedness", FILTER) else 0.05
    assert first[0] < limit
    assert float(other.state["sea_ramp"][0]) == 0.0
    assert float(other.state["sea_height"][0]) == wanted[0]
    if wanted[0] != 0.0:
        assert other.state["sea"][0].tolist() == wanted[:-1].tolist()


def test_the_sea_turns_the_short_way() -> None:
    waves = Waves(by_wind(20.0, direction=np.radians(350.0)))
    waves.order(by_wind(20.0, direction=np.radians(10.0)), 60.0)
    waves.run(60)

    assert np.degrees(float(waves.state["sea_direction"][0])) == pytest.approx(360.0, abs=0.5)


def test_a_calm_stays_calm_and_a_sea_may_rise_from_it() -> None:
    waves = Waves(sea_by(0.0, 0.5, FILTER))
    still = waves.run(50)
    waves.order(by_wind(30.0), 60.0)
    rising = waves.run(1200)

    assert not np.any(still)
    assert abs(rising[0]) < 0.1
    assert np.std(rising[600:]) == pytest.approx(by_wind(30.0)[0] / 4.0, rel=0.3)


# Same inputs, same bits


@pytest.mark.laws
@pytest.mark.parametrize("generator", [*GENERATORS, 0.5])
def test_a_snapshot_of_the_state_alone_goes_on_to_the_same_bits(generator: float) -> None:
    waves = Waves(sea_by(3.0, 0.6, generator, 2.0, 1.0))
    waves.order(by_wind(30.0, generator), 60.0)
    waves.run(40)
    kept = waves.state.copy()
    first = waves.run(200)
    waves.state[:] = kept
    waves.sea = new_scratch()

    assert waves.run(200).tobytes() == first.tobytes()


@pytest.mark.slow
@pytest.mark.process
@pytest.mark.long
def test_without_jit_the_bits_are_the_same() -> None:
    script = (
        "import sys; sys.path[:0] = sys.argv[1:]\n"
        "from test_seaway import Waves, by_wind\n"
        "from test_wave_forces import force_of\n"
        "for share in (-1.0, 0.0, 0.5, 1.0):\n"
        "    waves = Waves(by_wind(30.0, share), h=1.0, seed=9)\n"
        "    waves.state['through_north'] = 3.0\n"
        "    settings = by_wind(40.0, share, 1.0)\n"
        "    settings[[2, 5, 7]] = 3.3, 1.0, 1.0\n"
        "    waves.order(settings, 20.0)\n"
        "    waves.run(30)\n"
        "    print(waves.state.tobytes().hex())\n"
        "    waves.state['z'] = 25.0\n"
        "    print(force_of(waves.state, sea=waves.sea).tobytes().hex())\n"
    )
    outputs = [
        subprocess.run(
            [sys.executable, "-c", script, str(TESTS), str(TESTS / "core")],
            env={**os.environ, "NUMBA_DISABLE_JIT": off},
            capture_output=True,
            check=True,
        ).stdout
        for off in ("0", "1")
    ]

    assert len(outputs[0]) > 4 * 2 * STATE.itemsize
    assert outputs[0] == outputs[1]
