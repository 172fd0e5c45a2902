"""Gains and time constants from one manoeuvre, by the methods from before likelihoods.

``trainer steering --record`` puts them beside those of the ship's file. K and T of a zig-zag are
Nomoto's (report of 1974, section 2.8), T1 to T3 are read off its phase plot as by Bech and Wagner
Smitt, and those of a turn are its effective ones (2.3). All in SI and rad, the rudder to port.
"""

from typing import Final

import numpy as np

from trainer.config.files import ConfigError
from trainer.core.kernel import Numbers
from trainer.identify.fitting.nonlinear import BentShip
from trainer.identify.model.nomoto import time_constants
from trainer.identify.record.measurements import Record

STEADY_SHARE: Final = 0.1  # [-] of a turn, its end, in which it is steady
THROWN_SHARE: Final = 0.5  # [-] of the largest rudder: from there on it has been thrown
MIN_SWINGS: Final = 3  # turning points of the heading that Nomoto's method needs
SMOOTHING_TIME: Final = 0.3  # [lengths at speed] of the phase plot's window, as of trials
MIN_HALF_WINDOW, MIN_SAMPLES = 4, 20  # [samples]


def is_zigzag(record: Record) -> bool:
    """Return whether the rudder was thrown to both sides."""
    rudder = record.column("rudder")
    thrown = THROWN_SHARE * np.nanmax(np.abs(rudder))
    return bool(np.nanmax(rudder) >= thrown and np.nanmin(rudder) <= -thrown)


def measure_zigzag(record: Record) -> tuple[float, float]:
    """Return K [1/s] and T [s] of a zig-zag by Nomoto's method.

    T r' + r = K (delta + delta_0) is integrated. Between turning points of the heading r is zero at
    both ends, so that K and delta_0 are left; from there to a zero of the heading T is. ConfigError
    of fewer turning points than MIN_SWINGS.
    """
    t, rudder, rate, heading = _columns(record)
    helm, heading = _integral(t, rudder), heading - heading[0]
    begin = t[np.argmax(np.abs(rudder) >= THROWN_SHARE * np.abs(rudder).max())]
    tops, zeros = _crossings(t, rate), _crossings(t, heading)
    tops = tops[tops > begin]
    if len(tops) < MIN_SWINGS:
        raise ConfigError(
            f"{record.source}: the heading turns {len(tops)} times: Nomoto's method needs "
            f"{MIN_SWINGS} turning points: sail the zig-zag for longer"
        )
    zeros = zeros[zeros > tops[0]]
    by_top = [np.interp(tops, t, one) for one in (helm, heading)]
    sums = np.column_stack([np.diff(by_top[0]), np.diff(tops)])
    K, drift = np.linalg.lstsq(sums, np.diff(by_top[1]), rcond=None)[0]
    turned = np.interp(zeros, t, heading) - by_top[1][0]
    lacking = K * (np.interp(zeros, t, helm) - by_top[0][0]) + drift * (zeros - tops[0]) - turned
    rates = np.interp(zeros, t, rate)
    return float(K), float(lacking @ rates / (rates @ rates))


def read_phase_plot(record: Record, ship: BentShip, window: float) -> tuple[complex, ...]:
    """Return T1, T2 and T3 [s] from the phase plot of a zig-zag, r' over r (Bech and Smitt).

    ``ship`` has the steady turns, K and H(r). What they leave of the helm is (T1 + T2) r' + T1 T2
    r'' - K T3 delta', where r'' is r' times the slope of the plot. All are smoothed alike over
    ``window`` [s], so that a thrown rudder breaks no term.
    """
    t, rudder, rate, _ = _columns(record)
    even = np.arange(t[0], t[-1], record.interval)
    rudder, rate = np.interp(even, t, rudder), np.interp(even, t, rate)
    count = max(round(0.5 * window / record.interval), MIN_HALF_WINDOW)
    weights = (1.0 - np.linspace(-1.0, 1.0, 2 * count + 1) ** 2) ** 3
    kept, helm, rate = (
        np.convolve(values, weights / weights.sum(), "valid")
        for values in (ship.K * (rudder - ship.helm(rate)), rudder, rate)
    )
    turning, thrown = (np.gradient(values, record.interval) for values in (rate, helm))
    bending = np.gradient(turning, record.interval)
    terms = np.column_stack([turning, bending, -ship.K * thrown, np.ones_like(kept)])
    inner = slice(2, -2)  # at the ends differences are to one side
    (total, product, T3, _), *_ = np.linalg.lstsq(terms[inner], kept[inner], rcond=None)
    return (*time_constants(total / product, 1.0 / product), complex(T3))


def measure_turn(record: Record, speed: float) -> tuple[float, ...]:
    """Return the effective K [1/s] and T [s] of a turn, twice.

    K is the steady rate over the rudder, T the time by which the heading lags behind K times the
    rudder. The last two are by the distance run, as if the ship had kept
    ``speed`` [m/s].
    """
    sailed = np.full_like(record.t, speed)
    if record.speed is not None:
        sailed = np.hypot(record.speed, 0.0 if record.sway is None else record.sway)
    t, rudder, rate, _, sailed = _columns(record, sailed)
    by_distance = _integral(t, sailed) / speed
    own = [_effective(t, rudder, rate), _effective(by_distance, rudder, rate * speed / sailed)]
    return (*own[0], *own[1])


def _effective(t: Numbers, rudder: Numbers, rate: Numbers) -> tuple[float, float]:
    """Return the gain at the end of a turn, and its lag."""
    steady = t >= t[-1] - STEADY_SHARE * (t[-1] - t[0])
    last_rudder, last_rate = rudder[steady].mean(), rate[steady].mean()
    lag = _integral(t, rudder / last_rudder - rate / last_rate)[-1]
    return float(last_rate / last_rudder), float(lag)


def _columns(record: Record, *further: Numbers) -> tuple[Numbers, ...]:
    """Return time, rudder, yaw rate, heading and others of the samples that have all of them."""
    names = ("rudder", "turning", "heading")
    columns = np.array([record.t, *(record.column(name) for name in names), *further])
    whole = columns[:, ~np.isnan(columns).any(axis=0)]
    if whole.shape[1] < MIN_SAMPLES or not whole[1].any():
        raise ConfigError(
            f"{record.source}: the old methods need {MIN_SAMPLES} rows with rudder, yaw rate and "
            "heading, and a rudder that moves"
        )
    return tuple(whole)


def _integral(t: Numbers, values: Numbers) -> Numbers:
    """Return the integral from the first sample to each, by trapezoids (n,)."""
    return np.append(0.0, np.cumsum(0.5 * (values[1:] + values[:-1]) * np.diff(t)))


def _crossings(t: Numbers, values: Numbers) -> Numbers:
    """Return the times at which values go through zero."""
    at = np.flatnonzero((values[:-1] < 0.0) != (values[1:] < 0.0))
    return np.asarray(t[at] - values[at] * (t[at + 1] - t[at]) / (values[at + 1] - values[at]))
