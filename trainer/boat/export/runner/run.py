"""``trainer run --headless --core FILE.so``: its words, its orders, its CSV file, its ticks."""

import math
import sys
import time

from trainer.boat.export.runner.library import Core, WrongError
from trainer.boat.export.runner.orders import Row, rows_of, understand
from trainer.units import DEGREE, KNOT

TAKING = ("--core", "--duration", "--speed", "--csv", "--orders", "--state")
UNITS = {"h": 3600.0, "m": 60.0, "s": 1.0}


class Options:
    """The options of the command line."""

    def __init__(self, words: list[str]) -> None:
        """Read the words after ``trainer run``; WrongError naming the one that is wrong."""
        given = _read_words(words)
        if "--headless" not in given:
            raise WrongError("--core: such a run has no console; add --headless")
        if not given.get("--core"):
            raise WrongError("--core: give the path of an exported library")
        self.core = given["--core"]
        self.duration = seconds(given["--duration"]) if "--duration" in given else None  # [s]
        self.speed = speed(given.get("--speed", "1"))  # [-] inf: as fast as can be
        self.csv = given.get("--csv", "")
        self.orders = given.get("--orders", "")
        self.state = given.get("--state", "")


def _read_words(words: list[str]) -> dict[str, str]:
    """Return the values of the options by name."""
    given = {}
    left = iter(words)
    for word in left:
        name, equals, value = word.partition("=")
        if name == "--headless" and not equals:
            given[name] = ""
        elif name not in TAKING:
            raise WrongError(
                f"{word}: a run on an exported core, whose boat, sea and step are settled, takes "
                f"--headless and {', '.join(TAKING)}"
            )
        elif not equals and (value := next(left, "")) == "":
            raise WrongError(f"{name}: a value is missing")
        else:
            given[name] = value
    return given


def seconds(text: str) -> float:
    """Return a time [s] written as 90, 10m or 1h30m; WrongError if it is none."""
    total, digits, units = 0.0, "", "hms"
    for letter in text.strip().lower():
        place = units.find(letter)
        if letter in "0123456789.":
            digits += letter
        elif place < 0 or not _plain(digits):
            break
        else:
            total += float(digits) * UNITS[letter]
            digits, units = "", units[place + 1 :]
    else:
        bare_number = _plain(digits) and units == "hms"
        total += float(digits) if bare_number else 0.0
        if total > 0.0 and (bare_number or not digits):
            return total
    raise WrongError(f"--duration {text}: give a time such as 90, 10m or 1h30m")


def _plain(digits: str) -> bool:
    """Return whether this is a number of digits and at most one point."""
    return digits.replace(".", "", 1).isdecimal() and digits[0] != "."


def speed(text: str) -> float:
    """Return a speed of time, infinite for max; WrongError if it is none."""
    if text.lower() in ("max", "inf"):
        return float("inf")
    if _plain(text.removeprefix("x")) and 0.1 <= float(text.removeprefix("x")) <= 100.0:
        return float(text.removeprefix("x"))
    raise WrongError(f"--speed {text}: give 0.1 to 100, or max")


LATEST = 1e6  # [s]

Timed = tuple[float, Row, float]  # [s], the order's row, its number [SI]


def read_schedule(path: str, core: Core) -> list[Timed]:
    """Return the orders of a file sorted by time. WrongError naming the line that is wrong."""
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


class Table:
    """Rows on their way to a file, or to none. Trouble with the disk ends the file, not the run."""

    def __init__(self, path: str, core: Core, buffering: int) -> None:
        """Open ``path``, "" for none, with ``buffering`` as ``open`` takes it for lines of text.

        WrongError if it cannot be written.
        """
        self.path = path
        self.trouble = ""
        self._file = None
        self._places = list(core.card.columns.values())[1:]
        if not path:
            return
        try:
            self._file = open(path, "w", buffering, "ascii", newline="\n")  # noqa: SIM115
            heading = ",".join(("tick", "t", *list(core.card.columns)[1:]))
            self._file.write(f"{heading}\n")
        except OSError as error:
            raise WrongError(f"--csv {path}: {error.strerror}") from None

    def row(self, core: Core) -> None:
        """Write the state of ``core``: tick, time [s], then the columns."""
        if self._file is None or self.trouble:
            return
        s = core.state
        values = [s[0] * core.card.step, *[s[place] for place in self._places]]
        try:
            self._file.write(f"{s[0]:.0f},{','.join(map(repr, values))}\n")
        except OSError as error:
            self.trouble = f"--csv {self.path}: {error.strerror}"

    def close(self) -> str:
        """Close the file; return what went wrong with it."""
        if self._file is not None:
            try:
                self._file.close()
            except OSError as error:
                self.trouble = self.trouble or f"--csv {self.path}: {error.strerror}"
        return self.trouble


UNPACED = float("inf")
BY_LINE, BY_BLOCK = 1, -1  # how rows go to the disk: at once where time is kept
BEHIND = 5  # [ticks] made up after a delay; what is more is let go


class Pace:
    """Deadlines from one anchor: tick k is due at anchor + k h / speed."""

    def __init__(self, period: float) -> None:
        """Begin now, a tick each ``period`` [s]; 0 never waits."""
        self.period = period
        self.started = self.anchor = time.monotonic()
        self.late = 0  # [ticks] begun after their deadline by more than a period

    def wait(self, tick: int) -> None:
        """Sleep until ``tick`` is due; after a long delay go on from here."""
        if not self.period:
            return
        ahead = self.anchor + tick * self.period - time.monotonic()
        if ahead > 0.0:
            time.sleep(ahead)
        elif ahead < -self.period:
            self.late += 1
            self.anchor -= min(ahead + BEHIND * self.period, 0.0)


def main(words: list[str]) -> int:
    """Run as the ``words`` after ``trainer run`` say; return the exit code."""
    try:
        options = Options(words)
        core = Core(options.core)
        orders = read_schedule(options.orders, core) if options.orders else []
        table = Table(options.csv, core, BY_BLOCK if options.speed == UNPACED else BY_LINE)
    except WrongError as wrong:
        print(f"trainer: {wrong}", file=sys.stderr)
        return 2
    last = round(options.duration / core.card.step) if options.duration else None
    pace = Pace(core.card.step / options.speed)
    try:
        failure = sail(core, orders, table, pace, last)
    except KeyboardInterrupt:
        failure = ""  # it was to end here
    wall = time.monotonic() - pace.started
    troubles = [failure, table.close(), keep_state(core, options.state)]
    try:
        print(account(core, pace, wall), flush=True)
    except OSError as lost:
        troubles.append(f"the account: {lost.strerror}")
    for trouble in filter(None, troubles):
        print(f"trainer: {trouble}", file=sys.stderr)
    return 1 if any(troubles) else 0


def sail(core: Core, orders: list[Timed], table: Table, pace: Pace, last: int | None) -> str:
    """Take ticks until ``last``, or for ever. Return what a tick failed by, "" if none did."""
    step = core.card.step
    table.row(core)
    tick = given = 0
    while tick != last:
        pace.wait(tick + 1)
        while given < len(orders) and first_tick(orders[given][0], step) <= tick:
            orders[given][1].carry_out(core, orders[given][2])
            given += 1
        status = core.tick()
        if status:
            return core.failure(status)
        tick += 1
        table.row(core)
    return ""


def keep_state(core: Core, path: str) -> str:
    """Write the state's bytes to ``path``, if any; return what is wrong with the disk."""
    if not path:
        return ""
    try:
        with open(path, "wb") as file:
            file.write(bytes(core.state))
    except OSError as error:
        return f"--state {path}: {error.strerror}"
    return ""


def account(core: Core, pace: Pace, wall: float) -> str:
    """Return the account of a run that took ``wall`` [s]."""
    card = core.card
    s = {name: core.state[place] for name, place in card.columns.items()}
    course = round(s["psi"] / DEGREE, 1) % 360.0
    place = f"{s['z']:.5g} m, course {course:05.1f}, {s['u'] / KNOT:.4g} kn"
    simulated = f"{s['tick'] * card.step:.1f} s in {s['tick']:.0f} ticks"
    attitude = f"pitch {s['theta'] / DEGREE:+.2f}, heel {s['phi'] / DEGREE:+.2f} degrees"
    return "\n".join(
        (
            card.boat,
            f"computed    {card.computed}, exported for {card.cpu}",
            f"simulated   {simulated}; {wall:.2f} s on the clock",
            f"on time     late {pace.late}",
            f"the boat    {place}, {attitude}",
        )
    )
