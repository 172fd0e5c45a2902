"""What paces the ticks, and may be changed while they run."""

import contextlib
import math
from collections.abc import Iterator
from dataclasses import dataclass, field

from trainer.clock import Clock
from trainer.ledger import Ledger
from trainer.pacer import Pacer, Policy, Unpaced
from trainer.punctuality import Punctuality, Unasked


def keeper(clock: Clock, ledger: Ledger, speed: float, policy: Policy) -> Pacer | Unpaced:
    """Return what paces ticks at ``speed``; an infinite speed is as fast as the machine allows."""
    if math.isinf(speed):
        return Unpaced(clock, ledger)
    return Pacer(clock, ledger, speed, policy)


@dataclass
class Timekeeping:
    """The clock, the ledger, and the pacer of the moment."""

    clock: Clock
    ledger: Ledger
    policy: Policy
    pacer: Pacer | Unpaced
    speed: float  # [-]
    punctuality: Punctuality | Unasked = field(default_factory=Unasked)

    @classmethod
    def at(cls, clock: Clock, step: float, speed: float, policy: Policy) -> "Timekeeping":
        """Return the keeping of time at ``speed``, infinity for as fast as it goes."""
        ledger = Ledger(step)
        return cls(clock, ledger, policy, keeper(clock, ledger, speed, policy), speed)

    @property
    def frozen(self) -> bool:
        """Return whether time stands still."""
        return self.pacer.frozen

    @contextlib.contextmanager
    def attended(self) -> Iterator[None]:
        """Have from the system what time is kept by, inside the block, in the thread that ticks."""
        self._attend()
        try:
            yield
        finally:
            self.punctuality.relax()

    def change(self, speed: float) -> None:
        """Let time go ``speed`` times as fast from now on."""
        self.speed = speed
        self._attend()
        if math.isfinite(speed) and isinstance(self.pacer, Pacer):
            self.pacer.set_speed(speed)
            return
        frozen = self.pacer.frozen
        self.pacer = keeper(self.clock, self.ledger, speed, self.policy)
        if not frozen:
            self.pacer.run()

    def _attend(self) -> None:
        """Ask for it where time is kept; as fast as it goes needs no precedence over others."""
        (self.punctuality.keep if math.isfinite(self.speed) else self.punctuality.relax)()
