"""What paces the ticks, and may be changed while they run."""

import math
from dataclasses import dataclass

from trainer.clock import Clock, Pacer, Policy, Unpaced
from trainer.ledger import Ledger


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

    @classmethod
    def at(cls, clock: Clock, step: float, speed: float, policy: Policy) -> "Timekeeping":
        """Return the keeping of time at ``speed``, infinity for as fast as it goes."""
        ledger = Ledger(step)
        return cls(clock, ledger, policy, keeper(clock, ledger, speed, policy), speed)

    @property
    def frozen(self) -> bool:
        """Return whether time stands still."""
        return self.pacer.frozen

    def change(self, speed: float) -> None:
        """Let time go ``speed`` times as fast from now on."""
        self.speed = speed
        if math.isfinite(speed) and isinstance(self.pacer, Pacer):
            self.pacer.set_speed(speed)
            return
        frozen = self.pacer.frozen
        self.pacer = keeper(self.clock, self.ledger, speed, self.policy)
        if not frozen:
            self.pacer.run()
