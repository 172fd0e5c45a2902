"""``trainer boat evaluate``: states in, accelerations out, to check against other programs.

One JSON object a line. In: u v w [m/s] p q r [rad/s] phi theta psi delta_r delta_s delta_b [rad]
u_c [m/s]; optional x y z [m] (0), x_g y_g z_g [m] weight [N] (the vessel's) and last_udot ...
last_rdot [m/s2, rad/s2] (0), which only lagged accelerations look at. Out: the same with dots.
With the wide set z must be there: the boat is where it is, in calm water.
"""

import json
import math
from collections.abc import Iterable, Iterator
from typing import NoReturn

import numpy as np

from trainer.boat.assemble import Method, Records, fit_out
from trainer.config.boat.vessel import VesselFile
from trainer.config.files import (
    MAX_QUOTED_LETTERS,
    ConfigError,
    collecting,
    nearest,
    quote,
    quote_key,
    raise_problems,
)
from trainer.core.rates import rates as write_rates
from trainer.core.scheme import equations_alone
from trainer.core.state import MOTION, RATES
from trainer.core.update import outside

NECESSARY_KEYS = (*MOTION[:9], "delta_r", "delta_s", "delta_b", "u_c")
BALANCE_KEYS = ("x_g", "y_g", "z_g", "weight")
LAST_RATE_KEYS = {f"last_{name}": name for name in RATES[:6]}
KNOWN_KEYS = (*NECESSARY_KEYS, *MOTION[9:], *BALANCE_KEYS, *LAST_RATE_KEYS)
ANGLE_KEYS = ("phi", "theta", "psi")
MAX_ANGLE_RAD = 1e5  # [rad] the core's sine is accurate up to here


def evaluate_lines(
    file: VesselFile,
    equations: str,
    rates: str,
    trig: str,
    lines: Iterable[str],
    *,
    wide: bool = False,
) -> Iterator[str]:
    """Yield the rates of each line's state, blank lines skipped; ConfigError naming a bad line.

    ``wide`` has stall, the wide set beyond the coefficients' range, and the surface, as in a
    session; else the equations are those of 1969 alone, in deep water.
    """
    records = fit_out(file, Method(equations, rates, trig, "adams2", 1.0))
    if not wide:
        records = records._replace(scheme=equations_alone(records.scheme))
    yield from evaluate_states(records, lines)


def evaluate_states(records: Records, lines: Iterable[str]) -> Iterator[str]:
    """Yield the rates of each line's state. A key that a line lacks is as in the records."""
    state, scheme = records.state, records.scheme
    needed = NECESSARY_KEYS if scheme[0].envelope == 0 else (*NECESSARY_KEYS, "z")
    at_rest = state.copy()
    for number, line in enumerate(lines, start=1):
        if not line.strip():
            continue
        try:
            values = _read(line, needed)
        except ConfigError as wrong:
            raise ConfigError(*(f"line {number}: {text}" for text in wrong.problems)) from None
        state[:] = at_rest  # a line must not depend on the lines before it
        for key, value in values.items():
            state[LAST_RATE_KEYS.get(key, key)] = value
        with np.errstate(all="ignore"):  # what overflows is reported below
            if scheme[0].envelope != 0:
                outside(records.vessel, scheme, state, records.scratch)
            write_rates(*records)
        rates = state["rates"][0]
        if not np.isfinite(rates).all():
            lost = RATES[int(np.argmin(np.isfinite(rates)))]
            raise ConfigError(f"line {number}: {lost} is not finite: this state is out of range")
        entries = zip(RATES, rates, strict=True)  # 17 significant digits each
        yield "{" + ", ".join(f'"{name}": {value:.17g}' for name, value in entries) + "}"


def _read(line: str, needed: tuple[str, ...]) -> dict[str, float]:
    """Return the numbers of one line by key; ConfigError with all that is wrong in it."""
    short = ascii(line.strip())
    short = short if len(short) <= MAX_QUOTED_LETTERS else short[: MAX_QUOTED_LETTERS - 3] + "..."
    try:
        # a list of pairs, because a dict would hide a key that is given twice
        pairs = json.loads(line, object_pairs_hook=list, parse_constant=_refuse)
    except ConfigError:
        raise
    except (ValueError, RecursionError) as error:
        reason = getattr(error, "msg", "nested too deeply, or a number too long")
        raise ConfigError(f"is not JSON ({reason}): {short}") from None
    # an array is a list too, but not of pairs
    if not line.lstrip().startswith("{"):
        raise ConfigError(f"must be one JSON object with keys and numbers: {short}")
    keys = [key for key, _ in pairs]
    problems = [f"lacks {key}" for key in needed if key not in keys]
    twice = {key: None for key in keys if keys.count(key) > 1}
    problems += [f"{quote_key(key)} is given twice" for key in twice]
    numbers = {}
    for key, value in pairs:
        with collecting(problems):
            numbers[key] = _number(key, value)
    raise_problems(problems)
    return numbers


def _refuse(name: str) -> NoReturn:
    """Raise ConfigError for NaN and the infinities.

    They are not JSON, but Python's reader takes them unless it is told to refuse.
    """
    raise ConfigError(f"{name} is not a number that can be computed with")


def _number(key: str, value: object) -> float:
    """Return one number; ConfigError if its key, kind or size is wrong."""
    if key not in KNOWN_KEYS:
        raise ConfigError(f"no such key {quote(key)}{nearest(key, KNOWN_KEYS)}")
    # to Python a bool is an int
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise ConfigError(f"{key} = {quote(value)}: must be a number")
    try:  # an int of JSON may have any number of digits
        number = float(value)
    except OverflowError:
        number = math.inf
    if not math.isfinite(number):
        raise ConfigError(f"{key} = {quote(value)}: is too large for double precision")
    if key == "weight" and number <= 0.0:
        raise ConfigError(f"{key} = {quote(value)}: must be above 0")
    if key in ANGLE_KEYS and abs(number) > MAX_ANGLE_RAD:
        raise ConfigError(f"{key} = {quote(value)}: must be within +-{MAX_ANGLE_RAD:g} rad")
    return number
