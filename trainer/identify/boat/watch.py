"""Whether records are still of the boat that was fitted, and since when not.

After each window all begins of a change within the memory are tried for each part, and the largest
squared score over its variance is the statistic (generalised likelihood ratio: Willsky and Jones
1976). What the fit left open is marginalised with its own deviation, so that a boat hardly known
changes unseen rather than falsely. Weight, trim and gauges of the day are states of the filter.
"""

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final, NamedTuple

import numpy as np

from trainer.config.files import ConfigError
from trainer.core.kernel import Numbers
from trainer.identify.boat.altered import (
    ALTERED_PARTS,
    MOVED_PARTS,
    PART_COUNT,
    WindowScores,
    score_records,
    usual_changes,
    window_count,
)
from trainer.identify.boat.filter import CHANNEL_NAMES, DRIVEN_COUNT
from trainer.identify.boat.matrices import invert_positive
from trainer.identify.boat.motion import STATE_COUNT
from trainer.identify.boat.noise import Noise, usual_noise
from trainer.identify.boat.prior import Prior, read_prior
from trainer.identify.boat.search import WILD_DEVIATIONS, find_noise
from trainer.identify.boat.trial import USUAL_INSTRUMENTS, Instruments, Trial, read_trial

# [-] of a score, beyond which a boat has changed: by the maxima of hours of BB2 unchanged, in calm
# and in a sea, one in a hundred should be beyond (docs/watched-boat.md)
LIMIT_DEVIATIONS: Final = 4.75
MEMORY_WINDOWS: Final = 60  # an hour of BB2: what is older says nothing more
JUDGED_WINDOWS: Final = 5  # after a change is told, before its part is named
NEAR_FALL: Final = 9.0  # [-] of the squared statistic: a part so near explains it as well
SINCE_FALL: Final = 4.0  # [-] likewise of a begin: two standard deviations
MAX_WILD_SHARE: Final = 0.2  # [-] of a window's readings
# which columns of WindowScores a part is: of the moved parts, and of the states at its begin
PART_COLUMNS: Final = np.array(
    [[float(one is part) for part in ALTERED_PARTS] for one in MOVED_PARTS]
)
STATE_PARTS: Final = np.array(
    [[float(state == part.state) for part in ALTERED_PARTS] for state in range(STATE_COUNT)]
)


@dataclass(frozen=True)
class WatchedPart:
    """What records say of a part, if it alone had changed."""

    name: str
    unit: str
    value: float | None  # the change that explains most, a share or an amount; None: none seen
    sd: float | None
    deviations: float  # [-] the largest statistic
    least: float | None  # the least change that would be told at the end; None: any is unseen
    advice: str


@dataclass(frozen=True)
class Moment:
    """A time of a record."""

    source: str
    seconds: float  # [s] in the record
    t: float  # [s] records laid one after the other


@dataclass(frozen=True)
class BoatChange:
    """That a boat has changed: when, and which parts explain it, the likeliest first."""

    earliest: Moment
    latest: Moment
    told: Moment  # when the limit is passed
    parts: tuple[WatchedPart, ...]


@dataclass(frozen=True)
class WatchedRecord:
    """A record that was followed."""

    source: str
    digest: str
    rows: int
    interval_s: float
    columns: tuple[str, ...]
    told: tuple[str, ...]


@dataclass(frozen=True)
class BoatWatch:
    """All that ``trainer boat watch`` says."""

    vessel: str
    fitted: str
    limit: float
    records: tuple[WatchedRecord, ...]
    change: BoatChange | None
    parts: tuple[WatchedPart, ...]  # as at the end, by ALTERED_PARTS
    t: tuple[float, ...]  # [s] ends of windows, one record after the other
    deviations: tuple[tuple[float, ...], ...]  # by part, after each window
    warnings: tuple[str, ...]


class ChangeScores(NamedTuple):
    """Scores after a window, of changes from each window in the memory on."""

    first: int  # the earliest of these windows
    score: Numbers  # (begins, parts), what is open taken off
    variance: Numbers  # (begins, parts, parts)

    @property
    def deviations(self) -> Numbers:
        """Return the statistic (begins, parts), in standard deviations."""
        own = np.einsum("ijj->ij", self.variance)
        return np.asarray(np.abs(self.score) / np.sqrt(np.where(own > 0.0, own, np.inf)))


@dataclass(frozen=True, eq=False)
class WatchFiles:
    """A fitted boat and records, all read and found fit for use."""

    fitted: Prior
    noise: Noise
    trials: tuple[Trial, ...]

    @property
    def windows(self) -> int:
        """Return how many windows there are."""
        return sum(window_count(self.fitted.vessel, one) for one in self.trials)


def open_watch(
    fitted: str, records: Sequence[Path], instruments: Instruments = USUAL_INSTRUMENTS
) -> WatchFiles:
    """Return what a watch needs; ConfigError with what is wrong with a file."""
    known = read_prior(fitted)
    if "fit" not in known.tables:
        raise ConfigError(
            f"{known.vessel.file.path.name}: has no [fit]: only a boat that was fitted can be "
            "watched: trainer boat fit RECORD... --prior FILE -o fitted.toml"
        )
    noise = _fitted_noise(known)
    return WatchFiles(
        known, noise, tuple(read_trial(path, known.vessel, instruments) for path in records)
    )


def _fitted_noise(known: Prior) -> Noise:
    """Return the noise from which that of a day is sought: a fit's, no less than usual.

    On the generous side the filter keeps close to the readings, whatever the weather.
    """
    table: Any = known.tables["fit"]
    logarithms = usual_noise(known.vessel).logarithms.copy()
    try:
        logarithms[:DRIVEN_COUNT] = [math.log(size) for size in table["disturbance"]]
        for name, error in table["errors"].items():
            logarithms[DRIVEN_COUNT + CHANNEL_NAMES.index(name)] = math.log(error)
    except (KeyError, TypeError, ValueError, AttributeError):
        raise ConfigError(
            f"{known.vessel.file.path.name}: fit: disturbance must be {DRIVEN_COUNT} numbers above "
            "0 and errors one by channel: fit the boat again"
        ) from None
    logarithms[:DRIVEN_COUNT] = np.maximum(logarithms, usual_noise(known.vessel).logarithms)[
        :DRIVEN_COUNT
    ]
    return Noise(logarithms, WILD_DEVIATIONS)


def watch_boat(files: WatchFiles, heard: Callable[[int], object] = lambda _: None) -> BoatWatch:
    """Return what records say of a boat; ``heard`` is told of windows that are done."""
    known, vessel = files.fitted, files.fitted.vessel
    noises = [find_noise(known, one, files.noise) for one in files.trials]
    seen = score_records(known, vessel, files.trials, noises, heard)
    return judge_scores(files, seen)


def judge_scores(files: WatchFiles, seen: Sequence[WindowScores]) -> BoatWatch:
    """Return the verdict on scores of windows."""
    usual = usual_changes(files.fitted.vessel, files.trials[0])
    tests = test_changes(seen, usual)
    highest = np.array([one.deviations.max(axis=0) for one in tests])
    trials = files.trials
    return BoatWatch(
        vessel=files.fitted.vessel.file.name,
        fitted=files.fitted.vessel.file.path.name,
        limit=LIMIT_DEVIATIONS,
        records=tuple(
            WatchedRecord(
                one.source, one.digest, len(one.readings), one.interval, one.columns, one.told
            )
            for one in trials
        ),
        change=_find_change(trials, seen, tests, highest),
        parts=tuple(_parts_at_the_end(tests, highest)),
        t=tuple(map(float, _times(trials, seen))),
        deviations=tuple(tuple(map(float, one)) for one in highest.T),
        warnings=tuple(_warnings(trials, seen)),
    )


def _times(trials: Sequence[Trial], seen: Sequence[WindowScores]) -> Numbers:
    """Return the ends [s] of windows, records laid one after the other."""
    lengths = [(len(one.readings) - 1) * one.interval for one in trials]
    before = np.cumsum([0.0, *lengths])
    return np.array([one.end + before[one.record] for one in seen])


class _Sums:
    """Scores so far of changes that began in each window of the memory, and of what is open."""

    def __init__(self, size: int, usual: Numbers) -> None:
        self.usual, self.open = usual, size - len(MOVED_PARTS) - STATE_COUNT
        self.record, self.first = -1, 0
        self.open_off = np.zeros((STATE_COUNT, self.open))
        self.open_sums: list[tuple[Numbers, Numbers]] = []  # by window
        self.off = np.zeros((0, STATE_COUNT, PART_COUNT))  # of the state, by begin
        self.score = np.zeros((0, PART_COUNT))
        self.own = np.zeros((0, PART_COUNT, PART_COUNT))
        self.cross = np.zeros((0, PART_COUNT, self.open))

    def add(self, seen: WindowScores) -> ChangeScores:
        """Add a window; return the test of all begins after it."""
        if seen.record != self.record:  # weight, trim and gauges are those of a new day
            self.record, self.open_off = seen.record, np.zeros_like(self.open_off)
            self.off = np.repeat(STATE_PARTS[None], len(self.off), axis=0)
        self.off = np.concatenate([self.off, STATE_PARTS[None]])
        self.score = np.concatenate([self.score, np.zeros((1, PART_COUNT))])
        self.own = np.concatenate([self.own, np.zeros((1, PART_COUNT, PART_COUNT))])
        self.cross = np.concatenate([self.cross, np.zeros((1, PART_COUNT, self.open))])
        moved = len(MOVED_PARTS)
        whole = np.zeros((len(self.off), len(seen.scores), PART_COUNT))
        whole[:, :moved] = PART_COLUMNS
        whole[:, moved + self.open :] = self.off
        rest = np.zeros((len(seen.scores), self.open))
        rest[moved : moved + self.open] = np.eye(self.open)
        rest[moved + self.open :] = self.open_off
        told = np.einsum("tkp,kl->tpl", whole, seen.information)
        self.score += np.einsum("tkp,k->tp", whole, seen.scores)
        self.own += np.einsum("tpl,tlq->tpq", told, whole)
        self.cross += np.einsum("tpl,li->tpi", told, rest)
        inner = np.einsum("kj,kl->jl", rest, seen.information)
        self.open_sums.append(
            (np.einsum("kj,k->j", rest, seen.scores), np.einsum("jl,li->ji", inner, rest))
        )
        self.off = np.einsum("sk,tkp->tsp", seen.carried, whole)
        self.open_off = np.einsum("sk,kj->sj", seen.carried, rest)
        self.forget()
        return self.test()

    def forget(self) -> None:
        """Drop what is older than the memory."""
        old = max(0, len(self.off) - MEMORY_WINDOWS)
        self.first += old
        self.off, self.score = self.off[old:], self.score[old:]
        self.own, self.cross = self.own[old:], self.cross[old:]
        self.open_sums = self.open_sums[-MEMORY_WINDOWS:]

    def test(self) -> ChangeScores:
        """Return the test, less what is open and what varies anyhow."""
        scores = np.sum([one for one, _ in self.open_sums], axis=0)
        information = np.sum([one for _, one in self.open_sums], axis=0)
        inverse = invert_positive(information + np.eye(self.open))
        left = np.einsum("ij,j->i", inverse, scores)
        score = self.score - np.einsum("tpj,j->tp", self.cross, left)
        taken = np.einsum("tpi,ij->tpj", self.cross, inverse)
        variance = self.own - np.einsum("tpj,tqj->tpq", taken, self.cross)
        for begin, whole in enumerate(variance.copy()):
            bound = invert_positive(whole + np.diag(self.usual**-2.0))
            varying = np.einsum("ij,jk->ik", whole, bound)
            score[begin] -= np.einsum("ij,j->i", varying, score[begin])
            variance[begin] = whole - np.einsum("ij,jk->ik", varying, whole)
        return ChangeScores(self.first, score, variance)


def test_changes(seen: Sequence[WindowScores], usual: Numbers) -> list[ChangeScores]:
    """Return the tests after each window, of changes that began in the memory.

    What is open is taken off, and then that every part varies a little anyhow, by ``usual``.
    """
    sums = _Sums(len(seen[0].scores), usual)
    return [sums.add(one) for one in seen]


def _find_change(
    trials: Sequence[Trial],
    seen: Sequence[WindowScores],
    tests: Sequence[ChangeScores],
    highest: Numbers,
) -> BoatChange | None:
    """Return the first change beyond the limit, judged by some windows more."""
    beyond = np.flatnonzero(highest.max(axis=1) > LIMIT_DEVIATIONS)
    if not len(beyond):
        return None
    told = int(beyond[0])
    at = min(told + JUDGED_WINDOWS, len(tests) - 1)
    test = tests[at]
    deviations = test.deviations
    squares = deviations.max(axis=0) ** 2
    near = [i for i in np.argsort(-squares) if squares[i] > squares.max() - NEAR_FALL]
    of_likeliest = deviations[:, near[0]] ** 2
    begins = test.first + np.flatnonzero(of_likeliest > of_likeliest.max() - SINCE_FALL)
    ends = _times(trials, seen)

    def moment(index: int, seconds: float) -> Moment:
        one = seen[index]
        return Moment(trials[one.record].source, seconds, float(ends[index]) - one.end + seconds)

    return BoatChange(
        earliest=moment(begins[0], seen[begins[0]].begin),
        latest=moment(begins[-1], seen[begins[-1]].begin),
        told=moment(told, seen[told].end),
        parts=tuple(_watched(test, i, deviations[:, i].max()) for i in near),
    )


def _parts_at_the_end(tests: Sequence[ChangeScores], highest: Numbers) -> Iterator[WatchedPart]:
    """Yield each part as it is at the end, with its largest statistic of all times."""
    for i in range(PART_COUNT):
        yield _watched(tests[-1], i, highest[:, i].max())


def _watched(test: ChangeScores, i: int, deviations: float) -> WatchedPart:
    """Return what a test says of a part, by the begin that explains most."""
    part = ALTERED_PARTS[i]
    begin = int(test.deviations[:, i].argmax())
    information = float(test.variance[begin, i, i])
    most = float(np.einsum("ijj->ij", test.variance)[:, i].max())
    least = LIMIT_DEVIATIONS / math.sqrt(most) if most > 0.0 else None
    value, sd = None, None
    if information > 0.0:
        value, sd = float(test.score[begin, i]) / information, information**-0.5
    return WatchedPart(part.name, part.unit, value, sd, float(deviations), least, part.advice)


def _warnings(trials: Sequence[Trial], seen: Sequence[WindowScores]) -> Iterator[str]:
    """Yield what should make one doubt, each with what to do."""
    for one in seen:
        if one.wild > MAX_WILD_SHARE:
            yield (
                f"{one.wild:.0%} of the readings are wild from {one.begin:.0f} s of "
                f"{trials[one.record].source} on: a gauge has failed, or the boat has changed by "
                "more than a filter follows: compare gauges, leave out the cells of one that is "
                "wrong"
            )
            return
