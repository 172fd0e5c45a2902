"""How far the flights of a candidate set are from the full set's.

A candidate is a compact set that the search tries: the full set's coefficients times factors. A leg
is one manoeuvre at one speed. ``search`` brings these differences down, ``verdict`` judges by them.
A difference counts as a multiple of what is allowed, so that metres and degrees can be compared.
``search`` asks for those of many candidates at once; each flies every leg, so they are spread over
processes.
"""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property, partial
from pathlib import Path
from typing import Final, Self

import numpy as np
from numpy.typing import NDArray

from trainer.analysis.guide.programme import Leg
from trainer.analysis.guide.verdicts import (
    MAX_DIFFERENCE,
    Judgement,
    allowed_multiple,
    judge,
    neighbour_moves,
    set_apart,
)
from trainer.analysis.manoeuvres.flight import Flight, fly_manoeuvre
from trainer.analysis.manoeuvres.submarine import Rig, Submarine
from trainer.boat.assemble import Method, body_values, thrust_rows
from trainer.config.boat.vessel import VesselFile, load_vessel
from trainer.config.files import ConfigError
from trainer.core.kernel import Numbers
from trainer.core.terms import BASIC_DROPS, COMPACT_TERMS, EXTRA_TERMS, SLIP_TERMS
from trainer.core.vessel import compact_record
from trainer.units import KNOT
from trainer.workers import worker_pool

# What the crew commands stays at its strength: no manoeuvre moves bow planes by themselves, and a
# boat without rudder drag would pass many a test. So does what the propeller does beyond its
# thrust: other terms can make up for it at one setting of the engine, and not at all.
# fmt: off
CONTROL_COEFFICIENTS: Final = (
    "X_drdr", "X_dsds", "X_dbdb", "Y_dr", "Z_ds", "Z_db", "M_ds", "M_db", "N_dr", *SLIP_TERMS,
)
# fmt: on
# What no flight determines: bow planes move with the stern planes alone, and added masses show in
# waves, which push all of the mass that the hull carries along.
ADDED_MASSES: Final = tuple(term for term in COMPACT_TERMS if term.endswith("dot"))
FIXED_COEFFICIENTS: Final = ("X_dbdb", "Z_db", "M_db", *ADDED_MASSES)
FACTOR_NUDGE: Final = 1e-3  # [-] of a factor, for the difference quotients
MAX_SLOPE: Final = 500.0  # [-] slope; a steeper one is a number that jumps, and tells nothing
CHUNK_FLIGHTS: Final = 4  # flights handed to a process at once


def compact_terms(file: VesselFile, equations: str) -> tuple[str, ...]:
    """Return the coefficients of this hull that the compact kernel has room for."""
    dropped = BASIC_DROPS if equations == "basic" else ()
    return tuple(
        name
        for name in (*COMPACT_TERMS, *EXTRA_TERMS)
        if file.coefficients[name] and name not in dropped
    )


def fixed_terms(file: VesselFile) -> frozenset[str]:
    """Return the terms that a search leaves as they are, the file's own among them."""
    return frozenset((*FIXED_COEFFICIENTS, *(file.reduce.held_terms if file.reduce else ())))


class Candidate:
    """A submarine whose compact constants are the full set's times factors that can change."""

    def __init__(self, file: VesselFile, equations: str) -> None:
        """Fit the boat out."""
        self.terms = compact_terms(file, equations)
        self._file = file
        self._equations = equations
        self._boats: dict[tuple[Rig, Method], Submarine] = {}
        self._body = body_values(file)
        self._rows, self._eta = thrust_rows(file)
        self.take([1.0] * len(self.terms))

    def take(self, factors: Iterable[float]) -> None:
        """Set the factors by term, for the flights to come."""
        prime = {
            name: self._file.coefficients[name] * float(factor)
            for name, factor in zip(self.terms, factors, strict=True)
        }
        self._compact = compact_record(self._body, {**prime, **self._rows}, self._eta)
        for boat in self._boats.values():
            boat.boat.records.compact[:] = self._compact

    def fly(self, leg: Leg, beside: Flight) -> Flight:
        """Return the flight of a leg beside the full set's; ConfigError if it cannot start."""
        key = leg.rig, leg.method(self._file, self._equations)
        if key not in self._boats:
            boat = Submarine(self._file, key[1], leg.rig)
            boat.boat.records.compact[:] = self._compact
            self._boats[key] = boat
        return fly_manoeuvre(self._boats[key], leg.manoeuvre, leg.speed_kn * KNOT, beside.events)


@dataclass(frozen=True)
class JudgedNumber:
    """One number of a leg in which sets are compared."""

    leg: str
    quantity: str


class Yardstick:
    """The full set's flights of some legs, and the numbers in them that are judged."""

    def __init__(self, file: VesselFile, legs: Sequence[Leg]) -> None:
        """Fly the legs; those that the full set cannot start are left out."""
        self._file = file
        self._flights = dict(_fly_legs(file, legs))
        self.rows = tuple(
            JudgedNumber(leg.title, one.quantity)
            for leg, full in self._flights.items()
            for one in judge(leg.manoeuvre, full, full)
            if one.allowed
        )
        self._indices = {row: i for i, row in enumerate(self.rows)}

    @property
    def legs(self) -> tuple[Leg, ...]:
        """Return the legs that the full set flies."""
        return tuple(self._flights)

    @cached_property
    def determined(self) -> NDArray[np.bool_]:
        """Return by row whether the hull's own coefficients determine the number.

        Twelve neighbours of the full set fly every leg for it.
        """
        moves = {
            JudgedNumber(leg.title, quantity): move
            for leg, full in self._flights.items()
            for quantity, move in neighbour_moves(self._file, leg, full).items()
        }
        return np.array([moves.get(row, 0.0) <= 1.0 for row in self.rows])

    def judged(
        self, candidate: Candidate, share: float = 1.0
    ) -> Iterator[tuple[Leg, tuple[Judgement, ...]]]:
        """Yield each leg with its judgements: none if the candidate cannot start it.

        What is beyond ``share`` of what is allowed, and not determined, is set apart.
        """
        for leg, judgements in self._compared(candidate):
            yield leg, set_apart(self._file, leg, self._flights[leg], judgements, share)

    def _compared(self, candidate: Candidate) -> Iterator[tuple[Leg, tuple[Judgement, ...]]]:
        """Yield each leg with the judgements of all its numbers."""
        for leg, full in self._flights.items():
            try:
                other = candidate.fly(leg, full)
            except ConfigError:
                yield leg, ()
            else:
                yield leg, judge(leg.manoeuvre, full, other)

    def differences(self, candidate: Candidate) -> Numbers:
        """Return candidate less full by row, as multiples of what is allowed [-]."""
        differences = np.full(len(self.rows), MAX_DIFFERENCE)
        for leg, judgements in self._compared(candidate):
            for one in judgements:
                index = self._indices.get(JudgedNumber(leg.title, one.quantity))
                if index is not None:
                    differences[index] = allowed_multiple(one)
        return differences


def _fly_legs(file: VesselFile, legs: Sequence[Leg]) -> Iterator[tuple[Leg, Flight]]:
    """Yield the legs that the full set can start, with its flights."""
    keys = {leg: (leg.method(file, "full"), leg.rig) for leg in legs}
    boats = {key: Submarine(file, *key) for key in set(keys.values())}
    for leg in legs:
        try:
            yield leg, fly_manoeuvre(boats[keys[leg]], leg.manoeuvre, leg.speed_kn * KNOT)
        except ConfigError:
            continue


_worker_posts: dict[tuple[Path, str, tuple[Leg, ...]], tuple[Candidate, Yardstick]] = {}


def _differences(path: Path, equations: str, legs: tuple[Leg, ...], factors: Numbers) -> Numbers:
    """Return the differences of a candidate from the full set.

    Each process makes candidate and yardstick once and keeps them, because the yardstick flies all
    legs by the full set.
    """
    post = path, equations, legs
    if post not in _worker_posts:
        file = load_vessel(str(path))
        _worker_posts[post] = Candidate(file, equations), Yardstick(file, legs)
    candidate, yardstick = _worker_posts[post]
    candidate.take(factors)
    return yardstick.differences(candidate)


class CandidatePool:
    """Processes that each fly a candidate of the same boat."""

    def __init__(self, path: Path, equations: str, legs: tuple[Leg, ...], cores: int) -> None:
        """Start ``cores`` processes for the boat in the file at ``path``, to fly ``legs``."""
        self.legs = legs
        yardstick = Yardstick(load_vessel(str(path)), legs)
        self.rows, self._determined = yardstick.rows, yardstick.determined
        self._fly = partial(_differences, path, equations, legs)
        self._cores = cores
        self._pool = worker_pool(cores) if cores > 1 else None

    def __enter__(self) -> Self:
        """Return the pool."""
        return self

    def __exit__(self, *_: object) -> None:
        """End the processes."""
        if self._pool:
            self._pool.shutdown(cancel_futures=True)

    def differences(self, several: Sequence[Numbers]) -> list[Numbers]:
        """Return the differences of several candidates by row, in the order of the candidates.

        A number that the hull's own coefficients do not determine has the difference 0.
        """
        if self._pool is None or len(several) == 1:
            flown: Iterable[Numbers] = map(self._fly, several)
        else:
            chunk = max(1, min(CHUNK_FLIGHTS, len(several) // self._cores))
            flown = self._pool.map(self._fly, several, chunksize=chunk)
        return [self._determined * differences for differences in flown]

    def slopes(self, factors: Numbers, free: Sequence[int], here: Numbers) -> Numbers:
        """Return the slopes of the differences by ``free`` factors, (rows, all factors)."""
        nudged = []
        for index in free:
            point = factors.copy()
            point[index] += FACTOR_NUDGE
            nudged.append(point)
        slopes = np.zeros((here.size, factors.size))
        for index, point in zip(free, self.differences(nudged), strict=True):
            slopes[:, index] = (point - here) / FACTOR_NUDGE
        return np.where(abs(slopes) > MAX_SLOPE, 0.0, slopes)
