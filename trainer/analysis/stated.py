"""The figures that an exercise's texts state are flown, and compared with them.

``trainer exercise check`` calls it. A text that says "level within 90 seconds" goes wrong unseen
when the boat changes; its row in [[stated]] is flown by nobody or by the reference crew.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from trainer.config.stated import StatedValue
from trainer.debrief.rehearsal import Rehearsal, fly_rehearsal
from trainer.debrief.trajectory import Trajectory
from trainer.session.plan import Plan


@dataclass(frozen=True)
class StatedFigure:
    """One stated figure and its flight."""

    stated: StatedValue
    flown: float | None  # [s] or in the quantity's unit; None: it did not come, or cannot be flown
    tolerance: float  # in the unit of ``flown``

    @property
    def holds(self) -> bool:
        """Return whether the boat does what the text says."""
        return self.flown is not None and abs(self.flown - self.stated.target) <= self.tolerance

    @property
    def difference(self) -> str:
        """Return in words how the flown figure differs from the stated one."""
        stated, row = self.stated, self.stated.row
        what = row.when if row.when is not None else f"{row.measure} {row.quantity}"
        by = "nobody aboard" if row.by == "nobody" else "the reference crew"
        flown = "never so" if self.flown is None else f"{self.flown:.4g} {stated.unit}"
        sentence = f"flown by {by}, {what} is {flown}, not {stated.target:g} {stated.unit} within"
        return f"{sentence} {self.tolerance:.3g}: correct the text and its row"


def fly_stated(
    plan: Plan, stated: tuple[StatedValue, ...], flights: Mapping[str, Rehearsal]
) -> list[StatedFigure]:
    """Return stated figures flown. ``flights`` has flights by nobody and the crew made before."""
    flights = dict(flights)
    figures = []
    for entry in stated:
        order_words = (f", {order.seconds:g} {order.order.text}" for order in entry.orders)
        way = entry.row.by + "".join(order_words)
        if way not in flights:
            schedule = sorted([*plan.schedule, *entry.orders], key=lambda order: order.seconds)
            crew = plan.crew if entry.row.by == "crew" else None
            flights[way] = fly_rehearsal(replace(plan, schedule=schedule), crew)
        trajectory = flights[way].trajectory
        step = trajectory.boat.method.step if entry.measured is None else 0.0
        figures.append(
            StatedFigure(entry, _measured(entry, trajectory), max(entry.tolerance, step))
        )
    return figures


def _measured(stated: StatedValue, trajectory: Trajectory) -> float | None:
    """Return the figure of the boat's flight, None if it never comes to one."""
    row, measured = stated.row, stated.measured
    names = [condition.quantity for condition in stated.conditions]
    names += [measured.name] if measured else []
    if not all(trajectory.has(name) for name in names):
        return None
    if measured is None:
        held = trajectory.between(row.from_s, row.to_s)
        for condition in stated.conditions:
            held &= trajectory.holds(condition)
        return float(trajectory.seconds[np.argmax(held)]) if held.any() else None
    window = trajectory.between(row.from_s, row.to_s)
    if row.measure == "value":
        window = trajectory.between(row.at_s, row.at_s)
    values = stated.target + trajectory.off(measured, stated.target)[window]
    if values.size == 0:
        return None
    return float(values.max() if row.measure == "highest" else values.min())
