"""Sea files: a name or path becomes a checked, complete, immutable record.

What a file leaves out comes from the shipped sea-defaults file; no default stands in code.
``exercise`` and the command line read seas here; ``sea_settings`` gives the boat its numbers.
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, fields
from pathlib import Path
from typing import Any, Final

import numpy as np

from trainer.config.files import (
    ConfigError,
    Position,
    as_table,
    collecting,
    nearest,
    parse_toml,
    path_named,
    quote,
    raise_problems,
    read_text,
    shipped_path,
)
from trainer.config.schema import (
    Choice,
    Kind,
    Text,
    optional,
    read_record,
    required,
    within,
)
from trainer.config.world.current import read_current
from trainer.core.kernel import Numbers
from trainer.core.sea.filter_1969 import PEAK_FACTOR
from trainer.core.sea.sea import COSINES, HEIGHT, OLD, OMEGA
from trainer.core.sea.wave_filter import RAISED_PEAKEDNESS, STEEPEST_TURN
from trainer.io.orders.grammar import Refused
from trainer.units import KNOT

HEADING_FIELDS: Final[Mapping[str, Kind]] = {
    "schema": Choice(("sea/1",), "form of the file"),
    "name": Text(200, "name shown"),
    "note": Text(1000, "for the reader"),
}
KNOWN_KEYS: Final = (*HEADING_FIELDS, "sea", "current")
# Significant height [m] by degree of the sea, the middle of each in WMO code table 3700.
SEA_STATE_HEIGHT: Final = (0.0, 0.05, 0.3, 0.875, 1.875, 3.25, 5.0, 7.5, 11.5)
HEIGHT_FACTOR: Final = 4.0 * math.sqrt(8.1e-3 / (4.0 * 0.74))  # [-] Hs g/U^2 of Pierson-Moskowitz
MAX_STEEPNESS: Final = 0.1  # [-] Hs over the peak's wavelength; fully developed seas have 0.026
HEIGHT_KEYS: Final = ("sea_state", "wind_kn", "height_m")
WAVE_GENERATORS: Final = ("filter", "cosines", "filter-1969")
ON_OFF: Final = ("off", "on")


@dataclass(frozen=True, kw_only=True)
class Sea:
    """Height, period and direction of a sea, and how its waves are made.

    Exactly one of the first three keys is given.
    """

    sea_state: float | None = optional(
        "-", within(0, 8), "degree of the sea by WMO code 3700; 0: calm"
    )
    wind_kn: float | None = optional("kn", within(0.01, 100), "wind that has fully raised the sea")
    height_m: float | None = optional("m", within(0, 25), "significant height")
    period_s: float | None = optional(
        "s", within(0.1, 30), "period of the peak; not with pierson-moskowitz"
    )
    spectrum: str = required(
        Choice(("pierson-moskowitz", "bretschneider", "jonswap"), "how energy lies over frequency")
    )
    gamma: float = required("-", within(1, 10), "how much jonswap's peak is raised")
    direction_deg: float = required("deg", within(0, 360), "true, where the waves come from")
    generator: str = required(
        Choice(
            WAVE_GENERATORS,
            "filtered noise, a sum of cosines from five directions, or that of 1969",
        )
    )
    suction: str = required(Choice(ON_OFF, "second-order upward force"))
    taper: str = required(Choice(ON_OFF, "no waves below five hull diameters"))
    ramp_s: float = required("s", within(0, 3600), "time in which a change comes about")


SEA_KEYS: Final = tuple(item.name for item in fields(Sea))


@dataclass(frozen=True, kw_only=True)
class SeaFile:
    """Everything a sea file says, in its own units."""

    path: Path
    text: str
    name: str
    sea: Sea
    world: Mapping[str, Any] = field(default_factory=dict)  # its current, as an exercise has it


def load_sea(name_or_path: str) -> SeaFile:
    """Return the shipped sea of that name or the one in that file. ConfigError if it is wrong.

    Whatever has a path separator or ends in .toml is a path.
    """
    path = path_named(name_or_path, "seas")
    return parse_sea(read_text(path), path)


def parse_sea(text: str, path: Path) -> SeaFile:
    """Return the sea written in ``text``, which came from ``path``; ConfigError if it is wrong."""
    position = Position(path.name, "")
    table = parse_toml(text, path.name)
    problems: list[str] = []
    for key, value in table.items():
        with collecting(problems):
            if key in HEADING_FIELDS:
                HEADING_FIELDS[key].read(key, value, position)
            elif key not in KNOWN_KEYS:
                text = (
                    "belongs under [sea]"
                    if key in SEA_KEYS
                    else f"no such key{nearest(key, KNOWN_KEYS)}"
                )
                raise ConfigError(position.wrong(key, value, text))
    with collecting(problems):
        if "sea" not in table:
            raise ConfigError(position.problem("lacks the table [sea]"))
        sea = read_sea(table["sea"], position.inside("sea"))
    world = {}
    with collecting(problems):
        if "current" in table:
            world["current"] = read_current(table["current"], position.inside("current"), path)
    raise_problems(problems)
    name = table.get("name", path.stem)
    return SeaFile(path=path, text=text, name=name, sea=sea, world=world)


def read_sea(table: object, position: Position) -> Sea:
    """Return the sea of one table, such as an exercise's. ConfigError with all that is wrong."""
    sea = read_record(Sea, {**sea_defaults(), **as_table(table, position)}, position, ("note",))
    problems = _problems(sea)
    if problems:
        raise ConfigError(*(position.problem(text) for text in problems))
    return sea


def sea_defaults() -> Mapping[str, Any]:
    """Return the table [sea] of the shipped file of defaults."""
    path = shipped_path("", "sea-defaults")
    return as_table(parse_toml(read_text(path), path.name).get("sea"), Position(path.name, "sea"))


def _problems(sea: Sea) -> list[str]:
    """Return problems of keys that do not fit together."""
    given_keys = [name for name in HEIGHT_KEYS if getattr(sea, name) is not None]
    if len(given_keys) != 1:
        have = f"has {', '.join(given_keys)}" if given_keys else "has none of them"
        return [f"{have}: give one of {', '.join(HEIGHT_KEYS)}"]
    problems = []
    if sea.sea_state is not None and sea.sea_state != math.floor(sea.sea_state):
        problems.append(f"sea_state = {sea.sea_state:g}: must be a whole number; or give height_m")
    standard = sea.spectrum == "pierson-moskowitz"
    if standard and sea.period_s is not None:
        problems.append(
            f"period_s = {sea.period_s:g}: pierson-moskowitz has its own; "
            'leave it out or set spectrum = "bretschneider"'
        )
    if not standard and sea.period_s is None:
        problems.append(f"lacks period_s, which spectrum = {quote(sea.spectrum)} needs")
    if sea.spectrum == "jonswap" and sea.generator == "filter-1969":
        problems.append(
            'generator = "filter-1969": makes no jonswap spectrum; set generator = "filter"'
        )
    if sea.period_s is not None and not problems:
        # 9.81, because a sea is read without a boat, whose file has the gravity.
        problems += _steep(significant_height(sea, 9.81), sea.period_s)
    return problems


def _steep(height: float, period: float) -> list[str]:
    """Return a problem if waves of this height [m] and peak period [s] would break."""
    shortest = math.sqrt(2.0 * math.pi * height / (9.81 * MAX_STEEPNESS))
    if period >= shortest:
        return []
    return [
        f"period_s = {period:g}: waves of {height:g} m break; must be at least {shortest:.1f} s"
    ]


def significant_height(sea: Sea, g: float) -> float:
    """Return the significant height [m] with gravity ``g`` [m/s2]."""
    if sea.sea_state is not None:
        return SEA_STATE_HEIGHT[int(sea.sea_state)]
    if sea.wind_kn is not None:
        return HEIGHT_FACTOR * (sea.wind_kn * KNOT) ** 2 / g
    return float(sea.height_m or 0.0)


def peak_frequency(sea: Sea, g: float) -> float:
    """Return the frequency of the peak [rad/s].

    A calm has that of one knot of wind, because no height would give an infinite one.
    """
    if sea.period_s is not None:
        return 2.0 * math.pi / sea.period_s
    height = significant_height(sea, g)
    wind = math.sqrt(g * height / HEIGHT_FACTOR) if height > 0.0 else KNOT
    return PEAK_FACTOR * g / wind


def sea_settings(file: SeaFile, g: float) -> Numbers:
    """Return the sea [SI] by SEA_QUANTITIES, and the taper: what ``order_sea`` takes."""
    sea = file.sea
    towards = math.radians((sea.direction_deg + 180.0) % 360.0)
    gamma = sea.gamma if sea.spectrum == "jonswap" else 1.0
    return np.array(
        [
            significant_height(sea, g),
            peak_frequency(sea, g),
            gamma,
            towards,
            float(sea.generator == "cosines"),
            float(sea.suction == "on"),
            float(sea.generator == "filter-1969"),
            float(gamma >= RAISED_PEAKEDNESS),
            float(sea.taper == "on"),
        ]
    )


def step_problem(wanted: Numbers, step: float) -> Refused | None:
    """Return why a step [s] is too long for a sea, None if it fits. The sea is by ``sea_settings``.

    Only the wave filter has this limit, because it folds frequencies above Nyquist into its bands.
    """
    turn = wanted[OMEGA] * step
    if wanted[HEIGHT] == 0.0 or wanted[COSINES] + wanted[OLD] > 0.0 or turn <= STEEPEST_TURN:
        return None
    longest = math.floor(1000.0 * STEEPEST_TURN / wanted[OMEGA]) / 1000.0
    shorter = f"a step of {longest:g} s or " if longest > 0.0 else ""
    return Refused(
        f"a sea above Nyquist for the step: its peak of {wanted[OMEGA]:.3g} rad/s turns "
        f"{turn:.3g} rad in {step:g} s, at most {STEEPEST_TURN:g}; take {shorter}"
        'generator = "cosines"'
    )
