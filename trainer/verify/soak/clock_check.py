"""A session whose clock is watched by another: `trainer serve`, and what its deadlines were.

It is given that command, since the proofs lie below the commands. The last line of its output is a
JSON object: how many deadlines were waited for, how many of them were not a whole number of steps
after the first, to the nanosecond, and the largest deviation.
"""

import json
import sys
import threading
from dataclasses import asdict, dataclass
from fractions import Fraction
from typing import Final

import click

from trainer.session.options import RunOptions
from trainer.session.plan import plan_run
from trainer.session.run import run_boat
from trainer.session.time.ledger import SECOND
from trainer.session.time.pacer import Clock, MonotonicClock


@dataclass
class Deadlines:
    """The readings of a witness."""

    seen: int = 0  # deadlines that differ from the one before
    adrift: int = 0  # of them, not first + k h rounded down, for any whole k
    furthest_ns: int = 0


class WatchedClock:
    """A clock that notes every deadline it is asked to wait for; for one thread."""

    def __init__(self, clock: Clock, period: Fraction) -> None:
        """Watch ``clock``; deadlines are to be ``period`` [ns] apart."""
        self.deadlines = Deadlines()
        self._clock = clock
        self._period = period
        self._first: int | None = None
        self._last = 0

    def now(self) -> int:
        """Return the time [ns]."""
        return self._clock.now()

    def cpu(self) -> int:
        """Return the processor time [ns] used by the calling thread."""
        return self._clock.cpu()

    def wait_until(self, deadline: int, wake: threading.Event) -> int:
        """Wait as the clock does; note the deadline."""
        if deadline != self._last:
            self._note(deadline)
        return self._clock.wait_until(deadline, wake)

    def _note(self, deadline: int) -> None:
        self._first = deadline if self._first is None else self._first
        self._last = deadline
        self.deadlines.seen += 1
        cycles = round((deadline - self._first) / self._period)
        off = deadline - self._first - int(cycles * self._period)
        if off:
            self.deadlines.adrift += 1
            self.deadlines.furthest_ns = max(self.deadlines.furthest_ns, abs(off))


PROGRAM: Final = """
from trainer.cli.run import serve
from trainer.verify.soak.clock_check import attest
attest(serve)
"""


def options_of(serve: click.Command, words: list[str]) -> RunOptions:
    """Return the options that `trainer serve` makes of its words."""
    context = serve.make_context("serve", words)
    source = context.get_parameter_source
    default = click.core.ParameterSource.DEFAULT
    given = frozenset(name for name in context.params if source(name) is not default)
    return RunOptions(**context.params, given=given, headless=True, serve=True)


def attest(serve: click.Command) -> None:
    """Serve as the arguments say. Print what the clock was asked for; leave with its exit code."""
    options = options_of(serve, sys.argv[1:])
    period = Fraction(str(plan_run(options).method.step)) * SECOND
    witness = WatchedClock(MonotonicClock(), period)
    code = run_boat(options, witness)
    click.echo(json.dumps(asdict(witness.deadlines)))
    sys.exit(code)
