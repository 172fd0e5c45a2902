"""Columns of a foreign CSV file guessed: what each is, in which unit.

``trainer identify new`` proposes a study by it. Names are compared with usual ones, then units,
then numbers; what was only guessed is marked, because its user is to correct it.
"""

import difflib
import math
import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from types import MappingProxyType
from typing import Final

import numpy as np

from trainer.config.files import ConfigError, nearest
from trainer.config.tables import CsvTable, part_heading, read_table
from trainer.config.units import spell_unit
from trainer.core.kernel import Numbers
from trainer.identify.record.logs import read_log
from trainer.identify.record.measurements import FIN_CHANNELS, POSITION_CHANNELS
from trainer.identify.record.sources import (
    MAX_INTERVAL_S,
    Column,
    check_unit,
    find_codes,
    units_of,
)

Words = Mapping[str, tuple[str, ...]]
NOTHING_TOLD: Final[Mapping[str, Column]] = MappingProxyType({})  # of columns by channel
UNSAID_COLUMN: Final = Column("", None)

CHANNEL_WORDS: Final[Words] = {  # what a column of a channel is called
    "t": ("t", "time", "utc", "timestamp", "date", "date time", "clock"),
    "rudder": ("rudder", "rudder angle", "helm", "delta", "delta r", "delta rudder"),
    "heading": ("heading", "hdg", "psi", "gyro", "compass", "yaw", "yaw angle"),
    "yaw_rate": ("yaw rate", "rot", "r", "rate of turn", "turn rate", "rate"),
    "sway": ("sway", "v", "vm", "sway velocity", "sway speed", "lateral speed"),
    "bow_sway": ("bow sway", "v1", "bow log"),
    "stern_sway": ("stern sway", "v2", "stern log"),
    "speed": ("speed", "u", "stw", "log", "surge", "speed through water"),
    "latitude": ("latitude", "lat"),
    "longitude": ("longitude", "lon", "long"),
}
# fmt: off
SHIP_WORDS: Final[Words] = {  # of records for ships that are not linear
    **{key: CHANNEL_WORDS[key] for key in ("t", "rudder", "heading", "yaw_rate", "sway", "speed")},
    "revolutions": (
        "revolutions", "n", "rpm", "rps", "revs", "propeller", "n prop", "propeller speed",
        "propeller revolutions", "shaft speed", "shaft revolutions", "engine speed",
    ),
    "north_velocity": ("north velocity", "velocity north", "vn", "x0 dot", "x dot", "dx0"),
    "east_velocity": ("east velocity", "velocity east", "ve", "y0 dot", "y dot", "dy0"),
    "wind_speed": ("wind speed", "relative wind speed", "apparent wind speed", "wind relative"),
    "wind_from": (
        "wind direction", "wind angle", "wind dir", "relative wind direction",
        "apparent wind angle", "wind dir relative",
    ),
    "wind_ahead": ("wind ahead",),
    "wind_starboard": ("wind starboard",),
    "roll": ("roll", "phi", "heel", "roll angle"),
    "roll_rate": ("roll rate", "p"),
}
BOAT_WORDS: Final[Words] = {  # of records of boats that dive
    **{key: CHANNEL_WORDS[key] for key in ("t", "heading", "yaw_rate", "speed")},
    **{key: SHIP_WORDS[key] for key in ("revolutions", "roll", "roll_rate")},
    "rudder": (*CHANNEL_WORDS["rudder"], "rudders", "dr"),
    "stern": ("stern planes", "stern plane", "stern", "delta s", "ds", "elevator", "aft planes"),
    "bow": (
        "bow planes", "bow plane", "bow", "delta b", "db", "fairwater planes", "sail planes",
        "fore planes",
    ),
    "command_speed": ("command speed", "u c", "uc"),
    **{name: (f"fin {i}", f"d{i}", f"x plane {i}") for i, name in enumerate(FIN_CHANNELS, 1)},
    "pitch": ("pitch", "theta", "pitch angle"),
    "pitch_rate": ("pitch rate", "q"),
    "depth": ("depth", "z", "keel depth"),
    "ground_speed": ("speed over ground", "sog", "ground speed"),
}
# fmt: on
EARTH_WORD: Final = "true"  # wind over ground is called so
CHANNEL_PAIRS: Final = (  # channels that tell nothing alone
    ("north_velocity", "east_velocity"),
    ("wind_speed", "wind_from"),
    ("wind_ahead", "wind_starboard"),
)
MIN_NAME_LIKENESS: Final = 0.75  # [-] likeness of two names that are one
MIN_LIKE_LETTERS: Final = 6  # of such names: shorter ones that differ are two, as date and rate
# fmt: off
UNIT_ENDINGS: Final = (  # of a heading such as psi_deg
    "deg s", "deg min", "rad s", "m s", "deg", "rad", "kn", "kts", "s", "ms", "min", "rpm", "rps",
)
FILLER_WORDS: Final = frozenset(  # words of a heading that tell no channel from another
    (
        "velo", "velocity", "vel", "angvelo", "hat", "mid", "midship", "actual", "measured",
        "filtered",
    )
)
# fmt: on
MAX_RUDDER_RAD: Final = 1.6  # [rad] no rudder goes so far
RATE_UNITS: Final = ("deg/s", "deg/min", "rad/s")  # of a yaw rate that says none
MAX_RATE_DEG_S: Final = 90.0  # [deg/s] a rate beyond it is a minute's
MAX_HEADING_RAD: Final = 7.0  # [rad] a heading beyond it is in degrees
MAX_SHIP_SPEED_M_S: Final = 12.0  # [m/s] what goes faster is in knots
MAX_WIND_SPEED_M_S: Final = 40.0  # [m/s] as a wind
MAX_MODEL_SPEED_M_S: Final = 2.5  # [m/s] a model in a basin is slower
MAX_REVOLUTIONS_S: Final = (5.0, 60.0)  # [1/s] no propeller of a ship turns faster, and of a model
UNIT_LIMITS: Final = {  # of a channel: beyond this, and its units
    "rudder": (MAX_RUDDER_RAD, "rad", "deg"),
    "heading": (MAX_HEADING_RAD, "rad", "deg"),
    "yaw_rate": (MAX_RATE_DEG_S, "deg/s", "deg/min"),  # else as its heading says
    "wind_from": (MAX_HEADING_RAD, "rad", "deg"),
    "wind_speed": (MAX_WIND_SPEED_M_S, "m/s", "kn"),
    "wind_ahead": (MAX_WIND_SPEED_M_S, "m/s", "kn"),
    "wind_starboard": (MAX_WIND_SPEED_M_S, "m/s", "kn"),
    "roll": (MAX_RUDDER_RAD, "rad", "deg"),
    "pitch": (MAX_RUDDER_RAD, "rad", "deg"),
    "stern": (MAX_RUDDER_RAD, "rad", "deg"),
    **dict.fromkeys(("bow", *FIN_CHANNELS), (MAX_RUDDER_RAD, "rad", "deg")),
    "depth": (math.inf, "m", "m"),
}
SAME_INSTRUMENT: Final = {  # of one instrument
    "roll": "heading",
    "roll_rate": "yaw_rate",
    "pitch": "heading",
    "pitch_rate": "yaw_rate",
    "stern": "rudder",
    "bow": "rudder",
    **dict.fromkeys(FIN_CHANNELS[1:], FIN_CHANNELS[0]),
}
UNCODED_CHANNELS: Final = ("t", *POSITION_CHANNELS)  # any number may be a reading of them
NAUTICAL_ANGLE: Final = re.compile(r"-?\d{4,5}(?:\.|$)")  # 5430.5 is degrees and minutes


@dataclass(frozen=True)
class GuessedColumns:
    """The columns by channel, and the channels whose unit is a guess."""

    columns: Mapping[str, Column]
    unsure: frozenset[str]
    told: tuple[str, ...] = ()  # of columns that are not read


def guess_file(
    path: Path,
    words: Words,
    told: Mapping[str, Column] = NOTHING_TOLD,
    option: str = "--column",
) -> GuessedColumns:
    """Return the likeliest columns of a table or a log, as ``guess_columns`` does; ConfigError."""
    log = read_log(path)
    if log is None:
        return guess_columns(read_table(path), words, told, option)
    _check_told(told, words, [*log.columns], option)
    meant = {
        channel: Column(one.column, None, (), one.sign if one.sign < 0.0 else None)
        for channel, one in log.meant.items()
        if channel in words
    }
    columns = {
        channel: replace(
            one, unit=check_unit(path, channel, one, log.columns[one.name].unit, option)
        )
        for channel, one in {**meant, **told}.items()
    }
    return GuessedColumns({"t": Column("t", "s"), **columns}, frozenset())


def names_in(path: Path) -> Sequence[str]:
    """Return the names of the columns of a table or a log. ConfigError."""
    log = read_log(path)
    return read_table(path).names if log is None else [*log.columns]


def _check_told(
    told: Mapping[str, Column], words: Words, names: Sequence[str], option: str
) -> None:
    """Check that columns that a user names are there; ConfigError with the nearest name."""
    for channel, one in told.items():
        for what, sought, there in (("channel", channel, (*words,)), ("column", one.name, names)):
            if sought not in there:
                raise ConfigError(
                    f"{option} {channel}={one.name}: no {what} {sought}{nearest(sought, there)}; "
                    f"there are {', '.join(dict.fromkeys(there))}"
                )


def guess_columns(
    table: CsvTable,
    words: Words,
    told: Mapping[str, Column] = NOTHING_TOLD,
    option: str = "--column",
) -> GuessedColumns:
    """Return the likeliest columns of a file for the channels of ``words``.

    ``told`` are columns by channel that somebody knows, and says by ``option``. ConfigError if one
    is none, or if a heading's brackets say no unit of its channel.
    """
    _check_told(told, words, (*table.names, *table.heads), option)
    sure = {channel: table.names[table.index(one.name)] for channel, one in told.items()}
    guessed = _by_name(table, words)
    free = {one: head for one, head in guessed.items() if head not in sure.values()}
    named = {**free, **sure}
    heads = enumerate(zip(table.names, table.units, strict=True))
    clocks = (  # by its unit or dates
        name
        for index, (name, unit) in heads
        if name not in named.values() and (unit in units_of("t") or table.is_clock(index))
    )
    if "t" not in named and (clock := next(clocks, None)):
        named["t"] = clock
    skipped = list[str]()
    if "t" in named and "t" not in sure:
        others = [name for name in table.names if name not in named.values()]
        times = [named["t"], *(name for name in others if _is_time(table, name, words["t"]))]
        good = next((name for name in times if _rises(table, name)), times[0])
        skipped = [f"{name}: cannot be read as times" for name in times[: times.index(good)]]
        named["t"] = good
    columns = {
        channel: replace(told.get(channel, UNSAID_COLUMN), name=named[channel])
        for channel in words
        if channel in named
    }
    for channel, column in columns.items():
        index = table.index(column.name)
        coded = channel not in UNCODED_CHANNELS
        codes = find_codes(table.numbers(index)) if coded else column.missing
        table = table.without(index, codes) if codes else table
        unit = _said_unit(table, channel, column, words[channel], option)
        columns[channel] = replace(column, unit=unit, missing=codes)
    unsure = frozenset(channel for channel, one in columns.items() if not one.unit)
    for channel, column in columns.items():
        if channel in unsure:
            columns[channel] = replace(column, unit=_unit(table, channel, columns))
    idle = [name for name in table.names if name not in named.values()]
    skipped += [f"not used: {', '.join(idle)}"] if idle else []
    return GuessedColumns(columns, unsure, tuple(skipped))


def _is_time(table: CsvTable, name: str, words: Iterable[str]) -> bool:
    """Return whether a column may be the times, by its name, its unit or its cells."""
    index = table.index(name)
    plain, _ = _plain(part_heading(name)[0])
    return plain in words or table.units[index] in units_of("t") or table.is_clock(index)


def _rises(table: CsvTable, name: str) -> bool:
    """Return whether a column can be read as times, and these go on."""
    index = table.index(name)
    try:
        times = table.seconds(index) if table.is_clock(index) else table.numbers(index)
    except ConfigError:
        return False
    return (
        bool(np.ptp(times[np.isfinite(times)]) > 0.0) if times[np.isfinite(times)].size else False
    )


def _by_name(table: CsvTable, words: Words) -> dict[str, str]:
    """Return the headings by channel; a heading serves one channel only."""
    likeness = {
        (channel, head): max(
            _likeness(name, channel, words[channel], _plain(head)[0])
            for name in {_plain(head)[0], _plain(part_heading(head)[0])[0]}
        )
        for channel in words
        for head in table.names
    }
    columns: dict[str, str] = {}
    for (channel, head), like in sorted(likeness.items(), key=lambda pair: -pair[1]):
        if like >= MIN_NAME_LIKENESS and channel not in columns and head not in columns.values():
            columns[channel] = head
    for pair in CHANNEL_PAIRS:  # one of a pair alone tells nothing
        if not all(channel in columns for channel in pair):
            columns = {channel: head for channel, head in columns.items() if channel not in pair}
    return columns


def _said_unit(
    table: CsvTable, channel: str, column: Column, words: Iterable[str], option: str
) -> str | None:
    """Return the unit that user or heading say of a channel; ConfigError if wrong.

    Brackets may hold a name too, as in rudder (actual), or heading (psi).
    """
    index = table.index(column.name)
    if table.is_clock(index):
        return "s"
    if column.unit or table.units[index] not in ("", *FILLER_WORDS, *words):
        return check_unit(table.path, channel, column, table.units[index], option)
    ending = _plain(column.name)[1]
    return ending if ending in units_of(channel) else None


def _plain(name: str) -> tuple[str, str]:
    """Return a heading in small letters without its unit, and that unit.

    So psi_deg is psi in deg.
    """
    words = re.sub(r"[\W_]+", " ", name.casefold()).strip()
    for ending in UNIT_ENDINGS:
        if words.endswith(f" {ending}"):
            return words.removesuffix(f" {ending}"), spell_unit(ending.replace(" ", "/"))
    return words, ""


def _likeness(name: str, channel: str, words: Iterable[str], whole: str) -> float:
    """Return how like a name is to the usual ones of a channel [-]; 1 for one of them."""
    if channel.startswith("wind") and EARTH_WORD in whole.split():
        return 0.0
    bare = " ".join(word for word in name.split() if word not in FILLER_WORDS)
    likeness = (
        difflib.SequenceMatcher(None, one, word).ratio()
        for one in {name, bare or name}
        for word in words
        if one == word or (one[:1] == word[:1] and max(map(len, (one, word))) >= MIN_LIKE_LETTERS)
    )
    return max(likeness, default=0.0)


def _unit(table: CsvTable, channel: str, columns: Mapping[str, Column]) -> str:
    """Return the likeliest unit of a column by its numbers."""
    if channel == "t":
        steps = np.diff(table.numbers(table.index(columns["t"].name)))
        steps = steps[np.isfinite(steps)]
        step = float(np.median(np.abs(steps))) if steps.size else 0.0
        likely = (one for one in ("s", "ms") if step * units_of("t")[one] <= MAX_INTERVAL_S)
        return next(likely, "us")
    if channel in POSITION_CHANNELS:
        both = [table.index(columns[one].name) for one in POSITION_CHANNELS if one in columns]
        cells = (row[index] for row in table.cells for index in both)
        return "ddmm" if any(map(NAUTICAL_ANGLE.match, cells)) else "deg"
    values = table.numbers(table.index(columns[channel].name))
    if channel == "yaw_rate" and {"t", "heading"} <= columns.keys():
        return _rate_unit(table, values, columns)
    if channel == "revolutions":  # a ship's propeller turns more slowly than a model's
        limit, _ = MAX_REVOLUTIONS_S
        if (log := columns.get("speed")) and log.unit:
            numbers = log.in_unit(table.numbers(table.index(log.name)))
            speed = units_of("speed")[log.unit] * np.abs(numbers)
            limit = MAX_REVOLUTIONS_S[float(np.nanmedian(speed)) < MAX_MODEL_SPEED_M_S]
        return "rpm" if float(np.nanmedian(np.abs(values))) > limit else "1/s"
    like = columns.get(SAME_INSTRUMENT.get(channel, ""))
    if like and like.unit:
        return like.unit
    limit, small, large = UNIT_LIMITS.get(channel, (MAX_SHIP_SPEED_M_S, "m/s", "kn"))
    if channel == "rudder" and "heading" in columns:  # angles of one file are in one unit
        heading = table.numbers(table.index(columns["heading"].name))
        values, limit = np.append(values * MAX_HEADING_RAD / limit, heading), MAX_HEADING_RAD
    return large if float(np.nanmax(np.abs(values), initial=0.0)) > limit else small


def _rate_unit(table: CsvTable, rate: Numbers, columns: Mapping[str, Column]) -> str:
    """Return the unit in which a yaw rate, summed, goes as far as the heading."""
    clock, heading = columns["t"], columns["heading"]
    index = table.index(clock.name)
    t = table.seconds(index) if table.is_clock(index) else table.numbers(index)
    t = t * units_of("t").get(clock.unit or "s", 1.0)
    turned = table.numbers(table.index(heading.name)) * units_of("heading")[heading.unit or "deg"]
    known = np.isfinite(t) & np.isfinite(turned) & np.isfinite(rate)
    summed = np.cumsum(rate[known][:-1] * np.diff(t[known]))
    if not summed.size or not np.ptp(summed) * np.ptp(turned[known]) > 0.0:
        return "deg/s"
    share = float(np.ptp(summed) / np.ptp(np.unwrap(turned[known])))
    factors = units_of("yaw_rate")
    return min(RATE_UNITS, key=lambda unit: abs(math.log(share * factors[unit])))
