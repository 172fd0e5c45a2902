"""Published figures beside ours, in the manner of ASME V&V 20 (2009).

S is the simulation, D the published figure, E = S - D. The uncertainty of a comparison is that of
the step (three of them), of the boat's coefficients and masses (``uncertainty``, stored), and of
the figure: u_val^2 = u_num^2 + u_input^2 + u_D^2, each one standard deviation. Manoeuvres are
flown; motion in regular waves is that of the linear equations, which have no step.
"""

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import product
from typing import Final

from trainer.analysis.guide.programme import FlightTable, Task
from trainer.analysis.guide.trials import (
    DATA_KINDS,
    FITTED,
    HELD_OUT,
    MEASURED_KINDS,
    Figure,
    HeadWaves,
    Published,
    Trial,
)
from trainer.analysis.guide.verdicts import MODEL_ERRORS, Validity, judge_error, step_uncertainty
from trainer.analysis.manoeuvres.catalogue import find_manoeuvre, manoeuvre_parameters
from trainer.analysis.manoeuvres.flight import Manoeuvre
from trainer.analysis.manoeuvres.submarine import Rig
from trainer.boat.assemble import Method
from trainer.boat.boat import Boat
from trainer.boat.linear import head_wave_response, head_waves
from trainer.config.boat.vessel import VesselFile
from trainer.units import KNOT

STEP_MULTIPLES: Final = (1.0, 2.0, 4.0)  # of the step of the trials, the finest first
WAVES_WORDS: Final = (
    "Linear, planes fixed, the boat's deep water; the waves push on seven strips of the hull, and "
    "its lift feels the water's own vertical speed. Without that flow ours are"
)
COUNTED_VERDICTS: Final = {
    "model error": MODEL_ERRORS,
    **{one.value: (one,) for one in (Validity.UNCERTAIN, Validity.NOISE, Validity.NOT_JUDGED)},
}
COUNTED_USES: Final = {  # by name: use, and whether it was measured
    f"{HELD_OUT} and measured": [(HELD_OUT, True)],
    f"{HELD_OUT}, computed by others": [(HELD_OUT, False)],
    FITTED: [(FITTED, True), (FITTED, False)],
    "all": [*product((HELD_OUT, FITTED), (True, False))],
}
GUIDE_ALONE_KEYS: Final = ("keep", "share")
GUIDE_COMMAND: Final = "trainer boat guide {boat} --json"

InputTable = Mapping[tuple[str, str], float]  # u_input by title and quantity


@dataclass(frozen=True)
class FigureRow:
    """One published figure and ours, in the unit of its source."""

    figure: Figure
    ours: float | None  # S
    u_num: float
    order: float | None  # observed; None: steps do not converge, or there are none
    u_input: float | None  # None: not flown

    @property
    def error(self) -> float | None:
        """Return E."""
        return None if self.ours is None else self.ours - self.figure.value

    @property
    def u_val(self) -> float | None:
        """Return the uncertainty of the comparison."""
        if self.u_input is None:
            return None
        return math.sqrt(self.u_num**2 + self.u_input**2 + self.figure.u**2)

    @property
    def percent(self) -> float:
        """Return the size of the error in percent of the published value.

        100 where ours has none, 0 where that value is 0.
        """
        if self.error is None:
            return 100.0
        return 100.0 * abs(self.error / self.figure.value) if self.figure.value else 0.0

    @property
    def verdict(self) -> Validity:
        """Return what the comparison shows."""
        return judge_error(self.error, self.u_val, self.figure.value)


@dataclass(frozen=True)
class TrialComparison:
    """The figures of one manoeuvre, or of one sea, beside ours."""

    title: str
    source: str  # what was done, where it is, how it was read, and what differs
    command: str  # that flies ours
    measured: bool  # not computed
    rows: tuple[FigureRow, ...]


def validation_tasks(file: VesselFile, published: Published) -> Iterator[Task]:
    """Yield the flights of all figures, by three steps."""
    for trial in published.trials:
        yield from (trial.task(file, each) for each in STEP_MULTIPLES)


def compare_figures(
    file: VesselFile, published: Published, flown: FlightTable, inputs: InputTable
) -> tuple[TrialComparison, ...]:
    """Return all figures beside ours. ConfigError for one that is none of its manoeuvre's."""
    trials = [_compare_trial(file, published, one, flown, inputs) for one in published.trials]
    return (*trials, *(_compare_waves(file, one, inputs) for one in published.waves))


def _compare_trial(
    file: VesselFile, published: Published, trial: Trial, flown: FlightTable, inputs: InputTable
) -> TrialComparison:
    """Return the figures of one manoeuvre beside ours."""
    flights = [flown[trial.task(file, each)] for each in STEP_MULTIPLES]
    readings = [trial.read_flight(published, flight) for flight in flights]
    command = flight_command(file, trial.name, trial.task(file))
    problem = flights[0] if isinstance(flights[0], str) else flights[0].lost
    return compare_readings(trial, readings, command, problem, inputs)


def _compare_waves(file: VesselFile, waves: HeadWaves, inputs: InputTable) -> TrialComparison:
    """Return published motion in waves beside ours, with what the flow makes of it."""
    command = GUIDE_COMMAND.format(boat=file.path.stem)
    ours, plain = (wave_values(file, waves, speed) for speed in (waves.heading.speed_m_s, 0.0))
    if isinstance(ours, str) or isinstance(plain, str):
        none = [None] * len(waves.results)
        return compare_readings(waves, [none], command, str(ours), inputs)
    names = [each.quantity for each in waves.results]
    told = ", ".join(f"{name} {x:.3f}" for name, x in zip(names, plain, strict=True))
    return compare_readings(waves, [ours], command, f"{WAVES_WORDS} {told}", inputs)


def compare_readings(
    one: Trial | HeadWaves,
    readings: Sequence[Sequence[float | None]],
    command: str,
    remark: str,
    inputs: InputTable,
) -> TrialComparison:
    """Return published figures beside ours, read off at each step."""
    heading, rows = one.heading, []
    for figure, values in zip(one.results, zip(*readings, strict=True), strict=True):
        u_num, order = _by_step([value for value in values if value is not None])
        u_input = inputs.get((heading.title, figure.quantity))
        rows.append(FigureRow(figure, values[0], u_num, order, u_input))
    read = f"{heading.read[:1].upper()}{heading.read[1:]}"
    source = (heading.source, f"Figure: {heading.figure}", read, heading.note, remark)
    told = ". ".join(filter(None, (DATA_KINDS[heading.data].capitalize(), *source)))
    measured = heading.data in MEASURED_KINDS
    return TrialComparison(heading.title, told, command, measured, tuple(rows))


def _by_step(steps: Sequence[float]) -> tuple[float, float | None]:
    """Return uncertainty and order by three steps; by fewer, how far apart the results are."""
    if len(steps) == len(STEP_MULTIPLES):
        return step_uncertainty(steps)
    return (max(steps) - min(steps) if steps else 0.0), None


def manoeuvre_command(stem: str, name: str, manoeuvre: Manoeuvre, speed: float) -> str:
    """Return the command that flies a manoeuvre from a speed [m/s], by any vessel."""
    words = [f"trainer boat manoeuvre {name} {stem}"]
    words += [f"--speed {speed / KNOT:.5g}"] if speed else []
    for key, value in manoeuvre_parameters(manoeuvre).items():
        words.append(f"--{value}" if key == "direction" else f"--{key.replace('_', '-')} {value}")
    return " ".join(words)


def flight_command(file: VesselFile, name: str, task: Task) -> str:
    """Return the command that flies a task by itself as the guide does.

    What a manoeuvre keeps, and an engine within its limits, are no options: the guide has these.
    """
    usual = find_manoeuvre(name)
    if task.rig.engine != Rig().engine or any(
        getattr(task.manoeuvre, key, None) != getattr(usual, key, None) for key in GUIDE_ALONE_KEYS
    ):
        return GUIDE_COMMAND.format(boat=file.path.stem)
    words = [manoeuvre_command(file.path.stem, name, task.manoeuvre, task.speed)]
    words += [] if task.rig.depth is None else [f"--depth {task.rig.depth:g}"]
    method = task.method
    words.append(f"--rates {method.rates} --integrator {method.integrator} --step {method.step:g}")
    return " ".join(words)


def wave_values(file: VesselFile, waves: HeadWaves, felt: float) -> list[float] | str:
    """Return our heave [-] and pitch [deg] by depth, or why there are none.

    The hull's lift feels the water's own motion at the speed ``felt`` [m/s]; 0 leaves it out.
    """
    heading = waves.heading
    boat = Boat(file, Method("full", "exact", "exact", "rk4", file.run.step_s))
    if not boat.trimmed(heading.speed_m_s):
        return f"no straight level flight at {heading.speed_m_s:g} m/s"
    omega = 2.0 * math.pi / heading.period_s
    values = []
    for depth in heading.depth_m:
        pushed = head_waves(boat, omega, depth, felt)
        heave, pitch = head_wave_response(boat, pushed, omega)
        values += [heave, math.degrees(0.5 * heading.height_m * pitch)]
    return values


def ranked_rows(
    comparisons: Sequence[TrialComparison],
) -> list[tuple[TrialComparison, FigureRow]]:
    """Return all rows, the largest error first; those below the noise come last."""
    pairs = [(one, row) for one in comparisons for row in one.rows]
    return sorted(pairs, key=lambda pair: (pair[1].verdict is Validity.NOISE, -pair[1].percent))


def count_rows(comparisons: Sequence[TrialComparison]) -> list[tuple[str, ...]]:
    """Return how many figures have each verdict, by use and in all.

    What is held out and was measured stands apart, because that alone is evidence.
    """
    rows = [(row.figure.use, one.measured, row.verdict) for one in comparisons for row in one.rows]
    counts = []
    for name, uses in COUNTED_USES.items():
        verdicts = [verdict for *use, verdict in rows if tuple(use) in uses]
        numbers = (sum(map(verdicts.count, each)) for each in COUNTED_VERDICTS.values())
        counts.append((name, str(len(verdicts)), *map(str, numbers)))
    return counts


def count_lines(comparisons: Sequence[TrialComparison]) -> Iterator[str]:
    """Yield the same in words, without those of which there are none."""
    for kind, total, *numbers in count_rows(comparisons):
        named = zip(COUNTED_VERDICTS, numbers, strict=True)
        shares = [f"{count} {name}" for name, count in named if count != "0"]
        yield f"{kind}: {', '.join([total, *shares])}"
