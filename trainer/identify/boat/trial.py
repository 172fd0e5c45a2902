"""A record of a boat's trial, as the filter takes it.

Columns, units, clocks and codes for no reading are those of all fits (``record``). Here a record is
laid on even times, its gaps left empty, and what cannot be fitted is refused before any work. A
plane that was not flown is left out: a helmsman who keeps the course moves the rudder by hardly
more than its own reading is off, and a fit takes such a rudder for weak.
"""

import hashlib
import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Final

import numpy as np
from numpy.typing import NDArray

from trainer.analysis.estimate.uncertainty import deviates
from trainer.config.files import ConfigError, raise_problems
from trainer.config.tables import read_table
from trainer.core.kernel import Numbers
from trainer.identify.boat.filter import CHANNEL_NAMES, RecordNumbers
from trainer.identify.boat.vessel import FittedVessel
from trainer.identify.record.columns import BOAT_WORDS, guess_columns, guess_file
from trainer.identify.record.contradictions import (
    ANYWAY_TEXT,
    find_contradiction,
    option_of,
)
from trainer.identify.record.evidence import (
    TURNED_SIGN,
    Change,
    Course,
    compare_channels,
)
from trainer.identify.record.findings import unwrap_heading
from trainer.identify.record.logs import read_log
from trainer.identify.record.measurements import FIN_CHANNELS, Record
from trainer.identify.record.motion_laws import FLOWN_PLANES_RAD, Signal
from trainer.identify.record.sources import (
    BOAT_COLUMNS,
    Column,
    check_unit,
    own_columns,
    own_readings,
    read_record,
)
from trainer.io.paths import RECORDING_SUFFIX
from trainer.session.past.header import open_whole_recording, plan_of
from trainer.units import DEGREE

# the fields of a record by channel of the filter
RECORD_FIELDS: Final = {
    **{name: name for name in CHANNEL_NAMES},
    "p": "roll_rate",
    "q": "pitch_rate",
    "r": "yaw_rate",
}
INPUT_FIELDS: Final = ("rudder", "stern", "bow", "command_speed")  # of Trial.inputs
USUAL_ERRORS: Final = {  # [SI] standard deviation of a reading
    "speed": 0.05,
    "heading": 0.2 * DEGREE,
    "pitch": 0.1 * DEGREE,
    "roll": 0.2 * DEGREE,
    "depth": 0.1,
    "p": 0.05 * DEGREE,
    "q": 0.05 * DEGREE,
    "r": 0.02 * DEGREE,
    "ground_speed": 0.05,
}
MOST_AS_RAD: Final = 0.5 * math.pi * DEGREE  # [rad] degrees that may be radians
COLUMNS_OPTION: Final = "--columns"
NEEDED_FIELDS: Final = ("rudder", "stern", "heading", "pitch", "depth")
INTERVAL_RANGE_S: Final = (0.05, 2.0)  # [s]
MAX_INTERVAL_LENGTHS: Final = 0.25  # [L/U] readings that are rarer tell the wrong boat
MAX_COARSE_LENGTHS: Final = 1.2  # [L/U] the same where a user takes that risk
THINNED_LENGTHS: Final = 0.07  # [L/U] from tick to tick of a recording that is exact
STEP_TOLERANCE: Final = 0.02  # [-] of the interval
MOST_PARTS: Final = 10  # of the usual interval, where readings lie between
MIN_READINGS: Final = 100
MIN_MOVE_RAD: Final = math.radians(2.0)  # [rad] some surface must move by this
SLOWEST_M_S: Final = 0.3  # [m/s] slower, the ahead row does not hold
MAX_SLOW_SHARE: Final = 0.05  # [-] of a record
STANDING_COUNT: Final = 20  # [readings] of one value
ABLE_FACTOR, ABLE_SLACK_DEG = 1.2, 1.0  # of a surface's rate, and of its readings
MIN_DEPTH_DIAMETERS: Final = 2.5  # above, the free surface acts
FLOWN_RUDDER_RAD: Final = math.radians(2.0)  # [rad] rms: less keeps a course
LEVEL_CHANNELS: Final = ("heading", "roll", "p", "r")
UPRIGHT_CHANNELS: Final = ("pitch", "depth", "q")
# rudder and stern planes of four fins; then what all have alike, and what they have in turn
FIN_MIX: Final = 0.25 * np.array([[1, 1, -1, -1], [-1, 1, 1, -1], [1, 1, 1, 1], [1, -1, 1, -1]])
MAX_FIN_RESIDUE_RAD: Final = math.radians(0.25)  # [rad] of these: one fin off by a degree
STEPS_PER_INTERVAL: Final = 2.0  # of Runge and Kutta in a second of BB2 at 10 kn


@dataclass(frozen=True)
class Instruments:
    """What a user says of what wrote a record, beyond its headings."""

    columns: Mapping[str, Column] = field(default_factory=dict)  # by channel; unit None: as headed
    biases: Mapping[str, float] = field(default_factory=dict)  # [SI] deviations of slow states
    gauge_x: float = 0.0  # [m] of the depth gauge ahead of the origin
    late: float = 0.0  # [s] by which surfaces and revolutions are logged late
    coarse: bool = False  # readings that are too rare are taken all the same
    anyway: bool = False  # likewise, signs that the record contradicts
    still: frozenset[str] = frozenset()  # surfaces without a column, which stood at zero


USUAL_INSTRUMENTS: Final = Instruments()


@dataclass(frozen=True, eq=False)
class Trial:
    """A record at even times: readings (n, 9) as filter.CHANNELS, NaN where there is none."""

    source: str
    digest: str  # SHA-256 of the file
    interval: float  # [s]
    steps: int  # of Runge and Kutta from reading to reading
    readings: Numbers
    inputs: Numbers  # (n, 4) rudder, stern, bow [rad], command speed [m/s]
    columns: tuple[str, ...]  # which column was taken for what, in words
    told: tuple[str, ...]
    biases: Mapping[str, float] = field(default_factory=dict)  # of Instruments
    cures: Mapping[tuple[str, float], str] = field(default_factory=dict)  # by field and factor

    def scaled(self, names: Sequence[str], factor: float) -> "Trial":
        """Return the trial with a factor on fields of its record."""
        read = [RECORD_FIELDS[name] for name in CHANNEL_NAMES]
        ways = [np.where(np.isin(one, names), factor, 1.0) for one in (read, INPUT_FIELDS)]
        return replace(self, readings=self.readings * ways[0], inputs=self.inputs * ways[1])

    def hastened(self, seconds: float) -> "Trial":
        """Return the trial with inputs that stand earlier; the last one stands to the end."""
        t = self.interval * np.arange(len(self.inputs))
        moved = [np.interp(t + seconds, t, one) for one in self.inputs.T]
        return replace(self, inputs=np.column_stack(moved))

    @property
    def numbers(self) -> RecordNumbers:
        """Return the record as kernels take it."""
        return RecordNumbers(self.readings, self.inputs, self.interval, self.steps)

    @property
    def count(self) -> int:
        """Return how many readings there are."""
        return int(np.count_nonzero(np.isfinite(self.readings)))

    def has(self, channel: str) -> bool:
        """Return whether a channel has readings."""
        return bool(np.isfinite(self.readings[:, CHANNEL_NAMES.index(channel)]).any())

    def first(self, channel: str, otherwise: float) -> float:
        """Return the first reading of a channel."""
        values = self.readings[:, CHANNEL_NAMES.index(channel)]
        known = values[np.isfinite(values)]
        return float(known[0]) if known.size else otherwise


def read_trial(
    path: Path, vessel: FittedVessel, instruments: Instruments = USUAL_INSTRUMENTS
) -> Trial:
    """Return a record of a boat. ConfigError with all that forbids its use."""
    columns = _columns(path, instruments.columns)
    record = unwrap_heading(own_readings(_without_repeats(read_record(path, columns))))
    record = join_fins(record)
    problems = [f"{record.source}: {text}" for text in _lacking(record, vessel, instruments)]
    raise_problems(problems)
    if path.suffix == RECORDING_SUFFIX:
        record = _thinned(_as_turned(record, path), vessel)
    if instruments.gauge_x:
        leaning = instruments.gauge_x * np.sin(record.column("pitch"))
        record = replace(record, depth=record.column("depth") + leaning)
    trial = lay_out(record, vessel).hastened(instruments.late)
    if path.suffix == RECORDING_SUFFIX:
        trial = read_by_instruments(trial)
    files = sorted(one for one in path.rglob("*") if one.is_file()) if path.is_dir() else [path]
    digest = hashlib.sha256(b"".join(one.read_bytes() for one in files)).hexdigest()
    words = tuple(f"{one.name} as {key} [{one.unit}]" for key, one in columns.items())
    told = (*trial.told, *_standing(trial), *_coarse(trial, vessel))
    trial = replace(trial, digest=digest, columns=words, told=told, biases=instruments.biases)
    rarest = MAX_COARSE_LENGTHS if instruments.coarse else MAX_INTERVAL_LENGTHS
    found = [*trial_problems(trial, vessel, rarest)]
    exact = path.suffix == RECORDING_SUFFIX
    wrong, refused = ("", False) if exact else find_wrong_units(trial, vessel, columns)
    if refused and not instruments.anyway:
        found.append(f"{wrong}; {ANYWAY_TEXT}")
    elif wrong:
        trial = replace(trial, told=(*trial.told, f"taken as it is: {wrong}"))
    raise_problems([f"{record.source}: {text}" for text in found])
    trial = without_unflown(trial)
    return replace(trial, cures={} if path.suffix == RECORDING_SUFFIX else _cures(trial, columns))


def _cures(trial: Trial, columns: Mapping[str, Column]) -> dict[tuple[str, float], str]:
    """Return options that read channels otherwise: turned, or in radians called degrees."""
    largest = {name: float(np.abs(one.values).max()) for name, one in channels_of(trial).items()}
    turned = {name: Change(name, TURNED_SIGN) for name, most in largest.items() if most > 0.0}
    cures = {(name, -1.0): _said(change, columns) for name, change in turned.items()}
    for name in ("stern", "bow"):
        if (one := columns.get(name)) and one.unit == "deg" and 0.0 < largest[name] < MOST_AS_RAD:
            cures[name, 1.0 / DEGREE] = _said(Change(name, "rad"), columns)
    return cures


def _columns(path: Path, said: Mapping[str, Column]) -> dict[str, Column]:
    """Return where each channel is: as said, as the trainer writes them, or guessed by names."""
    own = own_columns(BOAT_COLUMNS)
    del own["sway"]
    if path.suffix == RECORDING_SUFFIX:
        return own
    if read_log(path):
        return dict(guess_file(path, BOAT_WORDS, said, COLUMNS_OPTION).columns)
    table = read_table(path)
    for channel, one in said.items():
        index = table.index(one.name, channel)
        if not (channel == "t" and table.is_clock(index)):
            check_unit(path, channel, one, table.units[index], COLUMNS_OPTION)
    if all(table.has(own[name].name) for name in ("t", *NEEDED_FIELDS)):
        found = {key: one for key, one in own.items() if table.has(one.name)}
    else:
        return dict(guess_columns(table, BOAT_WORDS, said, COLUMNS_OPTION).columns)
    taken = [one.name for one in said.values()]
    return {**{key: one for key, one in found.items() if one.name not in taken}, **said}


def _without_repeats(record: Record) -> Record:
    """Return the record without rows at the time of the row before."""
    same = np.append(False, np.diff(record.t) == 0.0)
    if not same.any():
        return record
    text = f"{np.count_nonzero(same)} rows repeat the time before them and are left out"
    told = (*record.findings, record.finding("t", text, np.argmax(same)))
    return replace(record.part(~same), findings=told)


def _standing(trial: Trial) -> Iterator[str]:
    """Yield which gauges stand still for long while surfaces move."""
    for name, values in zip(CHANNEL_NAMES, trial.readings.T, strict=True):
        begins = np.append(0, np.flatnonzero(np.diff(values) != 0.0) + 1)
        counts = np.diff(begins, append=len(values))
        at, count = int(begins[np.argmax(counts)]), int(counts.max())
        moved = np.ptp(trial.inputs[at : at + count, :3], axis=0).max()
        if count > STANDING_COUNT and moved > MIN_MOVE_RAD:
            yield (
                f"{name} stands still for {count} readings from {at * trial.interval:g} s on: is "
                "its gauge at its end? then leave these cells empty"
            )


def _coarse(trial: Trial, vessel: FittedVessel) -> Iterator[str]:
    """Yield what readings cost that are rarer than a fit should have."""
    lengths = trial.interval * vessel.speed / vessel.length
    if lengths > MAX_INTERVAL_LENGTHS:
        yield (
            f"a reading each {trial.interval:.3g} s, in which the boat goes {lengths:.2g} of her "
            "lengths: bands of 95 % held 92 % of figures at 0.37, 89 at 0.73, 80 at 1.1 (drawn)"
        )


def join_fins(record: Record) -> Record:
    """Return a record with the four fins of an X-tail joined to rudder and planes.

    Fins are numbered and signed as ``x_plane_mix`` of BB2's file: d1 = dV - dH, d2 = dV + dH,
    d3 = -dV + dH, d4 = -dV - dH. What four angles have besides, no boat does.
    """
    given = [getattr(record, name) for name in FIN_CHANNELS]
    if any(fin is None for fin in given) or record.rudder is not None or record.stern is not None:
        return record
    fins, findings = np.array(given), list(record.findings)
    rudder, stern, alike, crossed = FIN_MIX @ fins
    off = [float(np.nanmean(one)) if np.isfinite(one).any() else 0.0 for one in (alike, crossed)]
    if max(map(abs, off)) > MAX_FIN_RESIDUE_RAD:
        if min(map(abs, off)) > 0.5 * max(map(abs, off)):  # one alone moves both alike
            fin = "fin 1 or 3" if off[0] * off[1] > 0.0 else "fin 2 or 4"
            text = f"{fin} reads {4.0 * off[0] / DEGREE:+.2g} deg off, as the four together tell"
        else:
            text = "four fins do not fit together: are they numbered and signed as x_plane_mix?"
        findings.append(record.finding(FIN_CHANNELS[0], text))
    return replace(record, rudder=rudder, stern=stern, findings=tuple(findings))


def _lacking(record: Record, vessel: FittedVessel, said: Instruments) -> Iterator[str]:
    """Yield which channels are lacking, without which no boat can be fitted."""
    if record.bow is None and "bow" not in said.still and vessel.file.surfaces.bow_plane_limit_deg:
        yield (
            "this boat has bow planes, the record has none: --still bow if they stood at zero, or "
            f"say where they are, {COLUMNS_OPTION} bow=..."
        )
    for name in NEEDED_FIELDS:
        if getattr(record, name) is None and name not in said.still:
            fins = ", or give all four fins of an X-tail, fin 1 to fin 4"
            words = " or ".join(BOAT_WORDS[name][:2]) + fins * (name in ("rudder", "stern"))
            yield f"no column is taken for {name}: call it {words}"
    if record.revolutions is None and record.command_speed is None:
        yield "no column is taken for the revolutions: call it rpm, rps or u_c"


def _as_turned(record: Record, path: Path) -> Record:
    """Return a recording with revolutions as its own boat has them: they are what is measured."""
    with open_whole_recording(path) as recording:
        turns = plan_of(recording.header()).file.propulsion.rps_per_mps
    return replace(record, revolutions=turns * record.column("command_speed"), command_speed=None)


def _thinned(record: Record, vessel: FittedVessel) -> Record:
    """Return an exact recording with ticks no closer than a fit needs."""
    return record.part(slice(None, None, every_tick(vessel, record.interval)))


def every_tick(vessel: FittedVessel, step: float) -> int:
    """Return of how many exact ticks of ``step`` [s] a fit needs one."""
    return max(1, round(THINNED_LENGTHS * vessel.length / vessel.speed / step))


def read_by_instruments(trial: Trial, before: int = 0) -> Trial:
    """Return an exact recording as usual instruments would have read it.

    ``before`` readings have been read of it already: the errors go on from there.
    """
    sizes = np.array([USUAL_ERRORS[name] for name in CHANNEL_NAMES])
    rows, columns = trial.readings.shape
    errors = deviates(1, (before + rows) * columns).reshape(-1, columns)[before:]
    told = (*trial.told, "exact: the errors of usual instruments are added")
    return replace(trial, readings=trial.readings + sizes * errors, told=told)


def lay_out(record: Record, vessel: FittedVessel) -> Trial:
    """Return a record on even times; ConfigError where these would move readings too far."""
    at, interval, moved = _even_rows(record, vessel)
    readings, told = (
        np.full((at[-1] + 1, len(CHANNEL_NAMES)), np.nan),
        list(map(str, record.findings)),
    )
    for i, name in enumerate(CHANNEL_NAMES):
        values = getattr(record, RECORD_FIELDS[name])
        if values is not None:
            known = np.isfinite(values)
            readings[at[known], i] = values[known]
    told += [moved] if moved else []
    if not moved and at[-1] + 1 > len(record.t):
        told.append(f"{at[-1] + 1 - len(record.t)} rows are lacking: gaps, left empty")
    command = record.command_speed
    if command is None:
        command = record.column("revolutions") / vessel.file.propulsion.rps_per_mps
    surfaces = [record.rudder, record.stern, record.bow]
    inputs = [_filled(at, values) for values in (*surfaces, command)]
    parts = steps_between(interval, vessel)
    given = np.column_stack(inputs)
    return Trial(record.source, "", interval, parts, readings, given, (), tuple(told))


def _even_rows(record: Record, vessel: FittedVessel) -> tuple[NDArray[np.int64], float, str]:
    """Return the row of each sample on even times, their interval [s], and what to tell of them.

    Where the record's own times are uneven, the coarsest are taken on which no reading moves by
    more than 2 % of the time in which the boat goes her length.
    """
    interval = record.interval
    steps = np.diff(record.t) / interval
    uneven = np.abs(steps - np.maximum(np.round(steps), 1.0)) > STEP_TOLERANCE
    if not uneven.any():
        return np.append(0, np.cumsum(np.round(steps).astype(int))), interval, ""
    since, room = record.t - record.t[0], STEP_TOLERANCE * vessel.length / vessel.speed
    for parts in range(1, MOST_PARTS + 1):
        even = interval / parts
        at = np.round(since / even).astype(int)
        off = float(np.abs(since - at * even).max())
        if off <= room:
            return at, even, f"laid on even times of {even:.3g} s: moved by at most {off:.2g} s"
    index = int(np.argmax(uneven))
    raise ConfigError(
        f"{record.source}: row {record.row(index + 1)}: {steps[index] * interval:.4g} s after "
        f"the row before, and {interval:.4g} s elsewhere: needs even times, within {room:.2g} s"
    )


def steps_between(interval: float, vessel: FittedVessel) -> int:
    """Return how many steps of Runge and Kutta a boat needs in an interval [s]."""
    return max(1, round(STEPS_PER_INTERVAL * interval * vessel.pace))


def _filled(at: NDArray[np.int64], values: Numbers | None) -> Numbers:
    """Return an input at all times, straight between its readings; zero where there is none."""
    if values is None:
        return np.zeros(at[-1] + 1)
    known = np.isfinite(values)
    if not known.any():
        return np.zeros(at[-1] + 1)
    return np.interp(np.arange(at[-1] + 1), at[known], values[known])


def trial_problems(
    trial: Trial, vessel: FittedVessel, rarest: float = MAX_INTERVAL_LENGTHS
) -> Iterator[str]:
    """Yield why a record cannot be fitted, each with what to do; ``rarest`` [L/U]."""
    span = vessel.length / vessel.speed
    least, usual = INTERVAL_RANGE_S
    most = rarest * span if rarest > MAX_INTERVAL_LENGTHS else min(usual, rarest * span)
    if not least <= trial.interval <= most:
        yield (
            f"a reading each {trial.interval:.3g} s: needs {least:g} to {most:.3g} s, {rarest:g} "
            "of the time in which the boat goes its own length"
            + "; --coarse takes up to 1.2"
            * (rarest < MAX_COARSE_LENGTHS)
        )
    if len(trial.readings) < MIN_READINGS:
        yield f"{len(trial.readings)} rows: needs {MIN_READINGS} or more"
    moves = np.ptp(trial.inputs[:, :3], axis=0)
    if moves.max() < MIN_MOVE_RAD:
        yield "no surface moves by 2 deg: are these radians? only what moves is learned"
    fastest = np.abs(np.diff(trial.inputs[:, :3], axis=0)).max(axis=0, initial=0.0) / DEGREE
    able = vessel.file.surfaces.rate_deg_s
    for name, change in zip(("rudder", "stern", "bow"), fastest, strict=True):
        if change > ABLE_FACTOR * able * trial.interval + ABLE_SLACK_DEG:
            yield (
                f"{name} moves {change:.3g} deg in {trial.interval:.3g} s, and rate_deg_s of the "
                f"prior is {able:g}: an order, or a wild reading? give angles that stood, empty "
                "where none was read"
            )
    speed = trial.readings[:, 0] if trial.has("speed") else trial.inputs[:, 3]
    slow = float(np.mean(speed[np.isfinite(speed)] < SLOWEST_M_S))
    if slow > MAX_SLOW_SHARE:
        yield f"slower than {SLOWEST_M_S:g} m/s or astern in {slow:.0%}: fits are of boats ahead"
    depth, least_m = trial.readings[:, 4], least_depth(vessel)
    if least_m is not None and float(np.nanmin(depth)) < least_m:
        yield (
            f"{np.nanmin(depth):.3g} m deep: needs {least_m:.3g} m, "
            f"{MIN_DEPTH_DIAMETERS:g} breadths of the hull, because the surface is not in the model"
        )


def least_depth(vessel: FittedVessel) -> float | None:
    """Return the depth [m] below which no surface acts, None where it is unknown."""
    width = vessel.file.hull.diameter or vessel.file.hull.beam
    return None if width is None else MIN_DEPTH_DIAMETERS * width


def channels_of(trial: Trial) -> dict[str, Signal]:
    """Return the channels of a trial, each with its own readings."""
    t = trial.interval * np.arange(len(trial.readings))
    columns = {
        **{RECORD_FIELDS[name]: trial.readings[:, i] for i, name in enumerate(CHANNEL_NAMES)},
        **dict(zip(INPUT_FIELDS, trial.inputs.T, strict=True)),
    }
    known = {name: np.isfinite(values) for name, values in columns.items()}
    return {
        name: Signal(t[known[name]], values[known[name]])
        for name, values in columns.items()
        if np.count_nonzero(known[name]) > 1
    }


def find_wrong_units(
    trial: Trial, vessel: FittedVessel, columns: Mapping[str, Column]
) -> tuple[str, bool]:
    """Return what the record's channels contradict, with cures, and whether that is refused."""
    units = {name: one.unit or "" for name, one in columns.items()}
    limit = vessel.file.surfaces.rudder_limit_deg * DEGREE
    ship = Course(vessel.length, vessel.speed, limit)
    found = find_contradiction(compare_channels(channels_of(trial), ship, units), units)
    if found is None:
        return "", False
    return found.text(lambda change: _said(change, columns)), found.refused


def _said(change: Change, columns: Mapping[str, Column]) -> str:
    """Return the option that reads a channel otherwise."""
    one = columns.get(change.channel)
    if one is None or one.unit is None:
        return f"turn the sign of {change.channel}"
    return f"say {option_of(COLUMNS_OPTION, change, one)}"


def without_unflown(trial: Trial) -> Trial:
    """Return the record without the channels of a plane that was kept, not flown."""
    rudder, stern, bow = np.std(trial.inputs[:, :3], axis=0)
    left_out: tuple[str, ...] = ()
    told = list(trial.told)
    if rudder < FLOWN_RUDDER_RAD:
        left_out += LEVEL_CHANNELS
        told.append("course only kept: nothing learned of turning")
    if max(stern, bow) < FLOWN_PLANES_RAD and rudder < FLOWN_RUDDER_RAD:
        left_out += UPRIGHT_CHANNELS
        told.append("depth only kept: nothing learned of rising and diving")
    readings = trial.readings.copy()
    for name in left_out:
        readings[:, CHANNEL_NAMES.index(name)] = np.nan
    return replace(trial, readings=readings, told=tuple(told))
