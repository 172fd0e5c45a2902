"""The guide's contents: everything flown, judged and computed for one boat, and what moved."""

import hashlib
import platform
import sys
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from importlib import metadata
from typing import Any, Final

from trainer import __version__
from trainer.analysis.check import round_speeds
from trainer.analysis.guide import findings, reasons
from trainer.analysis.guide.findings import Finding, StepRun
from trainer.analysis.guide.programme import SETS, Flown, Leg, Task, fly_all
from trainer.analysis.guide.trials import (
    Compared,
    WavesCompared,
    compare_trials,
    compare_waves,
    load_published,
    trials_path,
)
from trainer.analysis.guide.verdicts import (
    BEYOND,
    SHOWN,
    WITHIN,
    Judgement,
    account,
    judge,
    passes,
)
from trainer.analysis.manoeuvres.catalogue import Parameters, parameters
from trainer.analysis.programs import characteristic, neutral, thrust
from trainer.config.vessel import VesselFile
from trainer.core.cache import core_digest

REDUCED: Final = ("modified", "basic")  # sets judged by the full one
ANSWERS: Final = "modified"  # the one that runs, on which the guide's verdict rests
LIBRARIES: Final = ("numpy", "numba")


@dataclass(frozen=True)
class Sheet:
    """One leg, judged."""

    title: str
    manoeuvre: str
    parameters: Parameters  # [deg], [s] and [kn]
    problems: dict[str, str]  # why there is no flight, by equation set
    judgements: dict[str, tuple[Judgement, ...]]  # by reduced set

    def counted(self, equations: str, verdict: str) -> int:
        """Return how many of a set's numbers have that verdict."""
        return sum(one.verdict == verdict for one in self.judgements.get(equations, ()))

    def passed(self, equations: str) -> bool | None:
        """Return whether nothing judged is beyond tolerance; None: nothing is judged."""
        if self.problems.get(equations) and not self.problems.get("full"):
            return False
        if not self.counted(equations, WITHIN) + self.counted(equations, BEYOND):
            return None
        return not self.counted(equations, BEYOND)


@dataclass(frozen=True)
class Guide:
    """All that the guide says about a boat."""

    vessel: str
    made: str  # time stamp
    step_s: float
    versions: dict[str, str]
    checksums: dict[str, str]  # sha256 of what it was made from
    sheets: tuple[Sheet, ...]
    findings: tuple[Finding, ...]
    steps: tuple[StepRun, ...]
    drops: tuple[reasons.Drop, ...]
    trials: tuple[Compared, ...]
    waves: tuple[WavesCompared, ...]
    neutral: neutral.Neutral
    modes: characteristic.Report
    thrust: thrust.Report
    passed: bool  # something is judged, and nothing beyond tolerance

    @property
    def conclusion(self) -> str:
        """Return the verdict of the whole guide in words."""
        if all(sheet.passed(ANSWERS) is None for sheet in self.sheets):
            return "Nothing was judged"
        return "Within tolerance" if self.passed else "Out of tolerance"


@dataclass(frozen=True)
class GuideContents:
    """A guide, with the flights that it plots."""

    file: VesselFile
    guide: Guide
    legs: tuple[Leg, ...]
    flown: Flown


def tasks(file: VesselFile, legs: Sequence[Leg]) -> tuple[Task, ...]:
    """Return every flight that a guide of these legs needs, each once."""
    path = trials_path(file)
    found = (
        *(leg.task(file, equations) for leg in legs for equations in SETS),
        *findings.step_tasks(file),
        *findings.tasks(file),
        *reasons.drop_tasks(file),
        *(trial.task(file) for trial in (load_published(path)[0] if path else ())),
    )
    return tuple(dict.fromkeys(found))


def write(
    file: VesselFile, legs: Sequence[Leg], made: str, cores: int, step: Callable[[], None]
) -> GuideContents:
    """Return the guide of a boat in these legs; ``step`` is called after each flight."""
    flown = fly_all(file.path, tasks(file, legs), cores, step)
    return assemble(file, legs, made, flown)


def assemble(file: VesselFile, legs: Sequence[Leg], made: str, flown: Flown) -> GuideContents:
    """Return the guide from its flights."""
    sheets = tuple(_sheet(file, leg, flown) for leg in legs)
    stepped = findings.step_study(file, flown)
    checksums = {file.path.name: hashlib.sha256(file.text.encode()).hexdigest()}
    if path := trials_path(file):
        checksums[f"{path.stem} (published results)"] = hashlib.sha256(
            path.read_bytes()
        ).hexdigest()
    trials, waves = load_published(path) if path else ((), ())
    speeds = round_speeds(*file.run.speed_range_kn)
    guide = Guide(
        vessel=file.name,
        made=made,
        step_s=file.run.step_s,
        versions={
            "trainer": __version__,
            "core": core_digest(),
            "python": sys.version.split()[0],
            **{name: metadata.version(name) for name in LIBRARIES},
            "machine": platform.machine(),
        },
        checksums=checksums,
        sheets=sheets,
        findings=findings.study(file, flown, stepped),
        steps=stepped,
        drops=reasons.drop_study(file, flown),
        trials=tuple(compare_trials(file, trials, flown)),
        waves=tuple(compare_waves(file, waves)),
        neutral=neutral.neutral(file, speeds),
        modes=characteristic.characteristic(file, speeds, characteristic.Means()),
        thrust=thrust.survey(file, (0.0, *speeds), thrust.command_speeds(file)),
        passed=passes([sheet.passed(ANSWERS) for sheet in sheets]),
    )
    return GuideContents(file, guide, tuple(legs), flown)


def _sheet(file: VesselFile, leg: Leg, flown: Flown) -> Sheet:
    """Return one leg judged."""
    flights = {each: flown[leg.task(file, each)] for each in SETS}
    full = flights["full"]
    judgements = {}
    for equations in REDUCED:
        other = flights[equations]
        if not isinstance(full, str) and not isinstance(other, str):
            judgements[equations] = judge(leg.manoeuvre, full, other)
    problems = {each: flight for each, flight in flights.items() if isinstance(flight, str)}
    return Sheet(leg.title, leg.name, parameters(leg.manoeuvre), problems, judgements)


def tally(guide: Guide, equations: str) -> dict[str, Any]:
    """Return how many numbers and manoeuvres of a reduced set are within and beyond."""
    sheets = guide.sheets
    return {
        "within": sum(sheet.counted(equations, WITHIN) for sheet in sheets),
        "beyond": sum(sheet.counted(equations, BEYOND) for sheet in sheets),
        "shown": sum(sheet.counted(equations, SHOWN) for sheet in sheets),
        "manoeuvres": account([sheet.passed(equations) for sheet in sheets]),
    }
