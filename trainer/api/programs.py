"""What a command and a call carry out alike: manoeuvres, sweeps, and fits of files.

``cli.workshop`` and ``calls`` read what was asked by the same kinds, and come here with it. Notes
and progress go to stderr.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import AbstractContextManager, contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

from trainer.boat.compilation import announce_compiling
from trainer.config.files import ConfigError, path_named, shipped_names
from trainer.config.keywords import fill_record
from trainer.report.progress import print_note, show_progress, show_step, write_text

if TYPE_CHECKING:
    from trainer.analysis.manoeuvres.flight import Flight
    from trainer.analysis.manoeuvres.page import ManoeuvreReport
    from trainer.analysis.sweep.job import Job
    from trainer.identify.boat.fit import BoatFound
    from trainer.identify.boat.watch import BoatWatch, WatchFiles
    from trainer.identify.options import IdentifyOptions
    from trainer.identify.pages.results import Identification
    from trainer.identify.record.study import Study

# fmt: off
BOAT_OPTIONS: Final = (  # of a manoeuvre, which no ship takes
    "depth", "sea", "seed", "equations", "rates", "trig", "integrator", "controls", "trim", "law",
)
# fmt: on


def ship_path(vessel: str) -> Path:
    """Return the path of a vessel's file; that of a shipped ship by its name."""
    return path_named(vessel, "ships") if vessel in shipped_names("ships") else Path(vessel)


def fly_manoeuvre(
    vessel: str, name: str, asked: Mapping[str, Any]
) -> "tuple[ManoeuvreReport, Flight]":
    """Return report and flight of a boat, or of a ship that was identified.

    ``asked`` are those of ``MANOEUVRE_KEYWORDS`` that were given; ConfigError for a boat's, of a
    ship.
    """
    from trainer.analysis.manoeuvres import page
    from trainer.analysis.manoeuvres.catalogue import PARAMETERS
    from trainer.analysis.manoeuvres.submarine import Rig
    from trainer.config.boat.vessel import load_vessel
    from trainer.config.ship.nomoto import is_nomoto
    from trainer.config.ship.ship import is_ship, load_ship

    settings = {key: asked[key] for key in PARAMETERS if key in asked}
    rig = fill_record(Rig, asked)
    wishes = fill_record(page.ManoeuvreOptions, asked, parameters=settings, rig=rig)
    path = ship_path(vessel)
    known = path.suffix == ".toml" and (is_nomoto(path), is_ship(path))
    if not known or not any(known):
        return page.fly_boat(load_vessel(vessel), name, wishes)
    if strange := ", ".join(f"--{each}" for each in BOAT_OPTIONS if each in asked):
        kind = "a Nomoto ship" if known[0] else "a ship"
        raise ConfigError(f"{vessel} is {kind}: {strange} are for boats")
    if known[1]:
        from trainer.identify.ships.vehicle import fly_ship

        return fly_ship(load_ship(path), name, wishes)
    from trainer.analysis.manoeuvres.nomoto_ship import steer_ship

    ship = steer_ship(path, wishes.step)
    return page.fly_vehicle(ship, name, wishes, ship.speed_kn)


def fly_sweep(job: "Job", out: Path, jobs: int | None = None, scheduler: str | None = None) -> Any:
    """Fly the members and return a table of pyarrow; show progress on a terminal."""
    from trainer.analysis.sweep.job import open_job
    from trainer.analysis.sweep.sweep import carry_out, cluster_crew, process_crew
    from trainer.workers import processor_count

    crew = process_crew(jobs or processor_count())
    if scheduler is not None:
        crew = cluster_crew(scheduler)
    with show_members(open_job(job).members) as step:
        return carry_out(job, crew, out, step)


@contextmanager
def show_members(count: int) -> Iterator[Callable[[int], None]]:
    """Show the progress of members; say how to go on after an interrupt."""
    from trainer.analysis.sweep.sweep import RESUME_NOTE

    try:
        with show_progress(count, "flying") as step:
            yield step
    except KeyboardInterrupt:
        print_note(f"trainer: {RESUME_NOTE}")
        raise


def fit_ship(study: "Study", asked: "IdentifyOptions") -> "Identification":
    """Return a fitted ship model and its report; ConfigError if it cannot be fitted."""
    from trainer.identify.pages.results import carry_out

    text = "the kernels of fits, once (up to a minute)"
    with announce_compiling(text, print_note, "fits", "identify/kernels"):
        return carry_out(study, asked, show_step)


def compiling_fits() -> AbstractContextManager[Any]:
    """Return the block that tells of compiling the kernels of fits of boats."""
    text = "the kernels of fits of boats, once (up to a minute)"
    return announce_compiling(text, print_note, "fits of boats", "identify/boat")


def fit_boat(
    records: Sequence[Path],
    prior: str,
    *,
    hold_out: Sequence[Path] = (),
    output: Path | None = None,
    html: Path | None = None,
    draws: int = 100,
    **instruments: Any,
) -> "BoatFound":
    """Fit a boat to records, and write it where that is asked for."""
    from trainer.identify.boat.fit import check_controls, judge_boat, open_trials, search_boat
    from trainer.identify.boat.instruments import instruments_of
    from trainer.identify.boat.report import figures_count

    made_by = instruments_of(**instruments)
    trials = open_trials(prior, records, hold_out, made_by)
    with compiling_fits():
        found = search_boat(trials, lambda step: show_step(step.steps, step.cost))
    if not made_by.anyway:
        check_controls(found)
    path = output or Path("fitted.toml")
    with show_progress(figures_count(draws), "sailing") as step:
        result = judge_boat(trials, found, path, draws, step)
    if output is not None and (made_by.anyway or result.is_whole):
        write_text(output, result.text)
    elif output is not None:
        print_note(f"{output} is not written: {result.report.doubt}; --anyway writes it")
    if html is not None:
        write_text(html, result.html, "--html")
    if result.lacks:
        print_note(f"{path} has no gains: {result.lacks}")
    return result


def watch_boat(
    fitted: str, records: Sequence[Path], *, html: Path | None = None, **instruments: Any
) -> "BoatWatch":
    """Watch a boat by records, and write the page where that is asked for."""
    from trainer.identify.boat.instruments import instruments_of
    from trainer.identify.boat.watch import open_watch
    from trainer.identify.boat.watch import watch_boat as watch_records

    files = open_watch(fitted, records, instruments_of(**instruments))
    with compiling_fits(), show_progress(files.windows, "watching") as step:
        report = watch_records(files, step)
    write_watch(html, files, report)
    return report


def write_watch(path: Path | None, files: "WatchFiles", report: "BoatWatch") -> None:
    """Write the page of a watch, if a path is given."""
    from trainer.identify.boat.watch_page import html_page

    if path is not None:
        write_text(path, html_page(files, report), "--html")
