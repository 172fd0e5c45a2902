"""What the channels of a record say of each other's units, signs and clock.

Turning against rudder, pitching against planes, climb against pitch, a yaw rate or a track against
the heading, a log against what was said, each angle against its limit. Turning and climbs are
regressed on first differences or means over a share of the time in which she goes her own length:
second differences of readings are noise. Each channel has its own readings. Limits are those that
drawn ships and boats keep (``tests/helpers/made_logs``). Signs of roll, bow planes and rates of
roll and pitch no such test tells of all boats: the fit itself does (``boat/search``).
"""

import itertools
import math
from collections.abc import Iterator, Mapping, Sequence
from typing import Final, NamedTuple

import numpy as np

from trainer.config.units import UNIT_FACTORS
from trainer.identify.record.motion_laws import (
    MIN_READINGS,
    Signal,
    climb_by_pitch,
    integrate,
    lay_together,
    pitch_by_planes,
    turning_power,
)

SURE_CORRELATION: Final = 0.9  # [-]
STEERED_SHARE: Final = 0.06  # [-] of its limit: a rudder that moves less follows the heading
RAREST_LENGTHS: Final = 0.35  # [L/U] from reading to reading: rarer ones tell no size
USUAL_LIMIT_RAD: Final = math.radians(35.0)  # [rad] of a rudder
TURNING_WINDOWS: Final = (0.15, 0.3, 0.6)  # [L/U] half of a mean; wider ones turn signs
TURN_LENGTHS: Final = 6.0  # [L/U] of a steady turn
MIN_TURN_RAD: Final = math.radians(6.0)  # [rad] that heading and rate are compared over
MANOEUVRE_RAD: Final = math.radians(20.0)  # [rad] who turns so far has steered
PITCHED_RAD: Final = math.radians(4.0)  # [rad] likewise, by planes
MIN_STEADY_RAD: Final = math.radians(2.0)  # [rad] by which a rudder's mean moves
MIN_RATE_READINGS: Final = 30
ABOVE_WATER_M: Final = -1.0  # [m] of depth
MOST: Final = 0.995  # quantile of an angle that is its largest
MAX_TRACK_MISS: Final = 0.1  # [-] of its variance, that log and heading leave
MAX_TRACK_RAD: Final = math.radians(35.0)  # [rad] of the track off the heading: a current
MIRROR_MISS: Final = 4.0  # [-] times more is left by the heading mirrored: else it is a current
FAR_OUT: Final = 1.5  # [-] times its limit: what nothing explains is refused beyond
EARTH_RADIUS_M: Final = 6_371_000.0  # [m] of a sphere
WHOLE_TURNS: Final = (math.tau, 360.0, 400.0, 6400.0, 36000.0, 2000.0 * math.pi)
LIMITS: Final = {  # least and largest of honest records, where they are not about 1
    "turn": (0.98, 1.02),
    "turning": (0.12, 8.0),  # [U2/L2]
    "climb": (0.62, 1.5),
    "climb by command": (0.4, 1.6),  # she is slower than her command in turns
    "track": (0.58, 1.7),
    "log": (0.6, 1.6),
    "limit": (0.0, 1.15),
    "least rudder": (0.0143, math.inf),  # half a degree of 35
    "standing rudder": (0.0014, math.inf),
    "least planes": (0.03, math.inf),
    "rudder speed": (0.06, 800.0),  # [deg/s]
    "swing": (0.04, 90.0),  # [deg/s]
}
UNPROPOSED_UNITS: Final = frozenset(("mrad/s", "rad/min", "us", "ns", "cm", "cm/s"))
COMMON_UNITS: Final = frozenset(  # the likeliest
    ("deg", "rad", "kn", "m/s", "m", "s", "ms", "us", "deg/s", "deg/min", "rad/s")
)
CHANNEL_QUANTITIES: Final = {
    "t": "s",
    **dict.fromkeys(("rudder", "stern", "bow", "heading", "pitch"), "rad"),
    "yaw_rate": "rad/s",
    **dict.fromkeys(("speed", "command_speed"), "m/s"),
    "depth": "m",
}
SIGNED_CHANNELS: Final = ("rudder", "heading", "yaw_rate", "stern", "pitch", "depth")
TURNED_SIGN: Final = "turned"  # a change of sign, in place of a unit


class Course(NamedTuple):
    """What a ship or boat is, to judge her by; None where nobody says it."""

    length: float | None  # [m]
    speed: float | None  # [m/s]
    rudder_limit: float | None  # [rad]


class Ratio(NamedTuple):
    """What was found of channels over what must be."""

    test: str
    found: float  # with its sign, which must be above 0
    limits: tuple[float, float]
    size_fault: str  # in words, where its size is out; "{}" is the size. "" where none is judged
    sign_fault: str  # likewise its sign
    powers: Mapping[str, float] = {}  # of each channel's size in it
    signed: tuple[str, ...] = ()  # turning one of them turns it
    evidence: str = ""  # how sure it is
    doubtful: bool = False  # where it is out only a little it is told, not refused
    open_by: str = ""  # this channel read otherwise leaves it open

    def agrees(self, factor: float = 1.0, sign: float = 1.0, room: float = 1.0) -> bool:
        """Return whether sizes changed by ``factor``, and signs, would agree, within a ``room``."""
        low, high = self.limits
        size = abs(self.found) * factor
        sized = not self.size_fault or low / room <= size <= high * room
        return sized and (not self.sign_fault or self.found * sign > 0.0)

    @property
    def beyond(self) -> float:
        """Return by what factor the size is beyond its limits, 1 if it is within."""
        low, high = self.limits
        size = max(abs(self.found), 1e-300)
        return max(low / size, size / high, 1.0) if self.size_fault else 1.0

    @property
    def fault(self) -> str:
        """Return in words what does not agree."""
        if self.sign_fault and self.found <= 0.0:
            return self.sign_fault + f" ({self.evidence})" * bool(self.evidence)
        low, high = (f"{limit:.3g}" for limit in self.limits)
        honest = f"at most {high}" if low == "0" else f"{low} to {high}"
        honest = f"at least {low}" if high == "inf" else honest
        return f"{self.size_fault.format(f'{abs(self.found):.3g}')} (usual: {honest})"


class Change(NamedTuple):
    """A channel read otherwise: in another unit, or ``TURNED_SIGN``."""

    channel: str
    unit: str


def compare_channels(
    channels: Mapping[str, Signal], vessel: Course, units: Mapping[str, str]
) -> list[Ratio]:
    """Return what the channels allow to compare, each sure; ``units`` are those taken."""
    have, limit = dict(channels), vessel.rudder_limit or USUAL_LIMIT_RAD
    found = list[Ratio]()
    if "heading" in have:
        have["heading"], turns = _unwrap(have["heading"], units.get("heading", "rad"))
        found += turns
    ahead = next((have[one] for one in ("speed", "command_speed") if one in have), None)
    pace = vessel.speed
    if ahead is not None:
        pace = max(float(np.median(np.abs(ahead.values))), 0.05)
    span = vessel.length / pace if vessel.length and pace else None
    tests = (
        _compare_rates(have),
        _compare_turning(have, limit, span),
        _compare_climb(have, span),
        _compare_track(have),
        _compare_logs(have, vessel),
    )
    found += itertools.chain(*tests)
    sized = any(one.test == "turning by rudder" and one.size_fault for one in found)
    assumed = vessel.rudder_limit is None
    return [*found, *_compare_limits(have, limit, assumed=assumed, sized=sized)]


def explain(ratios: Sequence[Ratio], units: Mapping[str, str]) -> list[tuple[Change, ...]]:
    """Return the fewest changes of unit or sign by which all ratios agree.

    One or two; each choice of them, the likeliest first: common units, and ratios then near 1;
    else one by which they nearly agree. Empty if there is none.
    """
    seen = {one for ratio in ratios for one in (*ratio.powers, *ratio.signed)}
    options = list[tuple[Change, float]]()
    for channel in CHANNEL_QUANTITIES:
        sizes, unit = UNIT_FACTORS[CHANNEL_QUANTITIES[channel]], units.get(channel, "")
        if channel in seen and unit in sizes:
            others = {one for one in sizes if one != unit} - UNPROPOSED_UNITS
            options += [
                (Change(channel, one), sizes[one] / sizes[unit]) for one in sizes if one in others
            ]
        if channel in seen and channel in SIGNED_CHANNELS:
            options.append((Change(channel, TURNED_SIGN), 1.0))
    for count, room in ((1, 1.0), (2, 1.0), (1, FAR_OUT)):
        if _left_by(ratios, {}, room) < math.inf:
            break
        good = []
        for chosen in itertools.combinations(options, count):
            changes = {change.channel: (change, size) for change, size in chosen}
            if len(changes) == count and (off := _left_by(ratios, changes, room)) < math.inf:
                way = tuple(change for change, _ in chosen)
                rare = sum(one.unit not in (*COMMON_UNITS, TURNED_SIGN) for one in way)
                good.append((round(off, 1), rare, way))
        if good:  # a rare unit is no choice beside a common one that does as well
            common = min((off for off, rare, _ in good if not rare), default=math.inf)
            kept = [one for one in good if not one[1] or one[0] < common]
            return [way for *_, way in sorted(kept, key=lambda one: one[:2])]
    return []


def _left_by(
    ratios: Sequence[Ratio], changes: Mapping[str, tuple[Change, float]], room: float
) -> float:
    """Return how far ratios near 1 are off it after changes, infinite if one does not agree."""
    off = 0.0
    for ratio in ratios:
        read = changes.get(ratio.open_by)
        if read and (read[0].unit != TURNED_SIGN or not ratio.signed):
            continue
        factor = math.prod(size ** ratio.powers.get(name, 0) for name, (_, size) in changes.items())
        turned = [c for name, (c, _) in changes.items() if name in ratio.signed]
        sign = math.prod(-1.0 for change in turned if change.unit == TURNED_SIGN)
        if not ratio.agrees(factor, sign, room):
            return math.inf
        low, high = ratio.limits
        if ratio.size_fault and 0.2 < low < 1.0 < high < 5.0:
            off += abs(math.log(abs(ratio.found) * factor))
    return off


def _unwrap(heading: Signal, unit: str) -> tuple[Signal, list[Ratio]]:
    """Return a heading that does not jump, and what its jumps say of its unit."""
    factor = UNIT_FACTORS["rad"].get(unit, 1.0)
    raw = heading.values / factor
    steps = np.abs(np.diff(raw))
    for turn in WHOLE_TURNS:
        jumps = steps > 0.8 * turn
        rest = steps.max(where=~jumps, initial=0.0)
        if jumps.any() and np.ptp(raw) <= 1.02 * turn and rest < 0.5 * turn:
            fault = "the heading jumps by {} of a turn"
            share = turn * factor / math.tau
            told = [Ratio("turn", share, LIMITS["turn"], fault, "", {"heading": 1})]
            return heading._replace(values=np.unwrap(heading.values, period=turn * factor)), told
    return heading._replace(values=np.unwrap(heading.values)), []


def _compare_rates(channels: Mapping[str, Signal]) -> Iterator[Ratio]:
    """Yield the yaw rate over the heading's change; both are noisy."""
    if not {"heading", "yaw_rate"} <= channels.keys():
        return
    t, (heading, rate) = lay_together(channels["heading"], channels["yaw_rate"])
    if {"roll", "pitch", "pitch_rate"} <= channels.keys():  # the rate is about the boat's own axis
        roll, pitch, q = (np.interp(t, *channels[one]) for one in ("roll", "pitch", "pitch_rate"))
        rate = (q * np.sin(roll) + rate * np.cos(roll)) / np.cos(np.clip(pitch, -1.4, 1.4))
    turned = integrate(t, rate)
    if len(t) < MIN_RATE_READINGS or max(np.ptp(heading), np.ptp(turned)) < MIN_TURN_RAD:
        return

    def of_lag(lag: int) -> tuple[float, float]:
        one, other = heading[lag:] - heading[:-lag], turned[lag:] - turned[:-lag]
        sizes = float(np.std(one)), float(np.std(other))
        if min(sizes) <= 0.0:
            return 0.0, 0.0
        return float(np.corrcoef(one, other)[0, 1]), sizes[1] / sizes[0]

    lags = (max(1, len(t) // part) for part in (80, 40, 20, 10, 5))
    together, size = max(map(of_lag, lags), key=lambda one: abs(one[0]))
    if abs(together) > SURE_CORRELATION:
        # a rate gyro may be off by some 5 %; noisy ones agree as far as they go together
        room = math.exp(0.07 + 0.8 * math.sqrt(max(1.0 - together * together, 0.0)))
        yield Ratio(
            "rate against heading",
            math.copysign(size, together),
            (1.0 / room, room),
            "the yaw rate is {} of the heading's change",
            "the yaw rate goes against the heading",
            {"yaw_rate": 1, "t": 1, "heading": -1},
            ("yaw_rate", "heading"),
            f"correlation {abs(together):.2g}",
        )


def _compare_turning(
    channels: Mapping[str, Signal], limit: float, span: float | None
) -> Iterator[Ratio]:
    """Yield how much a rudder to port turns her to port [U2/L2].

    r = G (integral of rudder) - heading / T + drift, all as means; else by a steady turn.
    """
    yaw = next((one for one in ("heading", "yaw_rate") if one in channels), None)
    if yaw is None or "rudder" not in channels:
        return
    t, (heading, rudder) = lay_together(channels[yaw], channels["rudder"])
    heading = integrate(t, heading) if yaw == "yaw_rate" else heading
    most = float(np.quantile(np.abs(channels["rudder"].values), MOST))
    if len(t) < MIN_READINGS or most < 1e-9 or np.ptp(heading) == 0.0:
        return
    flown = most >= STEERED_SHARE * limit
    run = integrate(t, rudder - rudder.mean())
    sure, gain, together = turning_power(
        t, heading, [run, heading - heading[0]], TURNING_WINDOWS, span
    )
    alone = together > SURE_CORRELATION and gain > LIMITS["turning"][1]  # nothing else moves her
    sized = span and t[1] - t[0] <= RAREST_LENGTHS * span
    if sure and (flown or (sized and alone)):
        speed = {"speed": -2.0} if "speed" in channels else {}
        yield Ratio(
            "turning by rudder",
            math.copysign(gain, -sure),
            LIMITS["turning"],
            "she turns by her rudder {} times as much as her length and speed make"
            if sized
            else "",
            "positive rudder turns her to starboard",
            {yaw: 1.0, "rudder": -1.0, "t": -2.0, **speed},
            ("rudder", yaw),
            f"{abs(sure):.2g} standard errors",
            doubtful=True,
        )
        return
    if not (flown and span and yaw == "heading"):
        return
    lag, run = max(2, round(TURN_LENGTHS * span / (t[1] - t[0]))), integrate(t, rudder)
    if len(t) > 6 * lag and np.std(rudder) > MIN_STEADY_RAD:
        together = float(np.corrcoef(heading[lag:] - heading[:-lag], run[lag:] - run[:-lag])[0, 1])
        if abs(together) > SURE_CORRELATION:
            yield Ratio(
                "steady turn",
                -together,
                (0.0, 1.0),
                "",
                "positive rudder turns her to starboard",
                signed=("rudder", "heading"),
                evidence=f"correlation {abs(together):.2g}",
            )


def _compare_climb(channels: Mapping[str, Signal], span: float | None) -> Iterator[Ratio]:
    """Yield how a boat climbs by her pitch, pitches by her planes, and that she is below."""
    if "depth" in channels and np.median(channels["depth"].values) < ABOVE_WATER_M:
        fault = "she sails above the water"
        yield Ratio("below", -1.0, (0.0, math.inf), "", fault, signed=("depth",))
    log = next((one for one in ("speed", "command_speed") if one in channels), "")
    if not ({"depth", "pitch"} <= channels.keys() and log):
        return
    ahead = channels[log]
    step = max(float(np.median(np.diff(channels[one].t))) for one in ("depth", "pitch"))
    span = span or 8.0 * step
    sure, factor = climb_by_pitch(channels, ahead, span)
    if sure:
        sized = step <= RAREST_LENGTHS * span
        yield Ratio(
            "climb against pitch",
            factor,
            LIMITS["climb" if log == "speed" else "climb by command"],
            "she climbs {} times what log and pitch say" if sized else "",
            "she climbs with her bow down",
            {"depth": 1, "t": -1, "pitch": -1, log: -1},
            ("depth", "pitch"),
            f"{abs(sure):.2g} standard errors",
        )
    if "stern" in channels and (found := pitch_by_planes(channels, ahead, span)):
        yield Ratio(
            "pitching by planes",
            found,
            (0.0, math.inf),
            "",
            "positive stern planes raise her bow",
            signed=("stern", "pitch"),
            evidence=f"{abs(found):.2g} standard errors",
        )


def _compare_track(channels: Mapping[str, Signal]) -> Iterator[Ratio]:
    """Yield a track over what log and heading say, by complex numbers, in a steady current."""
    names = ("latitude", "longitude", "heading", "speed")
    if not channels.keys() >= {*names}:
        return
    t, (latitude, longitude, heading, speed) = lay_together(*map(channels.__getitem__, names))
    if len(t) < MIN_READINGS:
        return
    across = math.cos(float(np.median(latitude)))
    place = EARTH_RADIUS_M * (latitude - latitude[0] + 1j * across * np.unwrap(longitude))
    lag = max(1, len(t) // 60)
    moved = place[lag:] - place[:-lag]

    def fit(mirror: float, *, turns: bool) -> tuple[float, float, complex]:
        ahead = speed * np.exp(1j * mirror * heading)
        sailed = np.append(0.0, np.cumsum(0.5 * (ahead[1:] + ahead[:-1]) * np.diff(t)))
        steps = sailed[lag:] - sailed[:-lag]
        columns = np.column_stack([steps, np.ones(len(steps))] if turns else [steps])
        factors, *_ = np.linalg.lstsq(columns, moved, rcond=None)
        spread = float(np.sum(np.abs(moved - moved.mean() * turns) ** 2))
        left = float(np.sum(np.abs(moved - columns @ factors) ** 2))
        return left / max(spread, 1e-300), mirror, complex(factors[0])

    right, wrong = sorted(
        (fit(mirror, turns=True) for mirror in (1.0, -1.0)), key=lambda one: one[0]
    )
    # where she hardly turns, a mirror and a current look alike
    turns = np.ptp(heading) > MANOEUVRE_RAD and wrong[0] > MIRROR_MISS * right[0]
    miss, mirror, factor = right if turns else fit(1.0, turns=False)
    if miss > MAX_TRACK_MISS:
        return
    yield Ratio(
        "track against log",
        abs(factor),
        LIMITS["track"],
        "the track is {} times as far as log and heading say",
        "",
        {"speed": -1, "t": -1},
        open_by="heading",
    )
    if turns:
        against = "the track turns against the heading"
        signed = ("heading",)
        yield Ratio(
            "track's turns", mirror, (0.0, 1.0), "", against, signed=signed, open_by="heading"
        )
    off = abs(math.atan2(factor.imag, factor.real))
    off = min(off, abs(off - 0.5 * math.pi)) if mirror < 0.0 else off  # of one from east
    aside = "the track goes {} rad off the heading: is it from east, or magnetic?"
    yield Ratio("track's north", off, (0.0, MAX_TRACK_RAD), aside, "", open_by="heading")


def _compare_logs(channels: Mapping[str, Signal], vessel: Course) -> Iterator[Ratio]:
    """Yield the log over the command, or over the speed that was said."""
    if "speed" not in channels:
        return
    usual = float(np.quantile(channels["speed"].values, 0.9))  # she is slower in turns
    other, powers = vessel.speed, {"speed": 1.0}
    if "command_speed" in channels:
        other = float(np.quantile(channels["command_speed"].values, 0.9))
        powers["command_speed"] = -1.0
    if other:
        fault = "the log is {} of " + ("her command" if len(powers) > 1 else "the speed said")
        against = "the log goes astern"
        yield Ratio("log", usual / other, LIMITS["log"], fault, against, powers, doubtful=True)


def _compare_limits(
    channels: Mapping[str, Signal], limit: float, *, assumed: bool, sized: bool
) -> Iterator[Ratio]:
    """Yield largest angles over their limits, and how fast rudder and heading go.

    A limit may be ``assumed``; a rudder that is ``sized`` by how she turns has no least.
    """
    turned = "heading" in channels and np.ptp(channels["heading"].values) > MANOEUVRE_RAD
    pitched = "pitch" in channels and np.ptp(channels["pitch"].values) > PITCHED_RAD
    for name in ("rudder", "stern", "bow"):
        if name not in channels:
            continue
        words = "rudder" if name == "rudder" else f"{name} planes"
        most = float(np.quantile(np.abs(channels[name].values), MOST)) / limit
        fault = f"{words}: the largest is {{}} of the limit"
        yield Ratio(
            f"largest of {name}", most, LIMITS["limit"], fault, "", {name: 1}, doubtful=assumed
        )
        least = "least rudder" if name == "rudder" else "least planes"
        steered = turned and not sized if name == "rudder" else pitched and name == "stern"
        if most > LIMITS["standing rudder"][0] and steered:
            yield Ratio(f"least of {name}", most, LIMITS[least], fault, "", {name: 1})
    for name, test, rows in (("rudder", "rudder speed", 5), ("heading", "swing", 20)):
        if name in channels:
            t, values = channels[name]
            if name == "rudder" and np.ptp(values) < 2.0 * LIMITS["least rudder"][0] * limit:
                continue
            lag = max(1, min(rows, len(values) // (50 if name == "rudder" else 20)))
            if len(values) <= lag or (name == "heading" and not turned):
                continue
            rates = np.degrees(np.abs(values[lag:] - values[:-lag]) / (t[lag:] - t[:-lag]))
            fast = float(np.quantile(rates, MOST if name == "rudder" else 0.99))
            if not fast:  # she moved it once or twice
                continue
            fault = f"the {name} goes at {{}} deg/s"
            yield Ratio(test, fast, LIMITS[test], fault, "", {name: 1, "t": -1}, doubtful=True)
