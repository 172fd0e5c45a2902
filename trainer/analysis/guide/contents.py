"""The guide's contents: everything flown, judged and computed for one boat, and what moved.

``cli/workshop/guide`` asks for it; ``page`` shows it. A leg is one manoeuvre at one speed, flown by
every equation set. Each flight that several chapters need is flown once, because flights are what a
guide waits for.

Transport delays are those from order to control, to motion, to a screen. Orders are given anywhere
within a tick and act on the next one, so ticks are counted, and no clock is needed: delays in
seconds follow from the step. A screen adds its time from picture to picture; ``trainer dev bench
--latency`` measures an order's way to a page.

``trainer boat guide --baseline`` compares with an earlier guide of the same boat, so that a change
of the boat or of the program shows in each number that it moved.
"""

import hashlib
import json
import platform
import re
import sys
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from importlib import metadata
from pathlib import Path
from typing import Any, Final

from trainer import __version__
from trainer.analysis.check import round_speeds
from trainer.analysis.guide import findings, reasons
from trainer.analysis.guide.findings import GuideFinding, StepRun
from trainer.analysis.guide.programme import (
    SET_METHODS,
    FlightTable,
    Leg,
    Task,
    fly_all,
    own_method,
)
from trainer.analysis.guide.trials import Published, load_published, numbers_digest, trials_path
from trainer.analysis.guide.uncertainty import SpreadTable, load_spreads
from trainer.analysis.guide.validation import (
    TrialComparison,
    compare_figures,
    validation_tasks,
)
from trainer.analysis.guide.verdicts import (
    BEYOND_TOLERANCE,
    NOT_DETERMINED,
    NOT_JUDGED,
    WITHIN_TOLERANCE,
    Judgement,
    judge,
    keep_checks,
    passes_all,
    set_apart,
    verdict_account,
)
from trainer.analysis.manoeuvres.catalogue import ParameterValues, manoeuvre_parameters
from trainer.analysis.manoeuvres.submarine import BOAT_COLUMNS, Submarine
from trainer.analysis.manoeuvres.vehicle import LostError
from trainer.analysis.programs import characteristic, neutral, thrust
from trainer.boat.assemble import Method
from trainer.config.boat.vessel import VesselFile
from trainer.config.files import ConfigError, no_constant, quote
from trainer.core.digest import core_digest
from trainer.units import KNOT

SHEET_STEPS_S: Final = (0.5, 1.0)
SCREEN_PERIODS_S: Final = {"terminal": 0.1, "browser": 0.05}  # from picture to picture, at most
WATCHED_CONTROLS: Final = {  # the control's own column, and that of the motion
    "rudder": ("delta_r", "r"),
    "planes": ("delta_s", "q"),
    "engine": ("u_c", "u"),
}
MAX_TICKS: Final = 60
LEAST_MOVE: Final = 1e-9  # [SI] of a number that was still
REDUCED_SETS: Final = ("modified", "basic")  # sets judged by the full one
VERDICT_SET: Final = "modified"  # the one that runs, on which the guide's verdict rests
NAMED_LIBRARIES: Final = ("numpy", "numba")
EMBEDDED_GUIDE: Final = re.compile(
    r'<script type="application/json" id="guide">(.*?)</script>', re.DOTALL
)
SAME_NUMBER_RATIO: Final = 1e-6  # [-] relative difference that is none
TINY_NUMBER: Final = 1e-12  # [SI] a change that is rounding about zero, where no ratio can tell
MAX_GUIDE_BYTES: Final = 50_000_000  # [byte] of an earlier guide


@dataclass(frozen=True)
class DelaySheet:
    """The ticks from one order until something moves; None: not in MAX_TICKS."""

    control: str
    step_s: float
    control_ticks: int | None
    motion_ticks: int | None
    problem: str  # why it could not be flown

    def mean_s(self, ticks: int | None, screen: str = "") -> float | None:
        """Return the mean delay [s] until it moves, or is seen to on a screen.

        An order waits half a tick in the mean, a screen half its time from picture to picture.
        """
        if ticks is None:
            return None
        return (ticks - 0.5) * self.step_s + 0.5 * SCREEN_PERIODS_S.get(screen, 0.0)

    def most_s(self, ticks: int | None, screen: str) -> float | None:
        """Return the longest delay [s] until it is seen on a screen."""
        return None if ticks is None else ticks * self.step_s + SCREEN_PERIODS_S[screen]


def measure_delays(file: VesselFile) -> tuple[DelaySheet, ...]:
    """Return the delays of a boat's controls by its own set, at each step."""
    return tuple(
        _measure(file, name, step)
        for step in dict.fromkeys((*SHEET_STEPS_S, file.run.step_s))
        for name in WATCHED_CONTROLS
    )


def _measure(file: VesselFile, control: str, step: float) -> DelaySheet:
    """Return the ticks from one order to its effects, beside a boat without the order."""
    own = own_method(file, file.own_equations)
    method = Method(own.equations, own.rates, own.trig, own.integrator, step)
    boats = [Submarine(file, method) for _ in range(2)]
    indices = [BOAT_COLUMNS.index(name) for name in WATCHED_CONTROLS[control]]
    ticks, problem = dict[int, int](), ""
    try:
        for boat in boats:
            boat.start(file.run.start_speed_kn * KNOT)
        boats[1].order(control, boats[1].controls[control].low)
        for tick in range(1, MAX_TICKS + 1):
            for boat in boats:
                boat.advance()
            still, moved = (boat.observe() for boat in boats)
            for index in indices:
                if abs(moved[index] - still[index]) > LEAST_MOVE:
                    ticks.setdefault(index, tick)
            if len(ticks) == len(indices):
                break
    except (ConfigError, LostError) as error:
        problem = str(error)
    return DelaySheet(control, step, ticks.get(indices[0]), ticks.get(indices[1]), problem)


@dataclass(frozen=True)
class LegSheet:
    """One leg with the judgements of both reduced sets."""

    title: str
    manoeuvre: str
    parameters: ParameterValues  # [deg], [s] and [kn]
    problems: dict[str, str]  # why there is no flight, by equation set
    judgements: dict[str, tuple[Judgement, ...]]  # by reduced set

    def counted(self, equations: str, verdict: str) -> int:
        """Return how many of a set's numbers have that verdict."""
        return sum(one.verdict == verdict for one in self.judgements.get(equations, ()))

    def passed(self, equations: str) -> bool | None:
        """Return whether nothing judged is beyond tolerance; None: nothing is judged."""
        if self.problems.get(equations) and not self.problems.get("full"):
            return False
        beyond = self.counted(equations, BEYOND_TOLERANCE)
        if not beyond and not self.counted(equations, WITHIN_TOLERANCE):
            return None
        return not beyond


@dataclass(frozen=True)
class Guide:
    """All that the guide says about a boat."""

    vessel: str
    made: str  # time stamp
    step_s: float
    versions: dict[str, str]
    checksums: dict[str, str]  # sha256 of what it was made from
    sheets: tuple[LegSheet, ...]
    findings: tuple[GuideFinding, ...]
    steps: tuple[StepRun, ...]
    drops: tuple[reasons.DropEffect, ...]
    trials: tuple[TrialComparison, ...]
    doubts: tuple[str, ...]  # why published results are not judged, or not judged rightly
    delays: tuple[DelaySheet, ...]
    neutral: neutral.NeutralReport
    modes: characteristic.ModesReport
    thrust: thrust.ThrustReport
    passed: bool  # something is judged, and nothing beyond tolerance

    @property
    def conclusion(self) -> str:
        """Return the verdict of the whole guide in words."""
        if all(sheet.passed(VERDICT_SET) is None for sheet in self.sheets):
            return "Nothing was judged"
        return "Within tolerance" if self.passed else "Out of tolerance"


@dataclass(frozen=True)
class GuideContents:
    """A guide, and the flights of its charts."""

    file: VesselFile
    guide: Guide
    legs: tuple[Leg, ...]
    flown: FlightTable
    published: Published | None
    spreads: SpreadTable | None


def stand_alone(legs: Sequence[Leg]) -> bool:
    """Return whether legs have checks of their own, and so a guide without studies."""
    return any(leg.checks for leg in legs)


def guide_tasks(file: VesselFile, legs: Sequence[Leg]) -> tuple[Task, ...]:
    """Return every flight that a guide of these legs needs, each once."""
    published = _published(file)
    own = tuple(leg.task(file, equations) for leg in legs for equations in SET_METHODS)
    if stand_alone(legs):
        return own
    wanted = (
        *own,
        *findings.step_tasks(file),
        *findings.finding_tasks(file),
        *reasons.drop_tasks(file),
        *(validation_tasks(file, published) if published else ()),
    )
    return tuple(dict.fromkeys(wanted))


def write_guide(
    file: VesselFile, legs: Sequence[Leg], made: str, cores: int, step: Callable[[], None]
) -> GuideContents:
    """Return the guide of a boat in these legs; ``step`` is called after each flight."""
    flown = fly_all(file.path, guide_tasks(file, legs), cores, step)
    return assemble_guide(file, legs, made, flown)


def assemble_guide(
    file: VesselFile, legs: Sequence[Leg], made: str, flown: FlightTable
) -> GuideContents:
    """Return the guide from its flights."""
    sheets = tuple(_sheet(file, leg, flown) for leg in legs)
    alone = stand_alone(legs)
    steps = () if alone else findings.step_study(file, flown)
    published = None if alone else _published(file)
    spreads = load_spreads(file, published) if published else None
    inputs = spreads.by_figure() if spreads else {}
    made_from = {file.path.name: file.text}
    if published:
        made_from[f"{published.path.stem} (published results)"] = published.text
    if spreads:
        made_from[f"{spreads.file} (u_input)"] = spreads.text
    checksums = {
        name: hashlib.sha256(text.encode()).hexdigest() for name, text in made_from.items()
    }
    speeds = round_speeds(*file.run.speed_range_kn)
    guide = Guide(
        vessel=file.name,
        made=made,
        step_s=file.run.step_s,
        versions={
            "trainer": __version__,
            "core": core_digest(),
            "python": sys.version.split()[0],
            **{name: metadata.version(name) for name in NAMED_LIBRARIES},
            "machine": platform.machine(),
        },
        checksums=checksums,
        sheets=sheets,
        findings=() if alone else findings.study_findings(file, flown, steps),
        steps=steps,
        drops=() if alone else reasons.drop_study(file, flown),
        trials=compare_figures(file, published, flown, inputs) if published else (),
        doubts=tuple(_doubts(file, published, spreads)) if published else (),
        delays=() if alone else measure_delays(file),
        neutral=neutral.report_neutral(file, speeds),
        modes=characteristic.report_modes(file, speeds, characteristic.MeanMotions()),
        thrust=thrust.survey_thrust(file, (0.0, *speeds), thrust.command_speeds(file)),
        passed=passes_all([sheet.passed(VERDICT_SET) for sheet in sheets]),
    )
    return GuideContents(file, guide, tuple(legs), flown, published, spreads)


def _published(file: VesselFile) -> Published | None:
    """Return the published figures of a boat; ConfigError if their file is wrong."""
    path = trials_path(file)
    return load_published(path) if path else None


def _doubts(file: VesselFile, published: Published, spreads: SpreadTable | None) -> Iterator[str]:
    """Yield in words what is not of this boat, and what mends it."""
    again = f"trainer boat guide {file.path.stem} --uncertainty"
    if spreads is None and published.figures:
        yield f"No table of u_input: {again} flies it"
    if spreads and spreads.stale:
        yield f"{spreads.stale}: {again} flies it again"
    now = numbers_digest(file)
    if published.provenance.digest != now:
        yield (
            f"Fitted and held out were told of {published.provenance.digest}, the boat is {now}: "
            f"go through {published.file} and date it"
        )


def _sheet(file: VesselFile, leg: Leg, flown: FlightTable) -> LegSheet:
    """Return one leg judged."""
    flights = {each: flown[leg.task(file, each)] for each in SET_METHODS}
    full = flights["full"]
    judgements = {}
    for equations in REDUCED_SETS:
        other = flights[equations]
        if not isinstance(full, str) and not isinstance(other, str):
            found = judge(leg.manoeuvre, full, other)
            kept = keep_checks(found, leg.checks) if leg.checks else found
            if equations == VERDICT_SET:
                kept = set_apart(file, leg, full, kept)
            judgements[equations] = kept
    problems = {each: flight for each, flight in flights.items() if isinstance(flight, str)}
    return LegSheet(leg.title, leg.name, manoeuvre_parameters(leg.manoeuvre), problems, judgements)


def tally_set(guide: Guide, equations: str) -> dict[str, Any]:
    """Return how many numbers and manoeuvres of a reduced set are within and beyond."""
    sheets = guide.sheets
    return {
        "within": sum(sheet.counted(equations, WITHIN_TOLERANCE) for sheet in sheets),
        "beyond": sum(sheet.counted(equations, BEYOND_TOLERANCE) for sheet in sheets),
        "shown": sum(
            sheet.counted(equations, verdict)
            for sheet in sheets
            for verdict in (NOT_JUDGED, NOT_DETERMINED)
        ),
        "manoeuvres": verdict_account([sheet.passed(equations) for sheet in sheets]),
    }


@dataclass(frozen=True)
class GuideMove:
    """One number or verdict that is not what it was."""

    what: str
    before: float | str | None  # None: it was not there
    after: float | str | None

    @property
    def percent(self) -> float | None:
        """Return the change [%] of what it was; None if that cannot be told."""
        if isinstance(self.before, float) and isinstance(self.after, float) and self.before:
            return 100.0 * (self.after - self.before) / abs(self.before)
        return None


def load_earlier(path: Path, vessel: str) -> Mapping[str, Any]:
    """Return an earlier guide, JSON or HTML; ConfigError if it is none of that boat."""
    try:
        if path.stat().st_size > MAX_GUIDE_BYTES:
            raise ConfigError(f"--baseline {path}: is larger than any guide; not read")
        text = path.read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError) as error:
        reason = getattr(error, "strerror", None) or "is not UTF-8 text"
        raise ConfigError(f"--baseline {path}: {reason}") from None
    embedded = EMBEDDED_GUIDE.search(text)
    try:
        written = embedded[1].replace("<\\/", "</") if embedded else text
        guide = json.loads(written, parse_constant=no_constant)
        name = guide["vessel"]
        dict(leaves(guide))
    except (ValueError, KeyError, TypeError, AttributeError):
        raise ConfigError(
            f"--baseline {path}: is no guide; give the file of --json or of --html"
        ) from None
    if name != vessel:
        raise ConfigError(f"--baseline {path}: is a guide of {quote(name)}, not of {quote(vessel)}")
    return guide  # type: ignore[no-any-return]


def leaves(guide: Mapping[str, Any]) -> Iterator[tuple[str, float | str | None]]:
    """Yield every number and verdict of a guide with its name."""
    for sheet in guide["sheets"]:
        for equations, rows in sheet["judgements"].items():
            for row in rows:
                name = f"{sheet['title']}: {row['quantity']}"
                yield f"{name} [{row['unit']}], full", row["full"]
                yield f"{name} [{row['unit']}], {equations}", row["other"]
                yield f"{name}, {equations}: verdict", row["verdict"]
    for one in guide["findings"]:
        yield f"finding {one['title']}: verdict", one["verdict"]
    for run in guide["steps"]:
        name = f"{run['case']}, {run['scheme']} {run['rates']} {run['step_s']:.3g} s"
        yield f"{name} [%]", run["percent"]
    for trial in guide["trials"]:
        if "trial" in trial:  # a guide of before there were verdicts on published figures
            results = trial["trial"]["results"]
            for result, value in zip(results, trial["ours"], strict=True):
                yield f"{trial['trial']['title']}: {result['quantity']} [{result['unit']}]", value
        for row in trial.get("rows", ()):
            figure = row["figure"]
            yield f"{trial['title']}: {figure['quantity']} [{figure['unit']}]", row["ours"]


def compare_guides(earlier: Mapping[str, Any], now: Mapping[str, Any]) -> tuple[GuideMove, ...]:
    """Return what differs between two guides, the largest change first."""
    before, after = dict(leaves(earlier)), dict(leaves(now))
    moves = [
        GuideMove(name, before.get(name), after.get(name))
        for name in dict.fromkeys([*before, *after])
        if not _same(before.get(name), after.get(name))
    ]
    return tuple(sorted(moves, key=lambda one: -_size(one)))


def _same(before: float | str | None, after: float | str | None) -> bool:
    """Return whether two entries are the same, numbers but for rounding."""
    if isinstance(before, float) and isinstance(after, float):
        return abs(after - before) <= SAME_NUMBER_RATIO * max(abs(before), abs(after)) + TINY_NUMBER
    return before == after


def _size(one: GuideMove) -> float:
    """Return the sort key of a change: verdicts first, then by relative change."""
    if isinstance(one.before, str) or isinstance(one.after, str):
        return float("inf")
    return abs(one.percent) if one.percent is not None else 1e9
