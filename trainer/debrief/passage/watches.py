"""The watches of a run: which person stood at which station, from when to when.

They are from the order ``relief`` in the journal. A station without one has no persons.
"""

from collections.abc import Iterable
from dataclasses import dataclass, replace
from pathlib import Path

from trainer.debrief.passage.trajectory import Trajectory
from trainer.io.recording.facts import GiverKind
from trainer.session.past.header import open_recording

RELIEF_ORDER = "relief"


@dataclass(frozen=True)
class Watch:
    """One person's time at a station, which is a role."""

    role: str
    person: str
    begun: int  # [tick]
    ended: int | None = None  # [tick] of the relief; None: there until the end
    orders: int = 0  # that were given there in that time and not refused


def stood_watches(trajectory: Trajectory) -> tuple[Watch, ...]:
    """Return the watches in the order in which they began."""
    stood: list[Watch] = []
    latest: dict[str, int] = {}  # the place in ``stood``, by role
    for entry in trajectory.orders:
        if entry.giver.kind is not GiverKind.STATION or entry.accepted is False:
            continue
        role, place = entry.giver.role, latest.get(entry.giver.role)
        if entry.name == RELIEF_ORDER:
            if place is not None:
                stood[place] = replace(stood[place], ended=entry.tick)
            latest[role] = len(stood)
            stood.append(Watch(role, entry.text.partition(" ")[2], entry.tick))
        elif place is not None:
            stood[place] = replace(stood[place], orders=stood[place].orders + 1)
    return tuple(stood)


def persons_at(watches: Iterable[Watch], role: str, first: int, last: int) -> tuple[str, ...]:
    """Return who had the watch at a station from tick to tick.

    "" comes first where none was named yet.
    """
    there = [
        each
        for each in watches
        if each.role == role and each.begun <= last and (each.ended is None or each.ended > first)
    ]
    unnamed = ("",) * (bool(there) and there[0].begun > first)
    return (*unnamed, *(each.person for each in there))


def named(watches: Iterable[Watch], role: str, tick: int) -> str:
    """Return a role with the person who had its watch at a tick: "planes (Berg)"."""
    there = persons_at(watches, role, tick, tick)
    return f"{role} ({there[-1]})" if there else role


def persons_in(path: Path) -> set[str]:
    """Return who had a watch on any branch of a recording; ConfigError, RecordingError."""
    with open_recording(path) as recording:
        journals = (recording.orders(each.id, each.after) for each in recording.branches())
        given = [entry for journal in journals for entry in journal]
    return {each.text.partition(" ")[2] for each in given if each.name == RELIEF_ORDER}
