"""Spells: how long each casualty of a passage lasted, and who answered it with what, and when."""

from dataclasses import dataclass
from typing import Final

import numpy as np

from trainer.analysis.debrief.trajectory import AMOUNTS, SLOTS, Trajectory
from trainer.config.casualties import Casualty
from trainer.config.files import ConfigError
from trainer.config.score_rules import INSTRUCTING
from trainer.core.casualties import KINDS
from trainer.core.surfaces import SURFACES
from trainer.io.orders.grammar import Order, parse
from trainer.io.recording.recording import Journalled

SCHEDULE: Final = "schedule"  # who gives the orders of the exercise
INSTRUCTOR: Final = "instructor"
MOVED: Final = np.radians(2.0)  # [rad] by which a surface has been deflected


@dataclass(frozen=True)
class Episode:
    """One casualty from the tick at which it began to that after which it was gone."""

    kind: str
    begun: int  # [tick]
    ended: int | None  # [tick] None: it lasted to the end
    amount: float  # [SI] of its kind, the largest either way


@dataclass(frozen=True)
class Deflection:
    """The first surface to have moved during a casualty."""

    surface: str
    tick: int


def spells(trajectory: Trajectory) -> tuple[Episode, ...]:
    """Return the casualties in the order in which they began; ConfigError if one is unheard of."""
    slots = np.array([trajectory.columns[name] for name in SLOTS])
    known = np.isin(slots, range(len(KINDS) + 1))
    if not known.all():
        raise ConfigError(f"recording: casualty {slots[~known][0]:g}: is none; it is damaged")
    amounts = np.array([trajectory.columns[name] for name in AMOUNTS])
    found = [
        episode
        for code in sorted({int(code) for code in np.unique(slots)} - {0})
        for episode in _of_kind(trajectory, slots == code, amounts, KINDS[code - 1])
    ]
    return tuple(sorted(found, key=lambda episode: episode.begun))


def first_spell(trajectory: Trajectory, casualty: Casualty | None) -> Episode | None:
    """Return the first time that a casualty came, None if it did not."""
    kind = casualty.kind if casualty else ""
    return next((each for each in spells(trajectory) if each.kind == kind), None)


def _of_kind(
    trajectory: Trajectory, there: np.ndarray, amounts: np.ndarray, kind: str
) -> list[Episode]:
    """Return the spells of one kind, whose slots are those ``there``."""
    active = np.any(there, axis=0)
    edges = np.flatnonzero(np.diff(np.concatenate(([False], active, [False])).astype(int)))
    found = []
    for first, after in edges.reshape(-1, 2):
        held = np.where(there, amounts, 0.0)[:, first:after]
        amount = float(held.ravel()[np.argmax(np.abs(held))])
        lasted = after == trajectory.ticks.size
        # a state shows what acted in the tick that led to it
        begun = max(int(trajectory.ticks[first]) - 1, 0)
        found.append(Episode(kind, begun, None if lasted else int(trajectory.ticks[after]), amount))
    return found


def crew_orders(trajectory: Trajectory) -> tuple[Journalled, ...]:
    """Return what the crew ordered and the boat accepted.

    The crew is everybody but schedule and instructor; when nobody else has ordered anything the
    instructor is alone on board, and is the crew.
    """
    given = [
        each for each in trajectory.orders if each.who != SCHEDULE and each.accepted is not False
    ]
    stations = [each for each in given if not each.who.startswith(INSTRUCTOR)]
    return tuple(each for each in stations or given if name_of(each) not in INSTRUCTING)


def name_of(entry: Journalled) -> str:
    """Return which order of the grammar it was, '' if this version does not know it."""
    order = parse(entry.text)
    return order.name if isinstance(order, Order) else ""


def answer_to(
    trajectory: Trajectory, episode: Episode, names: tuple[str, ...] | None = None
) -> Journalled | None:
    """Return the crew's first order after a casualty began, of ``names`` if given."""
    caused = [
        each.id
        for each in trajectory.orders
        if each.tick == episode.begun and name_of(each) == "casualty"
    ]
    for each in crew_orders(trajectory):
        # at the tick itself only what was ordered after the casualty, in a freeze
        later = each.tick > episode.begun
        later = later or (each.tick == episode.begun and bool(caused) and each.id > caused[-1])
        if later and (names is None or name_of(each) in names):
            return each
    return None


def deflection(trajectory: Trajectory, episode: Episode) -> Deflection | None:
    """Return the first surface but the failed one to have moved by MOVED since it began."""
    start = trajectory.row(episode.begun)
    first: list[Deflection] = []
    for surface in SURFACES:
        if episode.kind.startswith(surface) or not trajectory.has(surface):
            continue
        angle = trajectory.series(surface)[start:]
        moved = np.flatnonzero(np.abs(angle - angle[0]) >= MOVED)
        if moved.size:
            first.append(Deflection(surface, int(trajectory.ticks[start + moved[0]])))
    return min(first, key=lambda each: each.tick, default=None)
