"""Logs of drawn ships and boats by equations of their own: nothing of the trainer sails here.

``fly_ships`` and ``fly_boats`` give logs as an honest logger writes them: noise, steps, drifts and
currents; zig-zags, turns, random steps and a helmsman with doublets. Signs are those of a vessel
file: rudder positive turns to port, stern planes positive put the bow down, pitch bow up.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Final

import numpy as np

from trainer.core.kernel import Numbers

DEGREE: Final = np.pi / 180.0
METRES_A_DEGREE: Final = 111_195.0
INTERVALS_S: Final = (0.1, 0.2, 0.25, 0.5, 1.0, 2.0, 5.0)
UNITS: Final = {  # of the channels
    **dict.fromkeys(("rudder", "stern", "bow", "heading", "pitch"), "deg"),
    **dict.fromkeys(("speed", "command_speed"), "m/s"),
    **dict.fromkeys(("latitude", "longitude"), "deg"),
    "yaw_rate": "deg/s",
    "depth": "m",
}
STATES: Final = ("rudder", "heading", "rate", "speed", "stern", "bow", "pitch", "depth", "x", "y")


@dataclass(frozen=True)
class MadeLog:
    """A log whose truth is known: ``channels`` in the units of ``UNITS`` at times ``t`` [s]."""

    t: Numbers
    channels: Mapping[str, Numbers]
    length: float  # [m]
    speed: float  # [m/s]


def fly_ships(count: int, seed: int) -> list[MadeLog]:
    """Return logs of ships of 25 to 340 m and of yachts and models of 1.5 to 14 m."""
    drawn = np.random.default_rng(seed)
    large = drawn.integers(0, 2, count) == 0
    length = np.where(large, _even_log(drawn, 25, 340, count), _even_log(drawn, 1.5, 14, count))
    speed = np.clip(np.sqrt(9.81 * length) * drawn.uniform(0.1, 0.28, count), 0.4, 14.0)
    return _fly(drawn, length, speed, boats=False)


def fly_boats(count: int, seed: int) -> list[MadeLog]:
    """Return logs of boats like BB2, a swimmers' vehicle and a REMUS, which also dive."""
    drawn = np.random.default_rng(seed)
    kind = drawn.integers(0, 3, count)
    low, high = np.array([(50, 110), (6, 14), (1.3, 3.5)])[kind].T
    slow, fast = np.array([(2.5, 7), (1.2, 3.2), (1.2, 2.2)])[kind].T
    return _fly(drawn, drawn.uniform(low, high), drawn.uniform(slow, fast), boats=True)


def _even_log(drawn: np.random.Generator, low: float, high: float, count: int) -> Numbers:
    return np.exp(drawn.uniform(np.log(low), np.log(high), count))


def _fly(  # noqa: PLR0915 - one sea, sailed tick by tick
    drawn: np.random.Generator, length: Numbers, speed: Numbers, *, boats: bool
) -> list[MadeLog]:
    """Sail all at once, each by steps of a fiftieth of the time in which she goes her length."""
    count, span = len(length), length / speed

    def even(low: Any, high: Any) -> Numbers:
        return np.asarray(drawn.uniform(low, high, count))

    least, most = np.maximum(0.1, 0.01 * span), np.clip(0.3 * span, 0.11, 5.0)
    wanted = np.exp(even(np.log(least), np.log(np.maximum(most, least))))
    distances = np.abs(np.log(wanted[:, None] / np.array(INTERVALS_S)))
    interval = np.array(INTERVALS_S)[np.argmin(distances, axis=1)]
    parts = np.ceil(interval / (0.02 * span)).astype(int)
    h, lengths = interval / parts, even(25, 60)
    ticks = np.ceil(lengths * span / h).astype(int)
    # a ship of second order that holds her course, or in one of ten does not
    gain = _even_log(drawn, 1.2, 4.0, count) if boats else _even_log(drawn, 0.5, 4.0, count)
    power = _even_log(drawn, 0.5, 2.2, count) if boats else _even_log(drawn, 0.35, 1.6, count)
    T2, T3 = even(0.15, 0.4) * span, even(0.3, 0.9) * span
    T1 = np.maximum(gain / power * span + T3 - T2, 0.3 * span)
    stable = even(0, 1) > 0.1
    linear, bend = np.where(stable, 1.0, -0.4), np.where(stable, even(0, 0.6), even(1.5, 3))
    swing = np.where(span > 4.0, even(2.3, 6), even(8, 30)) * DEGREE  # of a surface, a second
    mode, size = drawn.integers(0, 4, count), even(8, 22) * DEGREE
    switch = np.where(even(0, 1) < 0.5, size, even(6, 12) * DEGREE)
    bias, wave = drawn.normal(0, 0.7, count) * DEGREE, _even_log(drawn, 1e-3, 2e-2, count) / span
    hold, left = even(1.5, 5) * span, np.zeros(count)
    current = np.minimum(1.0, 0.35 * speed) * even(0, 1) * np.exp(1j * even(0, 2 * np.pi))
    course, amplitude, gate = even(0, 2 * np.pi), even(4, 10) * DEGREE, even(3, 8) * DEGREE
    # heave and pitch, in lengths and speeds of the boat
    m_w, m_q, inertia = even(0.030, 0.036), even(0.007, 0.010), even(0.0016, 0.0022)
    Zw, Zs, Zb = -even(0.028, 0.042), -even(0.004, 0.009), -even(0.004, 0.008)
    Mw, Mq, Ms = even(0.006, 0.012), -even(0.005, 0.008), -even(0.003, 0.006)
    Zr, Mr = even(-0.008, 0.008), even(-0.0015, 0.0015)  # a turn lifts and pitches her
    righting = np.clip(0.05 * 9.81 * length / speed**2, 1.0, 30.0)
    Mp = -even(0.0002, 0.0006) * righting
    r, bent, psi, d, order, disturbance = np.zeros((6, count))
    w, q, pitch, ds, db, planes, wound = np.zeros((7, count))
    u, depth, place = speed.copy(), 60.0 + 2.0 * length, np.zeros(count, complex)
    kept, begun = depth.copy(), 1.5 * span
    seen = np.empty((ticks.max() + 1, len(STATES), count), np.float32)
    for i in range(len(seen)):
        t, heading = i * h, psi + course
        seen[i] = d, heading, r, u, ds, db, pitch, depth, place.real, place.imag
        over = np.where((order > 0) & (psi < -switch), -size, order)
        zigzag = np.where(order == 0, size, np.where((order < 0) & (psi > switch), size, over))
        left -= h
        new = left <= 0.0
        left = np.where(new, hold * even(0.5, 2), left)
        steps = np.where(new, even(-1, 1) * size, order)
        phase = t % (12.0 * span)
        doublet = 0.6 * size * (1.0 * (phase < 1.5 * span) - ((phase / span - 2.25) ** 2 < 0.5625))
        helmsman = np.clip(0.8 * psi + 0.6 * span * r, -0.5, 0.5) + doublet
        order = np.where(t > begun, np.choose(mode, [zigzag, size, steps, helmsman]), 0.0)
        moved = np.clip(order - d, -swing * h, swing * h)
        d = d + moved
        disturbance = disturbance * (1.0 - 2.0 * h / span)
        disturbance += wave * np.sqrt(h / span) * drawn.standard_normal(count)
        helm = gain / span * (d + bias + T3 * moved / h)
        holding = r * (linear + bend * np.abs(r) * span) + (T1 + T2) * bent
        bent = bent - h * (helm + holding) / (T1 * T2)
        r = r + h * (bent + 0.5 * disturbance / span)
        psi = psi + h * r
        u = u + h / (3.0 * span) * (speed / (1.0 + 0.9 * (r * span) ** 2) - u)
        place = place + h * ((u - 0.35j * r * length) * np.exp(1j * (psi + course)) + current)
        if boats:
            rising = np.where((planes > 0) & (pitch < -gate), -amplitude, planes)
            diving = np.where((planes < 0) & (pitch > gate), amplitude, rising)
            planes = np.where(planes == 0, amplitude, diving)
            dives = (t > 0.55 * lengths * span) & (t < 0.85 * lengths * span)
            off = (depth - kept) / length
            wound = np.clip(wound + h / span * off * ~dives, -0.5, 0.5)
            wanted_pitch = np.clip(0.25 * off + 0.02 * wound, -0.15, 0.15)
            keeping = np.clip(-1.5 * (wanted_pitch - pitch) + 1.2 * q * span, -0.35, 0.35)
            stern, bow = np.where(dives, planes, keeping), np.clip(-0.5 * off, -0.3, 0.3) * ~dives
            ds = ds + np.clip(stern - ds, -swing * h, swing * h)
            db = db + np.clip(bow - db, -swing * h, swing * h)
            v, wn, qn, turned = u / speed, w / speed, q * span, (r * span) ** 2
            heave = Zw * v * wn + m_q * v * qn + v * v * (Zs * ds + Zb * db) + Zr * turned
            moment = Mw * v * wn + Mq * v * qn + v * v * Ms * ds + Mp * pitch + Mr * turned
            w = w + h * heave / m_w * speed / span
            w = w + 0.002 * speed * np.sqrt(h / span) * drawn.standard_normal(count)
            q = q + h * moment / inertia / span**2
            pitch = pitch + h * q
            depth = depth + h * (w * np.cos(pitch) - u * np.sin(pitch))
    logs = []
    for j in range(count):
        rows = np.arange(0, ticks[j] + 1, parts[j])
        truth = dict(zip(STATES, seen[rows, :, j].astype(float).T, strict=True))
        channels = _read(drawn, truth, length[j], span[j], speed[j], boats=boats)
        logs.append(MadeLog(rows * h[j], channels, float(length[j]), float(speed[j])))
    return logs


def _read(
    drawn: np.random.Generator,
    truth: Mapping[str, Numbers],
    length: float,
    span: float,
    speed: float,
    *,
    boats: bool,
) -> dict[str, Numbers]:
    """Return what instruments of usual errors and steps read."""
    count = len(truth["heading"])

    def read(values: Numbers, error: float, *steps: float) -> Numbers:
        noisy = values + error * drawn.standard_normal(count)
        step = drawn.choice(steps) if steps else 0.0
        return np.round(noisy / step) * step if step else noisy

    helm_error, log_error = drawn.uniform(0.03, 0.2), drawn.uniform(0.005, 0.02) * speed
    gyro_error = drawn.uniform(0.01, 0.06) / DEGREE * 0.2 / max(span, 1.0)
    rate = truth["rate"] / DEGREE * drawn.normal(1, 0.02) + drawn.normal(0, 0.01)
    heading = read(truth["heading"] / DEGREE % 360.0, drawn.uniform(0.05, 0.4), 0.01, 0.1, 0.1, 0.5)
    channels = {
        "rudder": read(truth["rudder"] / DEGREE, helm_error, 0.01, 0.1, 0.5),
        "heading": heading % 360.0,
        "yaw_rate": read(rate, gyro_error, 0.001, 0.01),
        "speed": read(truth["speed"] * drawn.normal(1, 0.05), log_error, 0.01, 0.05),
    }
    if boats:
        planes = {name: read(truth[name] / DEGREE, helm_error, 0.01) for name in ("stern", "bow")}
        pitch = read(truth["pitch"] / DEGREE, drawn.uniform(0.03, 0.2), 0.01)
        depth = read(truth["depth"], drawn.uniform(0.01, 0.08), 0.01)
        command = np.full(count, speed)
        return channels | planes | {"pitch": pitch, "depth": depth, "command_speed": command}
    fix_error = 0.02 if length < 4.0 else 0.3 if length < 20.0 else 1.5
    latitude, longitude = drawn.uniform(-60, 60), drawn.uniform(-170, 170)
    across = METRES_A_DEGREE * np.cos(latitude * DEGREE)
    channels["latitude"] = latitude + read(truth["x"], fix_error) / METRES_A_DEGREE
    channels["longitude"] = longitude + read(truth["y"], fix_error) / across
    return channels
