"""The functions of the Python face: what is shipped, manoeuvres, sweeps and fits by call.

Each does what the command of its name does, with the options of that command as keywords.
"""

import json
import tempfile
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final, Generic, Literal, TypeVar, overload

from trainer.api import programs
from trainer.config.extras import require_library
from trainer.config.files import json_text, shipped_names
from trainer.config.keywords import (
    FIT_BOAT_KEYWORDS,
    IDENTIFY_KEYWORDS,
    MANOEUVRE_KEYWORDS,
    SWEEP_KEYWORDS,
    WATCH_BOAT_KEYWORDS,
    fill_record,
    reading_keywords,
)

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from trainer.analysis.manoeuvres.page import ManoeuvreReport
    from trainer.analysis.manoeuvres.vehicle import Measure
    from trainer.analysis.sweep.report import OutputSpread, SweepReport
    from trainer.identify.boat.figures import FigureBand
    from trainer.identify.boat.report import BoatFit
    from trainer.identify.boat.watch import BoatWatch, WatchedPart
    from trainer.identify.pages.record import ChannelSummary, RecordReport
    from trainer.identify.pages.results import FitNumber, ShipNumber
    from trainer.identify.pages.results import IdentifyReport as FitReport

Report = TypeVar("Report")
Figure = TypeVar("Figure")
File = str | Path
OPTION_NAMES: Final = {"at": "knots", "output": "channels"}  # of IdentifyOptions, where others


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


def manoeuvre(
    name: str, vessel: File = "bb2", **options: Any
) -> "Answer[ManoeuvreReport, Measure]":
    """Fly a manoeuvre and measure it, as ``trainer boat manoeuvre`` does.

    ``speed`` is in kn; ``angle``, ``planes`` and ``execute`` in degrees; ``duration``,
    ``step_time`` and ``ahead_time`` in s; ``step_speed`` and ``ahead_speed`` in kn; ``depth`` in m.
    The figures are the measures, such as ``figures["advance"].value`` in m. If the boat is lost on
    the way, ``report.lost`` says why. TrainerError naming what is wrong.
    """
    from trainer.analysis.manoeuvres.page import render

    given = {"vessel": vessel, **options}
    with reading_keywords("manoeuvre", MANOEUVRE_KEYWORDS, given) as asked:
        report, flight = programs.fly_manoeuvre(asked["vessel"], name, asked)
    return Answer(
        report,
        {each.name: each for each in report.measures},
        dict(flight.series.columns),
        render(report),
    )


def sweep(study: File, **options: Any) -> "Answer[SweepReport, OutputSpread]":
    """Fly a study, one boat many times, as ``trainer boat sweep`` does.

    ``members`` is how many there are, else the study's own number. With ``out`` the result is kept
    in that Parquet file, and a sweep that was interrupted goes on; else nothing is kept. ``jobs``
    is the number of processes, at first this one alone; a script that asks for more stands under
    ``if __name__ == "__main__":``. The figures are the spreads of the measures, the columns what
    was drawn and what came of it. TrainerError naming what is wrong,
    and without the extra ``parquet``.
    """
    from trainer.analysis.sweep.job import job_of, open_job
    from trainer.analysis.sweep.report import render, report_of
    from trainer.analysis.sweep.sweep import check_pyarrow
    from trainer.api.subjects import subject_of

    given = {"jobs": 1, **options, "study": study}
    with reading_keywords("sweep", SWEEP_KEYWORDS, given) as asked:
        check_pyarrow()
        job = job_of(asked.pop("study"), asked.pop("members", None), subject_of)
        kept = asked.pop("out", None)
        with tempfile.TemporaryDirectory() as folder:
            table = programs.fly_sweep(job, kept or Path(folder) / "result.parquet", **asked)
    report = report_of(open_job(job), table, str(kept or "not kept"))
    columns = {
        name: table.column(name).to_numpy(zero_copy_only=False).copy()
        for name in table.column_names
    }
    return Answer(report, {each.name: each for each in report.spreads}, columns, render(report))


@overload
def identify_ship(
    record: File, *, data_only: Literal[True], **options: Any
) -> "Answer[RecordReport, ChannelSummary]": ...


@overload
def identify_ship(
    record: File, *, data_only: Literal[False] | None = None, **options: Any
) -> "Answer[FitReport, FitNumber | ShipNumber]": ...


def identify_ship(
    record: File, *, data_only: bool | None = None, **options: Any
) -> "Answer[Any, Any]":
    """Identify a ship from a record of rudder and motion, as ``trainer identify`` does.

    ``record`` is the path of a recording, a CSV file or a study; ``check`` one more, which the
    ship found is to predict. ``length`` is in m, ``at`` is the speed in kn, ``begin`` and ``end``
    are in s. The figures are the parameters and the ship's gains and time constants, each with its
    value, unit and standard deviation; ``report.converged`` says whether the fit has settled.
    With ``data_only`` nothing is fitted: the figures are the record's columns in few numbers.
    TrainerError naming what is wrong, and without the extra
    ``identify``.
    """
    require_library("scipy", "identify")
    from trainer.identify import options as studies
    from trainer.identify.pages import record as record_page
    from trainer.identify.pages.identify import render

    given = {"record": record, "data_only": data_only, **options}
    with reading_keywords("identify_ship", IDENTIFY_KEYWORDS, given) as asked:
        named = {OPTION_NAMES.get(name, name): value for name, value in asked.items()}
        wishes = fill_record(studies.IdentifyOptions, named)
        study = studies.study_of(asked["record"], wishes)
        if wishes.data_only:
            seen, _ = record_page.carry_out(study)
            channels = {each.name: each for run in seen.runs for each in run.channels}
            return Answer(seen, channels, {}, record_page.render(seen))
        report = programs.fit_ship(study, wishes).report
    figures: dict[str, FitNumber | ShipNumber] = {each.name: each for each in report.parameters}
    figures |= {each.name: each for each in report.ship}
    return Answer(report, figures, {}, render(report))


def fit_boat(
    records: File | Sequence[File], prior: File, **options: Any
) -> "Answer[BoatFit, FigureBand]":
    """Fit a boat to records of its trials, as ``trainer boat fit`` does.

    ``records`` are paths of recordings or CSV files, ``prior`` the file of an estimated boat or of
    an earlier fit, ``hold_out`` records to foretell. ``columns``, ``bias``, ``gauge_x``,
    ``late`` and ``coarse`` say of instruments what the options do. With ``output`` the boat is
    written, if the fit settled; ``anyway`` takes wrong signs too, and writes all the same. The
    figures are those of turns and zig-zags by their names, each with its unit, value and band;
    ``report.coefficients`` has every coefficient before and after. TrainerError naming what
    is wrong.
    """
    from trainer.identify.boat.page import render

    given = {"records": records, "prior": prior, **options}
    with reading_keywords("fit_boat", FIT_BOAT_KEYWORDS, given) as asked:
        report = programs.fit_boat(**asked).report
    return Answer(report, {each.name: each for each in report.after}, {}, render(report))


def watch_boat(
    fitted: File, records: File | Sequence[File], **options: Any
) -> "Answer[BoatWatch, WatchedPart]":
    """Tell whether records are still of a fitted boat, as ``trainer boat watch`` does.

    ``fitted`` is the file of a boat that ``fit_boat`` wrote, ``records`` are paths of recordings
    or CSV files, one after the other in time; ``columns``, ``bias``, ``gauge_x``, ``late``,
    ``coarse`` and ``anyway`` are those of ``fit_boat``. ``report.change`` is None, or says since
    when and which parts explain it. The figures are the parts by their names, each with its unit,
    value and deviation. The columns are the statistic of each part by the time ``t`` [s].
    TrainerError naming what is wrong.
    """
    import numpy as np

    from trainer.identify.boat.watch_page import render

    given = {"fitted": fitted, "records": records, **options}
    with reading_keywords("watch_boat", WATCH_BOAT_KEYWORDS, given) as asked:
        report = programs.watch_boat(**asked)
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
