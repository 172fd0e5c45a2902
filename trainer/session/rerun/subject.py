"""The subject: the boat that is shown, and what an exercise does not want passed."""

from dataclasses import dataclass

from trainer.boat.boat import Boat
from trainer.config.exercise import Limits
from trainer.session.plan import Plan


@dataclass(frozen=True, eq=False)
class Subject:
    """The subject of a picture. Nothing of the boat that moves is looked at."""

    boat: Boat
    limits: Limits
    title: str

    @classmethod
    def of(cls, plan: Plan, boat: Boat) -> "Subject":
        """Return the boat of a plan as the subject."""
        return cls(boat, plan.limits, plan.title or boat.file.name)

    @property
    def length(self) -> float:
        """Return the boat's length [m]."""
        return float(self.boat.vessel.ell)

    @property
    def step(self) -> float:
        """Return the time [s] from tick to tick."""
        return self.boat.method.step
