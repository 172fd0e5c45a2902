"""Drawn logs: honest ones are not refused, planted units, signs and repeats are found."""

from collections.abc import Iterable, Sequence
from functools import cache

import numpy as np
import pytest
from helpers.made_logs import UNITS, MadeLog, fly_boats, fly_ships

from trainer.config.units import UNIT_FACTORS
from trainer.core.kernel import Numbers
from trainer.identify.record.contradictions import Contradiction, find_contradiction
from trainer.identify.record.evidence import (
    CHANNEL_QUANTITIES,
    TURNED_SIGN,
    Change,
    Course,
    compare_channels,
)
from trainer.identify.record.motion_laws import Signal
from trainer.identify.record.readings import find_hold

QUANTITIES = CHANNEL_QUANTITIES | dict.fromkeys(("latitude", "longitude"), "place")
ANGLES_ALONE = ("yaw_rate", "speed", "latitude", "longitude")
FLEETS = {  # what sails, and what of it is not recorded
    "ships": (fly_ships, ()),
    "ships without a track": (fly_ships, ("latitude", "longitude")),
    "ships of angles alone": (fly_ships, ANGLES_ALONE),
    "boats": (fly_boats, ()),
    "boats without log and rate": (fly_boats, ("yaw_rate", "speed")),
}
MIRRORED = "mirrored"


@cache
def logs_of(fleet: str, count: int, seed: int = 0) -> Sequence[MadeLog]:
    return FLEETS[fleet][0](count, seed)


def judged(
    log: MadeLog, without: Iterable[str], channel: str = "", true: str = "", said: str = ""
) -> Contradiction | None:
    """Return what is found of a log, the numbers of a channel in ``true`` and called ``said``."""
    units = {**UNITS, "t": "s"}
    clock = 1.0
    if channel == "t":
        units["t"], clock = said, UNIT_FACTORS["s"][said] / UNIT_FACTORS["s"][true]
    channels = {}
    for name, values in log.channels.items():
        sizes = UNIT_FACTORS[QUANTITIES[name]]
        factor, read = sizes[units[name]], values
        if name == channel and true == TURNED_SIGN:
            read = -read
        elif name == channel and true == MIRRORED:
            read = (360.0 - read) % 360.0
        elif name == channel:
            units[name], factor = said, factor * sizes[said] / sizes[true]
        if name not in without:
            channels[name] = Signal(log.t * clock, read * factor)
    vessel = Course(log.length, log.speed, None)
    with np.errstate(all="raise"):
        return find_contradiction(compare_channels(channels, vessel, units), units)


@pytest.mark.parametrize("fleet", FLEETS)
@pytest.mark.parametrize("count", [60, pytest.param(500, marks=pytest.mark.slow)])
def test_at_most_one_honest_log_in_a_hundred_is_refused(fleet: str, count: int) -> None:
    found = [judged(log, FLEETS[fleet][1]) for log in logs_of(fleet, count)]
    refused = [one.faults for one in found if one and one.refused]
    assert len(refused) <= max(1, count // 100), refused


PLANTED = [  # channel, what its numbers truly are, what they are called, fleet, found [%]
    ("heading", "rad", "deg", "ships", 96),
    ("heading", "deg", "rad", "ships", 90),
    ("heading", "gon", "deg", "ships", 60),
    ("rudder", "rad", "deg", "ships of angles alone", 85),
    ("rudder", "mrad", "deg", "ships", 96),
    ("rudder", "deg", "rad", "ships", 96),
    ("yaw_rate", "deg/min", "deg/s", "ships", 96),
    ("yaw_rate", "deg/h", "deg/s", "ships", 96),
    ("yaw_rate", "deg/s", "rad/s", "ships", 96),
    ("speed", "kn", "m/s", "ships", 96),
    ("speed", "km/h", "m/s", "boats", 96),
    ("speed", "mph", "m/s", "ships", 90),
    ("depth", "ft", "m", "boats", 90),
    ("depth", "fathom", "m", "boats", 90),
    ("stern", "rad", "deg", "boats", 96),
    ("pitch", "rad", "deg", "boats", 90),
    ("t", "ms", "s", "ships", 96),
    ("t", "min", "s", "ships", 90),
    ("t", "s", "ms", "ships of angles alone", 96),
    ("t", "s", "min", "ships", 96),
    ("rudder", TURNED_SIGN, "", "ships of angles alone", 96),
    ("yaw_rate", TURNED_SIGN, "", "ships", 96),
    ("stern", TURNED_SIGN, "", "boats", 85),
    ("pitch", TURNED_SIGN, "", "boats", 90),
    ("depth", TURNED_SIGN, "", "boats", 96),
    ("heading", MIRRORED, "", "ships", 96),
]


@pytest.mark.parametrize(("channel", "true", "said", "fleet", "share"), PLANTED)
def test_a_planted_unit_or_sign_is_found_and_mostly_named(
    channel: str, true: str, said: str, fleet: str, share: int
) -> None:
    logs = logs_of(fleet, 40, 1)
    found = [judged(log, FLEETS[fleet][1], channel, true, said) for log in logs]
    wrong = [one for one in found if one]
    assert 100.0 * len(wrong) >= share * len(logs)
    change = Change(channel, TURNED_SIGN if true in (TURNED_SIGN, MIRRORED) else true)
    named = [one for one in wrong if any(change in way for way in one.ways)]
    assert len(named) >= 0.8 * len(wrong)


def held(values: Numbers, rows: float) -> Numbers:
    """Return a column in which a reading stands for so many rows."""
    read = np.floor(np.floor((np.arange(len(values)) + 0.37) / rows) * rows).astype(int)
    return np.asarray(values[np.maximum(read, 0)])


@pytest.mark.slow
def test_what_is_filled_forward_is_found_in_drawn_logs_and_nothing_else() -> None:
    logs = [*logs_of("ships", 100, 2), *logs_of("boats", 100, 2)]
    names = [name for name in UNITS if name not in ("latitude", "longitude", "command_speed")]
    columns = [log.channels[name] for log in logs for name in names if name in log.channels]
    coarse = [np.round(one) for one in columns]
    taken = [one for one in (*columns, *coarse) if find_hold(one).every > 1.0]
    assert len(taken) <= 0.003 * 2 * len(columns)
    for rows, share in ((2.0, 0.97), (3.0, 0.97), (5.0, 0.99), (10.0, 0.99), (4.6, 0.95)):
        slow = [held(one, rows) for one in columns if len(one) / rows >= 30]
        slow = [one for one in slow if np.count_nonzero(np.diff(one)) >= 12]
        found = [abs(find_hold(one).every / rows - 1.0) < 0.03 for one in slow]
        assert np.mean(found) >= share, rows
