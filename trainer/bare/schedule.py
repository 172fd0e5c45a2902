"""A file of orders for an exported core: SECONDS ORDER, as for ``trainer run --orders``."""

import math

from trainer.bare.card import WrongError
from trainer.bare.core import Core
from trainer.bare.wording import Row, rows_of, understand

LATEST = 1e6  # [s]

Timed = tuple[float, Row, float]  # [s], the order's row, its number [SI]


def read_schedule(path: str, core: Core) -> list[Timed]:
    """Return the orders of a file sorted by time; WrongError naming the line that is wrong."""
    try:
        with open(path, encoding="utf-8") as file:
            lines = file.read().removeprefix("\ufeff").split("\n")
    except OSError as error:
        raise WrongError(f"--orders {path}: {error.strerror}") from None
    except UnicodeDecodeError:
        raise WrongError(f"--orders {path}: not a text file") from None
    rows = rows_of(core)
    timed = []
    for number, line in enumerate(lines, start=1):
        words = line.partition("#")[0].split(None, 1)
        if words:
            try:
                timed.append(_entry(words, rows))
            except WrongError as wrong:
                raise WrongError(f"{path}:{number}: {wrong}") from None
    return sorted(timed, key=lambda entry: entry[0])


def _entry(words: list[str], rows: dict[str, Row]) -> Timed:
    """Return the entry in SECONDS and the words of an order."""
    if len(words) < 2 or not words[0].replace(".", "", 1).isdecimal() or not words[0].isascii():
        raise WrongError("a line is SECONDS ORDER, such as: 600 rudder right 15")
    seconds = float(words[0])
    if seconds > LATEST:
        raise WrongError(f"{words[0]} s: the latest time is {LATEST:.0f} s")
    return (seconds, *understand(words[1], rows))


def first_tick(seconds: float, step: float) -> int:
    """Return the first tick not before ``seconds`` [s]."""
    return math.ceil(seconds / step - 1e-9)
