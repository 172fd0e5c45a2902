"""The functions of the Python face: what is shipped, manoeuvres, sweeps and fits by call.

Each does what the command of its name does, with the options of that command as keywords.
"""

import json
import tempfile
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, Generic, Literal, TypedDict, TypeVar, Unpack, overload

from trainer.api.keywords import parse_options
from trainer.cli.options import record_of
from trainer.cli.workshop import fit_boat as fit_boat_command
from trainer.cli.workshop import guide, identify
from trainer.cli.workshop import sweep as sweep_command
from trainer.cli.workshop import watch_boat as watch_boat_command
from trainer.config.extras import require_library
from trainer.config.files import json_text, shipped_names

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from trainer.analysis.manoeuvres.page import ManoeuvreReport
    from trainer.analysis.manoeuvres.vehicle import Measure
    from trainer.analysis.sweep.report import Spread, SweepReport
    from trainer.identify.boat.figures import FigureBand
    from trainer.identify.boat.report import BoatFit
    from trainer.identify.boat.watch import BoatWatch, WatchedPart
    from trainer.identify.pages.record import ChannelSummary, RecordReport
    from trainer.identify.pages.results import Estimate, ShipNumber
    from trainer.identify.pages.results import IdentifyReport as FitReport

Report = TypeVar("Report")
Figure = TypeVar("Figure")
File = str | Path


@dataclass(frozen=True, repr=False)
class Answer(Generic[Report, Figure]):
    """The answer of a program; ``print`` shows the page that its command prints.

    ``report`` is a record of all that the command's ``--json`` has. ``figures`` are its numbers by
    their names, each with a ``unit``: SI units and radians, of a fit those of its page.
    ``columns`` are arrays by name: of a manoeuvre what was flown, of a sweep a number for each
    member, of a watch its statistic, of a fit none. ``page`` is the text.
    """

    report: Report
    figures: Mapping[str, Figure]
    columns: "dict[str, NDArray[Any]]"
    page: str

    def as_json(self) -> dict[str, Any]:
        """Return the report as the command's ``--json`` has it."""
        report: dict[str, Any] = json.loads(json_text(asdict(self.report)))  # type: ignore[call-overload]
        return report

    def frame(self) -> Any:
        """Return ``columns`` as a pandas frame, by the time ``t`` [s] if there is one.

        TrainerError where pandas is not installed; the extra ``pandas`` brings it.
        """
        from trainer.debrief.passage.recording_export import frame_of

        return frame_of(self.columns)

    def __repr__(self) -> str:
        return self.page


class ManoeuvreOptions(TypedDict, total=False):
    """The keywords of ``manoeuvre``: the options of ``trainer boat manoeuvre``."""

    speed: float | None
    angle: float | None
    side: Literal["starboard", "port"] | None
    direction: Literal["rise", "dive"] | None
    planes: float | None
    execute: float | None
    duration: float | None
    step_speed: float | None
    step_time: float | None
    ahead_speed: float | None
    ahead_time: float | None
    depth: float | None
    sea: File | None
    seed: int | None
    equations: Literal["full", "modified", "basic", "longitudinal"] | None
    rates: Literal["exact", "lagged"] | None
    trig: Literal["exact", "report"] | None
    integrator: str | None
    step: float | None
    controls: Literal["own", "once"] | None
    trim: Literal["own", "full"] | None
    law: Literal["trainer", "report", "literal"] | None


def manoeuvre(
    name: str, vessel: File = "bb2", **options: Unpack[ManoeuvreOptions]
) -> "Answer[ManoeuvreReport, Measure]":
    """Fly a manoeuvre and measure it, as ``trainer boat manoeuvre`` does.

    ``speed`` is in kn; ``angle``, ``planes`` and ``execute`` in degrees; ``duration``,
    ``step_time`` and ``ahead_time`` in s; ``step_speed`` and ``ahead_speed`` in kn; ``depth`` in m.
    The figures are the measures, such as ``figures["advance"].value`` in m. If the boat is lost on
    the way, ``report.lost`` says why. TrainerError with the command's words if something is wrong.
    """
    from trainer.analysis.manoeuvres.page import render

    known = ManoeuvreOptions.__annotations__
    with parse_options(guide.manoeuvre, [name, vessel], options, known) as parsed_options:
        del parsed_options["name"], parsed_options["vessel"]
        report, flight = guide.fly(str(vessel), name, parsed_options)
    return Answer(
        report,
        {each.name: each for each in report.measures},
        dict(flight.series.columns),
        render(report),
    )


class SweepOptions(TypedDict, total=False):
    """The keywords of ``sweep``: the options of ``trainer boat sweep``."""

    members: int | None
    out: File | None
    jobs: int | None
    scheduler: str | None


def sweep(study: File, **options: Unpack[SweepOptions]) -> "Answer[SweepReport, Spread]":
    """Fly a study, one boat many times, as ``trainer boat sweep`` does.

    ``members`` is how many there are, else the study's own number. With ``out`` the result is kept
    in that Parquet file, and a sweep that was interrupted goes on; else nothing is kept. ``jobs``
    is the number of processes, at first this one alone; a script that asks for more stands under
    ``if __name__ == "__main__":``. The figures are the spreads of the measures, the columns what
    was drawn and what came of it. TrainerError with the command's words if something is wrong,
    and without the extra ``parquet``.
    """
    from trainer.analysis.sweep.job import job_of, open_job
    from trainer.analysis.sweep.report import render, report_of
    from trainer.analysis.sweep.sweep import check_pyarrow
    from trainer.cli.workshop.subjects import subject_of

    keywords = {"jobs": 1, **options}
    with parse_options(
        sweep_command.sweep, [study], keywords, SweepOptions.__annotations__
    ) as parsed_options:
        check_pyarrow()
        job = job_of(str(study), parsed_options["members"], subject_of)
        with tempfile.TemporaryDirectory() as folder:
            out = parsed_options["out"] or Path(folder) / "result.parquet"
            table = sweep_command.fly(job, out, parsed_options)
    report = report_of(open_job(job), table, str(parsed_options["out"] or "not kept"))
    columns = {
        name: table.column(name).to_numpy(zero_copy_only=False).copy()
        for name in table.column_names
    }
    return Answer(report, {each.name: each for each in report.spreads}, columns, render(report))


class IdentifyOptions(TypedDict, total=False):
    """The keywords of ``identify_ship``: the options of ``trainer identify``."""

    model: Literal["1", "2", "3", "nomoto1", "nomoto2"] | None
    vessel: File | None
    length: float | None
    at: float | None
    output: str | Sequence[str] | None
    noise: Literal["output-error", "innovations", "covariance"] | None
    method: Literal["scoring", "bfgs", "direct"] | None
    exact: bool
    system: File | None
    reject: float | None
    between_readings: Literal["straight", "step"] | None
    every: int | None
    begin: float | None
    end: float | None
    simulate: bool
    against: Literal["1", "2", "3", "nomoto1", "nomoto2"] | None
    without: str | Sequence[str] | None
    check: File | None
    kappa: File | None
    bech: File | None
    spiral: File | None
    joint: bool
    matrices: bool


@overload
def identify_ship(
    record: File, *, data_only: Literal[True], **options: Unpack[IdentifyOptions]
) -> "Answer[RecordReport, ChannelSummary]": ...


@overload
def identify_ship(
    record: File, *, data_only: Literal[False] | None = None, **options: Unpack[IdentifyOptions]
) -> "Answer[FitReport, Estimate | ShipNumber]": ...


def identify_ship(
    record: File, *, data_only: bool | None = None, **options: Unpack[IdentifyOptions]
) -> "Answer[Any, Any]":
    """Identify a ship from a record of rudder and motion, as ``trainer identify`` does.

    ``record`` is the path of a recording, a CSV file or a study; ``check`` one more, which the
    ship found is to predict. ``length`` is in m, ``at`` is the speed in kn, ``begin`` and ``end``
    are in s. The figures are the parameters and the ship's gains and time constants, each with its
    value, unit and standard deviation; ``report.converged`` says whether the fit has settled.
    With ``data_only`` nothing is fitted: the figures are the record's columns in few numbers.
    TrainerError with the command's words if something is wrong, and without the extra
    ``identify``.
    """
    require_library("scipy", "identify")
    from trainer.identify import options as studies
    from trainer.identify.pages import record as record_page
    from trainer.identify.pages.identify import render

    keywords = {"data_only": data_only, **options}
    known = ("data_only", *IdentifyOptions.__annotations__)
    with parse_options(identify.identify, [record], keywords, known) as words:
        wishes = record_of(studies.IdentifyOptions, words)
        study = studies.study_of(Path(record), wishes)
        if wishes.data_only:
            seen, _ = record_page.carry_out(study)
            channels = {each.name: each for run in seen.runs for each in run.channels}
            return Answer(seen, channels, {}, record_page.render(seen))
        report = identify.fit_ship(study, wishes).report
    figures: dict[str, Estimate | ShipNumber] = {each.name: each for each in report.parameters}
    figures |= {each.name: each for each in report.ship}
    return Answer(report, figures, {}, render(report))


class FitBoatOptions(TypedDict, total=False):
    """The keywords of ``fit_boat``: the options of ``trainer boat fit``."""

    hold_out: File | Sequence[File] | None
    output: File | None
    html: File | None
    columns: str | Sequence[str] | None
    bias: str | Sequence[str] | None
    gauge_x: float | None
    late: float | None
    still: str | Sequence[str] | None
    coarse: bool
    anyway: bool
    draws: int | None


def fit_boat(
    records: File | Sequence[File], prior: File, **options: Unpack[FitBoatOptions]
) -> "Answer[BoatFit, FigureBand]":
    """Fit a boat to records of its trials, as ``trainer boat fit`` does.

    ``records`` are paths of recordings or CSV files, ``prior`` the file of an estimated boat or of
    an earlier fit, ``hold_out`` records to foretell. ``columns``, ``bias``, ``gauge_x``,
    ``late`` and ``coarse`` say of instruments what the options do. With ``output`` the boat is
    written, if the fit settled; ``anyway`` takes wrong signs too, and writes all the same. The
    figures are those of turns and zig-zags by their names, each with its unit, value and band;
    ``report.coefficients`` has every coefficient before and after. TrainerError with the command's
    words if something is wrong.
    """
    from trainer.identify.boat.page import render

    several = [records] if isinstance(records, str | Path) else records
    keywords = {"prior": prior, **options}
    known = ("prior", *FitBoatOptions.__annotations__)
    with parse_options(fit_boat_command.fit, several, keywords, known) as words:
        report = fit_boat_command.carry_out(words).report
    return Answer(report, {each.name: each for each in report.after}, {}, render(report))


class WatchBoatOptions(TypedDict, total=False):
    """The keywords of ``watch_boat``: the options of ``trainer boat watch``."""

    html: File | None
    columns: str | Sequence[str] | None
    bias: str | Sequence[str] | None
    gauge_x: float | None
    late: float | None
    still: str | Sequence[str] | None
    coarse: bool
    anyway: bool


def watch_boat(
    fitted: File, records: File | Sequence[File], **options: Unpack[WatchBoatOptions]
) -> "Answer[BoatWatch, WatchedPart]":
    """Tell whether records are still of a fitted boat, as ``trainer boat watch`` does.

    ``fitted`` is the file of a boat that ``fit_boat`` wrote, ``records`` are paths of recordings
    or CSV files, one after the other in time; ``columns``, ``bias``, ``gauge_x``, ``late``,
    ``coarse`` and ``anyway`` are those of ``fit_boat``. ``report.change`` is None, or says since
    when and which parts explain it. The figures are the parts by their names, each with its unit,
    value and deviation. The columns are the statistic of each part by the time ``t`` [s].
    TrainerError with the command's words if something is wrong.
    """
    import numpy as np

    from trainer.identify.boat.watch_page import render

    several = [records] if isinstance(records, str | Path) else records
    known = WatchBoatOptions.__annotations__
    with parse_options(watch_boat_command.watch, [fitted, *several], options, known) as words:
        report = watch_boat_command.carry_out(words)
    named = zip((each.name for each in report.parts), report.deviations, strict=True)
    columns = {"t": np.array(report.t), **{name: np.array(values) for name, values in named}}
    return Answer(report, {each.name: each for each in report.parts}, columns, render(report))


def vessels() -> dict[str, str]:
    """Return the shipped boats: the name to give, and in words what each is."""
    from trainer.config.boat.vessel import load_vessel

    return {name: load_vessel(name).name for name in shipped_names("vessels")}


def exercises() -> dict[str, str]:
    """Return the shipped exercises in the order of the course: name and title."""
    from trainer.config.exercise.course import course

    return {lesson.name: lesson.title for lesson in course()}


def seas() -> dict[str, str]:
    """Return the shipped seas: the name to give, and in words what each is."""
    from trainer.config.world.sea import load_sea

    return {name: load_sea(name).name for name in shipped_names("seas")}
