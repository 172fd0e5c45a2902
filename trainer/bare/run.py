"""``trainer run --headless --core FILE.so``: the boat of an exported core, and nothing else."""

import sys
import time

from trainer.bare.card import WrongError
from trainer.bare.core import Core
from trainer.bare.options import Options
from trainer.bare.schedule import Timed, first_tick, read_schedule
from trainer.bare.table import Table
from trainer.units import DEGREE, KNOT

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
    """Take ticks until ``last``, or for ever; return what a tick failed by, "" if none did."""
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
