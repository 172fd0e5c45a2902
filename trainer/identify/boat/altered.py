"""What may have changed of a boat, and what windows of a record say.

A record is cut into windows. From each window's begin the filter goes on as the boat was fitted,
and again with one part changed by a little, or with one state off by a little. The differences are
slopes: of the innovations, and of the state at the window's end. So what a change of an earlier
window does to the innovations of this one is known for all begins at once, also what weight, trim
and gauges of the day have taken of it. Slopes times innovations, summed over a window, are its
scores; those of a boat that has not changed have the mean zero, and the sum of squared slopes as
variance. What the fit left open is further changes, with a deviation of one: the directions of its
covariance that the record shows. [Bas] Basseville and Nikiforov, Detection of Abrupt Changes
(1993), ch. 7 and 8: innovations, scores, nuisance.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import Final, NamedTuple

import numpy as np

from trainer.core.kernel import Numbers
from trainer.identify.boat.filter import FilterResult, FilterStart, filter_record
from trainer.identify.boat.matrices import root_of_covariance
from trainer.identify.boat.motion import (
    CONTROL_PLACES,
    MOTION_COUNT,
    STATE,
    STATE_COUNT,
    BoatNumbers,
)
from trainer.identify.boat.noise import Noise, slow_deviations, start_of
from trainer.identify.boat.prior import Knowledge
from trainer.identify.boat.regressors import FITTED_TERMS, PARAMETER_NAMES, split_factors
from trainer.identify.boat.trial import Trial
from trainer.identify.boat.vessel import FittedVessel
from trainer.units import DEGREE

WINDOW_LENGTHS: Final = 4.0  # [L/U] of a window, a minute of BB2 at 10 kn
MIN_WINDOW_READINGS: Final = 20
OPEN_NUDGE: Final = 0.2  # [-] deviations of what the fit left open
# [-] of an innovation's variance. Some forces have a step where drift or heave changes its sign; a
# slope across it is none, and is taken the other way, or where that is none too, not at all
MAX_GAIN_CHANGE: Final = 0.2
MIN_OPEN_INFORMATION: Final = 0.1  # [-] of a direction: less moves no innovation
MAX_OPEN_COUNT: Final = 40  # directions of the fit's covariance, those that the record shows most


class AlteredPart(NamedTuple):
    """A part that may have changed.

    Coefficients change by a share of them, so that -0.2 is a fifth less, a state or a control by an
    amount.
    """

    name: str
    unit: str  # "-", "m" or "rad"
    nudge: float  # [unit] by which slopes are taken
    usual: float  # [unit] deviation by which it varies anyhow; of a state, share of its day's
    advice: str  # what to do
    terms: tuple[str, ...] = ()
    state: int = -1
    control: int = -1


def _lift_terms(factor: str) -> tuple[str, ...]:
    """Return the coefficients whose force goes with the angle of a surface."""
    return tuple(term.key for term in FITTED_TERMS if split_factors(term).count(factor) == 1)


LIFT_ADVICE: Final = "look for a lost or fouled surface, a slipped stock, a wrong repeater"
ZERO_ADVICE: Final = "compare its indicator with the surface in dock, or trim the reading"
GAUGE_ADVICE: Final = "compare this gauge with another"
THRUST_ADVICE: Final = "look at the propeller, and at the counter of revolutions"
WEIGHT_ADVICE: Final = "weigh what came aboard or was pumped; look for a leak"
TRIM_ADVICE: Final = "look at what was moved or pumped fore and aft"
DAY_SHARE: Final = 0.1  # of the deviation from day to day, within a record; an estimate
ANGLE_SIZES: Final = "rad", 1e-3, 0.05 * DEGREE
ALTERED_PARTS: Final = (
    AlteredPart("lift of the rudder", "-", 0.02, 0.015, LIFT_ADVICE, terms=_lift_terms("dr")),
    AlteredPart("lift of the stern planes", "-", 0.02, 0.015, LIFT_ADVICE, terms=_lift_terms("ds")),
    AlteredPart("lift of the bow planes", "-", 0.02, 0.015, LIFT_ADVICE, terms=_lift_terms("db")),
    AlteredPart(
        "drag", "-", 0.02, 0.005, "look for growth on the hull, or for what it tows", ("a1",)
    ),
    AlteredPart("thrust", "-", 0.02, 0.005, THRUST_ADVICE, ("b1", "c1")),
    AlteredPart("weight", "-", 1e-4, DAY_SHARE, WEIGHT_ADVICE, state=STATE.WEIGHT),
    AlteredPart("trim", "m", 1e-3, DAY_SHARE, TRIM_ADVICE, state=STATE.TRIM),
    AlteredPart("zero of the rudder", *ANGLE_SIZES, ZERO_ADVICE, control=CONTROL_PLACES.RUDDER),
    AlteredPart(
        "zero of the stern planes", *ANGLE_SIZES, ZERO_ADVICE, control=CONTROL_PLACES.STERN
    ),
    AlteredPart("zero of the bow planes", *ANGLE_SIZES, ZERO_ADVICE, control=CONTROL_PLACES.BOW),
    AlteredPart("pitch gauge", "rad", 1e-3, DAY_SHARE, GAUGE_ADVICE, state=STATE.PITCH_ERROR),
    AlteredPart("roll gauge", "rad", 1e-3, DAY_SHARE, GAUGE_ADVICE, state=STATE.ROLL_ERROR),
    AlteredPart("log", "-", 2e-3, DAY_SHARE, GAUGE_ADVICE, state=STATE.LOG_ERROR),
)
PART_COUNT: Final = len(ALTERED_PARTS)
MOVED_PARTS: Final = tuple(part for part in ALTERED_PARTS if part.state < 0)
# [SI] by which slopes by the state are taken, as motion.STATE_NAMES
STATE_NUDGES: Final = (
    *(0.01, 0.01, 0.01, 1e-3, 1e-3, 1e-3, 1e-3, 1e-3, 1e-3, 0.02),
    *(1e-4, 1e-3, 1e-3, 1e-3, 2e-3, 0.01, 0.01),
)


class WindowScores(NamedTuple):
    """What a window says of changes that begin with it.

    First stand the changes of MOVED_PARTS, then what the fit left open, then states that are off at
    its begin.
    """

    record: int  # its number
    begin: float  # [s] in the record
    end: float
    scores: Numbers  # (k,)
    information: Numbers  # (k, k)
    carried: Numbers  # (STATE_COUNT, k) what the state at the end is off by
    wild: float  # share of readings that moved nothing


class _Change(NamedTuple):
    """A boat that is changed by a little, or a state or a control that is, and the same back."""

    boats: tuple[BoatNumbers, BoatNumbers]
    nudge: float = 0.0
    state: int = -1
    control: int = -1


@dataclass(frozen=True, eq=False)
class _Follower:
    """A boat that follows a record."""

    vessel: FittedVessel
    known: Knowledge
    trial: Trial
    noise: Noise

    def window(self, number: int) -> slice:
        """Return the readings of a window; those left at the end belong to the last."""
        rows, count = window_rows(self.vessel, self.trial.interval), len(self.trial.readings)
        is_last = number + 1 == window_count(self.vessel, self.trial)
        return slice(number * rows, count if is_last else (number + 1) * rows + 1)

    def follow(
        self, change: _Change, start: FilterStart, rows: slice, way: int = 0, count: int = 0
    ) -> FilterResult:
        """Return a pass over some readings of a boat changed from their begin on.

        ``way`` is 0, or 1 for the change back. The first reading of a window is the last of the
        window before, and no part of it.
        """
        readings, inputs = self.trial.readings[rows].copy(), self.trial.inputs[rows].copy()
        if rows.start:
            readings[0] = np.nan
        nudge = (1 - 2 * way) * change.nudge
        if change.control >= 0:
            inputs[:, change.control] += nudge
        if change.state >= 0:
            state = start.state.copy()
            state[change.state] += nudge
            start = start._replace(state=state)
        record = self.trial.numbers._replace(readings=readings, inputs=inputs)
        found: FilterResult = filter_record(change.boats[way], record, start, count)
        return found

    def passes(self) -> Iterator[tuple[FilterStart, FilterResult]]:
        """Yield how each window begins, and the pass over it with slopes by the coefficients."""
        boat = self.vessel.numbers(self.known.values)
        start = start_of(self.trial, self.vessel, self.noise)
        for window in range(window_count(self.vessel, self.trial)):
            rows = self.window(window)
            found = self.follow(_Change((boat, boat)), start, rows, count=len(PARAMETER_NAMES))
            yield start, found
            start = start._replace(state=found.states[-1], covariance=found.covariance)


def window_rows(vessel: FittedVessel, interval: float) -> int:
    """Return how many readings a window has."""
    return max(MIN_WINDOW_READINGS, round(WINDOW_LENGTHS * vessel.length / vessel.speed / interval))


def window_count(vessel: FittedVessel, trial: Trial) -> int:
    """Return how many windows a record has."""
    return max(1, (len(trial.readings) - 1) // window_rows(vessel, trial.interval))


def score_records(
    known: Knowledge,
    vessel: FittedVessel,
    trials: Sequence[Trial],
    noises: Sequence[Noise],
    heard: Callable[[int], object],
) -> list[WindowScores]:
    """Return what the windows of records say, one record after the other.

    ``heard`` is told of windows that are done.
    """
    pairs = zip(trials, noises, strict=True)
    followers = [_Follower(vessel, known, trial, noise) for trial, noise in pairs]
    passes = [list(one.passes()) for one in followers]
    told = sum(found.information for whole in passes for _, found in whole)
    changes = [
        *_part_changes(vessel, known),
        *_open_changes(vessel, known, np.asarray(told)),
        *_state_changes(vessel, known),
    ]
    rows = list[WindowScores]()
    for record, (follower, whole) in enumerate(zip(followers, passes, strict=True)):
        for number, (start, found) in enumerate(whole):
            rows.append(_score_window(follower, changes, start, found, (record, number)))
            heard(1)
    return rows


def _score_window(
    follower: _Follower,
    changes: Sequence[_Change],
    start: FilterStart,
    found: FilterResult,
    place: tuple[int, int],
) -> WindowScores:
    """Return what a window says; ``place`` is its record and its number there."""
    rows, interval = follower.window(place[1]), follower.trial.interval
    e, s = found.innovations.ravel(), found.variances.ravel()
    slopes, carried = np.zeros((len(e), len(changes))), np.zeros((STATE_COUNT, len(changes)))
    for i, change in enumerate(changes):
        for way in (0, 1):
            there, nudge = follower.follow(change, start, rows, way), (1 - 2 * way) * change.nudge
            gains = there.variances.ravel() / s - 1.0
            if np.nanmax(np.abs(gains), initial=0.0) < MAX_GAIN_CHANGE:
                # the innovations of a boat that has changed are its own plus slope times change
                slopes[:, i] = (e - there.innovations.ravel()) / nudge
                carried[:, i] = (there.states[-1] - found.states[-1]) / nudge
                break
    known = np.isfinite(e) & np.isfinite(slopes).all(axis=1)
    slopes, e, s = slopes[known], e[known], s[known]
    weighted = slopes / s[:, None]
    read = int(np.isfinite(follower.trial.readings[rows])[1:].sum())
    taken = int(np.isfinite(found.innovations)[1:].sum())
    return WindowScores(
        record=place[0],
        begin=rows.start * interval,
        end=(rows.stop - 1) * interval,
        scores=np.einsum("ij,i->j", weighted, e),
        information=np.einsum("ij,ik->jk", weighted, slopes),
        carried=np.nan_to_num(carried),
        wild=1.0 - taken / (read or 1),
    )


def usual_changes(vessel: FittedVessel, trial: Trial) -> Numbers:
    """Return the deviations by which parts vary anyhow within a record."""
    day = dict(enumerate(slow_deviations(vessel, trial), MOTION_COUNT))
    return np.array([one.usual * day.get(one.state, 1.0) for one in ALTERED_PARTS])


def _part_changes(vessel: FittedVessel, known: Knowledge) -> Iterator[_Change]:
    """Yield each moved part changed by its nudge."""
    for part in MOVED_PARTS:
        share = np.array([float(name in part.terms) for name in PARAMETER_NAMES])
        moved = part.nudge * share * known.values
        yield _Change(_pair(vessel, known, moved), part.nudge, control=part.control)


def _pair(
    vessel: FittedVessel, known: Knowledge, moved: Numbers
) -> tuple[BoatNumbers, BoatNumbers]:
    """Return the boats whose parameters are moved, and moved back."""
    return vessel.numbers(known.values + moved), vessel.numbers(known.values - moved)


def _state_changes(vessel: FittedVessel, known: Knowledge) -> Iterator[_Change]:
    """Yield each state off by its nudge."""
    boat = vessel.numbers(known.values)
    for state, nudge in enumerate(STATE_NUDGES):
        yield _Change((boat, boat), nudge, state=state)


def _open_changes(vessel: FittedVessel, known: Knowledge, told: Numbers) -> Iterator[_Change]:
    """Yield what the fit left open, as far as ``told`` (m, m), the information, shows it.

    The columns of a pivoted root span what is shown, the most first.
    """
    shown = np.einsum("ji,jk->ik", known.root, np.einsum("ij,jk->ik", told, known.root))
    columns = root_of_covariance(0.5 * (shown + shown.T)).T
    basis = np.zeros((0, len(shown)))
    for column in columns[:MAX_OPEN_COUNT]:
        if np.abs(column).max() ** 2 < MIN_OPEN_INFORMATION:
            break
        rest = column - np.einsum("ij,ik,k->j", basis, basis, column)
        rest -= np.einsum("ij,ik,k->j", basis, basis, rest)  # twice, for what rounding leaves
        basis = np.vstack([basis, rest / np.sqrt(np.sum(rest**2))])
    for direction in basis:
        moved = OPEN_NUDGE * np.einsum("ij,j", known.root, direction)
        yield _Change(_pair(vessel, known, moved), OPEN_NUDGE)
