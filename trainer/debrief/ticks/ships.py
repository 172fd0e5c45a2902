"""The ships near some boats and what their periscopes show, tick by tick, for ``judge``.

``ships_met`` finds the same in a whole record. The ships are those of the exercise, the same for
all boats; each boat has a periscope and marks of its own.
"""

from collections.abc import Callable, Mapping, Sequence
from typing import Final

import numpy as np
from numpy.typing import NDArray

from trainer.boat.boat import Boat
from trainer.boat.world.contacts import Contacts, contacts_in
from trainer.boat.world.encounters import collisions_in, passed_ships, passing_ranges
from trainer.boat.world.hulls import POSE_NAMES, OwnHull
from trainer.boat.world.scope import OPTICS_SHOWING_M, Mast, Periscope, periscope_of
from trainer.config.world.world import WorldTables
from trainer.core.kernel import Numbers
from trainer.debrief.marks.measures import IsLookedAt
from trainer.debrief.passage.ships_met import (
    MISSED_LOOKS,
    BearingMark,
    ContactReport,
    LookOut,
    bearings_marked,
    contact_reports,
    is_ship_close,
    judge_look_out,
    look_period,
)
from trainer.io.orders.grammar import Order
from trainer.io.recording.recording import RecordedEvent, RecordedOrder

Mask = NDArray[np.bool_]
SEA_NAMES: Final = (*POSE_NAMES, "eta_wave")
NO_TABLES: Final[WorldTables] = {}


class ShipWatch:
    """The ships of an exercise round some boats, and the periscope of each."""

    def __init__(self, boat: Boat, count: int, reads: tuple[str, ...], made: Mapping[str, int]):
        """Watch for boats whose columns begin with ``reads``; ``made`` are those to be written."""
        self._boat, self._made, self._hull = boat, made, OwnHull.of(boat)
        self._places = {name: reads.index(name) for name in SEA_NAMES}
        self._poses = [self._places[name] for name in POSE_NAMES]
        self.contacts: Contacts | None = contacts_in(boat)
        self._ships = self.contacts.fleet(0).order if self.contacts else ()
        self._scopes = [Periscope(boat, NO_TABLES) for _ in range(count)]
        self._fitted, self._period = periscope_of(boat), look_period(boat.method.step)
        shape = count, len(self._ships)
        self._seen = np.full(shape, -1, np.int64)  # [tick] from which the mast showed it
        self._chance = np.full(shape, -1, np.int64)  # [tick] from which it would have
        self._looks = np.zeros(shape, np.int64)  # at which it would have been in sight
        self._awaited: list[list[RecordedEvent | RecordedOrder]] = [[] for _ in range(count)]
        self._marks: list[list[tuple[RecordedEvent, Sequence[tuple[str, float]]]]] = [
            [] for _ in range(count)
        ]

        self._reports: list[list[tuple[RecordedOrder, tuple[float, float]]]] = [
            [] for _ in range(count)
        ]
        self._shown: list[list[range]] = [[] for _ in range(count)]  # [ticks] of the head

    def begin(self, index: int) -> None:
        """Begin anew with a boat: nothing is seen, marked or raised."""
        self._seen[index] = self._chance[index] = -1
        self._looks[index] = 0
        self._awaited[index], self._marks[index] = [], []
        self._reports[index], self._shown[index] = [], []
        self._scopes[index].forget()

    def raise_or_lower(self, index: int, order: Order, tick: int) -> None:
        """Have the periscope of a boat obey an order that the boat obeyed."""
        if self._fitted:
            self._scopes[index].obey(order, tick)

    def mark(self, index: int, mark: RecordedEvent) -> None:
        """Take a mark, to be judged by the numbers of its tick."""
        self._awaited[index].append(mark)

    def report(self, index: int, report: RecordedOrder) -> None:
        """Take a report of a boat's crew, to be judged likewise."""
        self._awaited[index].append(report)

    def reports(self, index: int) -> list[tuple[ContactReport, bool]]:
        """Return the reports of contacts so far, each with whether a ship was close."""
        places = {order.tick: place for order, place in self._reports[index]}
        return [
            (each, is_ship_close(self.contacts, each.tick, *places[each.tick]))
            for each in contact_reports(order for order, _ in self._reports[index])
        ]

    def first_shown(self, index: int, is_looked_at: IsLookedAt) -> int | None:
        """Return the first tick, of those looked at, at which a head showed."""
        ticks = (tick for each in self._shown[index] for tick in each)
        return next(filter(is_looked_at, ticks), None)

    def watch(self, rows: Numbers, which: list[int]) -> list[int]:
        """Write what is made of ships; return whose look-out is judged anew.

        ``rows`` [boats, 1 + ticks, columns] begin with a tick that was taken before.
        """
        own = rows[which]
        ticks = own[:, :, 0].astype(np.int64)
        if self._ships and self.contacts:
            self._write(own, "nearest", ranges := self._ranges(self.contacts, own, ticks))
            if "struck" in self._made:
                self._write(own, "struck", self._struck(self.contacts, own, ticks, ranges))
        else:
            self._write(own, "nearest", np.full(ticks[:, 1:].shape, np.inf))
        changed = self._look_out(own, ticks, which) if self._fitted else set()
        rows[which] = own
        changed |= {index for k, index in enumerate(which) if self._judge_marks(index, own[k])}
        return sorted(changed)

    def look_out(self, index: int) -> LookOut:
        """Return what the look-out of a boat saw, missed and marked so far."""
        names = [ship.name for ship in self._ships]
        seen, chances, looks = self._seen[index], self._chance[index], self._looks[index]
        found = [(int(tick), name) for name, tick in zip(names, seen, strict=True) if tick >= 0]
        could = [
            (int(tick), name)
            for name, tick, count in zip(names, chances, looks, strict=True)
            if count >= MISSED_LOOKS
        ]
        near = {id(mark): there for mark, there in self._marks[index]}
        events = [mark for mark, _ in self._marks[index]]
        marked: list[BearingMark] = [
            (tick, bearing, near[id(mark)]) for mark, tick, bearing in bearings_marked(events)
        ]
        chanced, sighted = ({name: tick for tick, name in sorted(each)} for each in (could, found))
        return judge_look_out(chanced, sighted, marked)

    def _write(self, own: Numbers, name: str, values: Numbers | Mask) -> None:
        if name in self._made:
            own[:, 1:, self._made[name]] = values

    def _ranges(self, contacts: Contacts, own: Numbers, ticks: np.ndarray) -> Numbers:
        """Return the least range [m] to any ship in the step to each tick."""
        x, y = self._poses[:2]
        ends, places = np.unique(ticks[:, 1:], return_inverse=True)
        fleet = contacts.fleet(0)
        start, end = (
            type(now)(*(column[:, places.ravel()] for column in now))
            for now in (fleet.over(np.maximum(ends - 1, 0)), fleet.over(ends))
        )
        before, now = (
            own[:, part][..., [x, y]].reshape(-1, 2).T for part in (slice(-1), slice(1, None))
        )
        ranges = passing_ranges(start, end, before, now).min(axis=0).reshape(ticks[:, 1:].shape)
        moved: Numbers = np.where(ticks[:, 1:] > ticks[:, :-1], ranges, np.inf)
        return moved

    def _struck(
        self, contacts: Contacts, own: Numbers, ticks: np.ndarray, ranges: Numbers
    ) -> Numbers:
        """Return 1 at each tick in whose step a boat runs into a ship, else 0."""
        struck = np.zeros(ranges.shape)
        reach = self._hull.reach + max(ship.type.half_diagonal for ship in self._ships)
        for k in np.flatnonzero((ranges <= reach).any(axis=1)).tolist():
            poses = own[k][:, self._poses].T
            for row, _ in collisions_in(passed_ships(contacts, ticks[k], poses), self._hull, poses):
                struck[k, row - 1] = 1.0
        return struck

    def _look_out(self, own: Numbers, ticks: np.ndarray, which: list[int]) -> set[int]:
        """Take what the periscopes show, or would; return the boats to which that is news."""
        changed = self._would_see(own, ticks, which)
        for k, index in enumerate(which):
            scope, column = self._scopes[index], self._reader(own[k, 1:])
            out, raised = scope.over(ticks[k, 1:]) if scope.acts else (np.zeros(1), np.zeros(1))
            if "eye" in self._made or scope.acts:
                heights = scope.heights_over(column, out)
                shows: Mask = (out > 0.0) & (heights > 0.0)
                self._write(own[k : k + 1], "eye", heights)
                self._write(own[k : k + 1], "head_out", shows)
                self._write(own[k : k + 1], "raise", raised)
                if self._show(index, ticks[k, 1:][shows].tolist()):
                    changed.add(index)
                seeing = np.flatnonzero(shows & (out >= OPTICS_SHOWING_M))
                if seeing.size and self._sees(index, scope, own[k, 1 + seeing], heights[seeing]):
                    changed.add(index)
            else:
                self._write(own[k : k + 1], "head_out", np.zeros(1))
                self._write(own[k : k + 1], "raise", raised)
        return changed

    def _show(self, index: int, ticks: list[int]) -> bool:
        """Take ticks at which a head showed; return whether it did not before."""
        known = self._shown[index]
        news = bool(ticks) and not (known and known[-1].stop == ticks[0])
        for tick in ticks:
            if known and known[-1].stop == tick:
                known[-1] = range(known[-1].start, tick + 1)
            else:
                known.append(range(tick, tick + 1))
        return news

    def _reader(self, rows: Numbers) -> Callable[[str], Numbers]:
        """Return what reads a number of the state in some rows by its name."""
        return lambda name: rows[:, self._places[name]]

    def _sees(self, index: int, scope: Periscope, rows: Numbers, heights: Numbers) -> bool:
        """Take rows in which a head shows; return whether a ship comes in sight first."""
        news = False
        for ship, its in enumerate(self._distances(scope, rows, heights)):
            there = np.flatnonzero(np.isfinite(its))
            if there.size and self._seen[index, ship] < 0:
                self._seen[index, ship] = int(rows[there[0], 0])
                news = True
        return news

    def _would_see(self, own: Numbers, ticks: np.ndarray, which: list[int]) -> set[int]:
        """Take the looks of masts as if up; return the boats that begin to miss a ship."""
        at = ticks[:, 1:] % self._period == 0
        if not at.any() or not self._ships:
            return set()
        boats, rows = np.nonzero(at)[0], own[:, 1:][at]
        scope = self._scopes[0]
        heights = scope.heights_over(self._reader(rows), scope.raised(Mast()).out)
        changed = set()
        for ship, its in enumerate(self._distances(scope, rows, heights)):
            for i in np.flatnonzero(np.isfinite(its)).tolist():
                index = which[int(boats[i])]
                if self._chance[index, ship] < 0:
                    self._chance[index, ship] = int(rows[i, 0])
                self._looks[index, ship] += 1
                if self._looks[index, ship] == MISSED_LOOKS:
                    changed.add(index)
        return changed

    def _distances(self, scope: Periscope, rows: Numbers, heights: Numbers) -> Numbers:
        """Return how far [m] each ship is in rows of any boats, infinite where it is not seen."""
        if not self.contacts or not self._ships:
            return np.empty((0, len(rows)))
        ticks = rows[:, 0].astype(np.int64)
        return scope.distances_in_sight(self.contacts.fleet(0), ticks, self._reader(rows), heights)

    def _judge_marks(self, index: int, rows: Numbers) -> bool:
        """Keep the marks and reports whose ticks have come, with where the ships are."""
        ticks = rows[:, 0]
        due = [each for each in self._awaited[index] if each.tick <= ticks[-1]]
        for mark in due:
            row = rows[min(int(np.searchsorted(ticks, mark.tick)), len(rows) - 1)]
            state = {name: float(row[place]) for name, place in self._places.items()}
            self._awaited[index].remove(mark)
            if isinstance(mark, RecordedOrder):
                self._reports[index].append((mark, (state["x"], state["y"])))
                continue
            near = self._fitted.near(state, mark.tick) if self._fitted else []
            self._marks[index].append((mark, near))
        return bool(due)
