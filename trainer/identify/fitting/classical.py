"""Gains and time constants from one manoeuvre, by the methods from before likelihoods.

``trainer ship steering --record`` puts them beside the ship's. Sections 2.3 (a turn) and 2.8 (a
zig-zag) of the report of 1974. All in SI and rad, the rudder to port.
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
MIN_TURNING_POINTS, MIN_SAMPLES, MIN_HALF_WINDOW = 3, 20, 4  # [-], [samples], [samples]


def is_zigzag(record: Record) -> bool:
    """Return whether the rudder was thrown to both sides."""
    rudder = record.column("rudder")
    thrown = THROWN_SHARE * np.nanmax(np.abs(rudder))
    return bool(np.nanmax(rudder) >= thrown and np.nanmin(rudder) <= -thrown)


def measure_zigzag(record: Record) -> tuple[float, float]:
    """Return K [1/s] and T [s] of a zig-zag by Nomoto's method.

    T r' + r = K (delta + delta_0) is integrated. Between turning points of the heading r is zero at
    both ends, so that K and delta_0 are left; from there to a zero of the heading T is. ConfigError
    if it is too short.
    """
    t, rudder, rate, heading = _columns(record)
    helm, heading = _integral(t, rudder), heading - heading[0]
    begin = t[np.argmax(np.abs(rudder) >= THROWN_SHARE * np.abs(rudder).max())]
    tops, zeros = (each[each > begin] for each in (_crossings(t, rate), _crossings(t, heading)))
    if len(tops) < MIN_TURNING_POINTS:
        raise ConfigError(
            f"{record.source}: the heading turns {len(tops)} times: Nomoto's method needs "
            f"{MIN_TURNING_POINTS} turning points: sail the zig-zag for longer"
        )
    helms, headings = (np.interp(tops, t, values) for values in (helm, heading))
    sums = np.column_stack([np.diff(helms), np.diff(tops)])
    K, drift = np.linalg.lstsq(sums, np.diff(headings), rcond=None)[0]
    zeros = zeros[zeros > tops[0]]
    helm_since, turned = np.interp(zeros, t, helm) - helms[0], np.interp(zeros, t, heading)
    lacking = K * helm_since + drift * (zeros - tops[0]) - (turned - headings[0])
    rates = np.interp(zeros, t, rate)
    return float(K), float(lacking @ rates / (rates @ rates))


def read_phase_plot(record: Record, ship: BentShip, window: float) -> tuple[complex, ...]:
    """Return T1, T2, T3 [s] from a zig-zag's phase plot, r' over r (Bech, Smitt).

    What the steady turns of ``ship`` leave is (T1 + T2) r' + T1 T2 r'' - K T3 delta'. r'' is r'
    times the plot's slope. All are smoothed alike over ``window`` [s]: a throw breaks no term.
    """
    t, rudder, rate, _ = _columns(record)
    even = np.arange(t[0], t[-1], record.interval)
    rudder, rate = np.interp(even, t, rudder), np.interp(even, t, rate)
    count = max(round(0.5 * window / record.interval), MIN_HALF_WINDOW)
    weights = (1.0 - np.linspace(-1.0, 1.0, 2 * count + 1) ** 2) ** 3
    left = ship.K * (rudder - ship.helm(rate))
    left, helm, rate = (
        np.convolve(values, weights / weights.sum(), "valid") for values in (left, rudder, rate)
    )
    turning, thrown = (np.gradient(values, record.interval) for values in (rate, helm))
    bending = np.gradient(turning, record.interval)
    terms = np.column_stack([turning, bending, -ship.K * thrown, np.ones_like(left)])
    inner = slice(2, -2)  # at the ends differences are to one side
    (total, product, T3, _), *_ = np.linalg.lstsq(terms[inner], left[inner], rcond=None)
    return (*time_constants(total / product, 1.0 / product), complex(T3))


def measure_turn(record: Record, speed: float) -> tuple[float, ...]:
    """Return the effective K [1/s] and T [s] of a turn, twice.

    They are of its time, then of its distance as if run at ``speed`` [m/s]. K is the steady rate
    over the rudder, T by how much the heading lags behind K times the rudder.
    """
    sailed = np.full_like(record.t, speed)
    if record.speed is not None:
        sailed = np.hypot(record.speed, 0.0 if record.sway is None else record.sway)
    t, rudder, rate, _, sailed = _columns(record, sailed)
    steady = t >= t[-1] - STEADY_SHARE * (t[-1] - t[0])
    found = list[float]()
    for clock, turning in ((t, rate), (_integral(t, sailed) / speed, rate * speed / sailed)):
        last_rudder, last_rate = rudder[steady].mean(), turning[steady].mean()
        lag = _integral(clock, rudder / last_rudder - turning / last_rate)[-1]
        found += [float(last_rate / last_rudder), float(lag)]
    return tuple(found)


def _columns(record: Record, *further: Numbers) -> tuple[Numbers, ...]:
    """Return time, rudder, yaw rate, heading and others of the samples that have all of them."""
    names = ("rudder", "turning", "heading")
    columns = np.array([record.t, *(record.column(name) for name in names), *further])
    whole = columns[:, ~np.isnan(columns).any(axis=0)]
    if whole.shape[1] < MIN_SAMPLES or not whole[1].any():
        needs = "rows with rudder, yaw rate and heading, and a rudder that moves"
        raise ConfigError(f"{record.source}: the old methods need {MIN_SAMPLES} {needs}")
    return tuple(whole)


def _integral(t: Numbers, values: Numbers) -> Numbers:
    """Return the integral from the first sample to each, by trapezoids (n,)."""
    return np.append(0.0, np.cumsum(0.5 * (values[1:] + values[:-1]) * np.diff(t)))


def _crossings(t: Numbers, values: Numbers) -> Numbers:
    """Return the times at which values go through zero."""
    at = np.flatnonzero((values[:-1] < 0.0) != (values[1:] < 0.0))
    return np.asarray(t[at] - values[at] * (t[at + 1] - t[at]) / (values[at + 1] - values[at]))
