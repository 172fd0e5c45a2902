"""``trainer debrief``: a recording in, one HTML page out that needs nothing beside itself."""

import tempfile
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Final

import click
import numpy as np
from markupsafe import Markup

from trainer import __version__
from trainer.analysis.debrief import sections
from trainer.analysis.debrief.changes import change_of, read_changes, without, write_changes
from trainer.analysis.debrief.charts import (
    charts_of,
    draw_timeline,
    ground_of,
    runs_beside,
)
from trainer.analysis.debrief.data import DebriefData, compared, figures, find_branch, gather
from trainer.analysis.debrief.track import draw_track
from trainer.analysis.report.html import charts, page, paragraph, print_pdf, section
from trainer.analysis.report.svg import clock, draw
from trainer.config.files import ConfigError, json_text
from trainer.io.atomic_write import write_whole
from trainer.session.header import plan_of, reading

BADGE: Final = Markup('<meta name="generator" content="trainer debrief">')  # a page of ours


def render(debrief: DebriefData, boat: str = "") -> str:
    """Return the page, one with a boat inside it; same record, same bytes."""
    return page(
        "debrief.html",
        "debrief.css",
        badge=BADGE,
        title=debrief.title,
        under=_under(debrief),
        verdict=sections.verdict(debrief),
        briefing=debrief.plan.briefing,
        parts=list(_parts(debrief)),
        boat=boat,
        version=__version__,
        source=debrief.source.name,
    )


def _under(debrief: DebriefData) -> str:
    """Return what is below the title: the boat, the day, how long, and which branch."""
    told = [
        debrief.plan.file.name,
        debrief.header.get("started", ""),
        f"{clock(float(debrief.trajectory.seconds[-1]))} flown",
    ]
    told.append(", ".join(debrief.trainees))
    if len(debrief.branches) > 1:
        told.append(f"branch {debrief.branch.id} of {len(debrief.branches)}")
    return " - ".join(filter(None, told))


def _parts(debrief: DebriefData) -> Iterator[Markup]:
    """Yield the sections, in the order in which a crew wants to know."""
    if debrief.card.scores:
        yield section("moment", "Where it went wrong", sections.moment(debrief))
        yield section("cost", "What cost most", sections.cost(debrief))
    if debrief.changes:
        yield section("changes", "Changed by the instructor", sections.changes(debrief))
    yield section("charts", "Ordered and actual", _drawings(debrief))
    if debrief.read_backs:
        yield section("orders", "Orders to the crew", sections.read_backs(debrief))
    told = sections.casualties(debrief) if debrief.casualties else paragraph("Nothing broke.")
    yield section("casualties", "Casualties", told)
    if debrief.card.scores:
        yield section("scores", "Measures", sections.scores(debrief))
    if met := sections.ships(debrief):
        yield section("ships", "Ships", met)
    if debrief.of_kind("mark"):
        yield section("words", "Marks and remarks", sections.marks(debrief))
    if debrief.hands:
        yield section("hands", "Who gave orders", sections.hands(debrief))
    yield section("log", "Orders and events", sections.log(debrief))
    if len(debrief.branches) > 1:
        yield section("branches", "Branches", sections.branches(debrief))
    yield section("ticks", "Ticks", sections.ledger(debrief))
    yield section("run", "What was flown", sections.run_facts(debrief))


def _drawings(debrief: DebriefData) -> Markup:
    """Return the time line, the charts and the track."""
    ground, beside = ground_of(debrief), runs_beside(debrief)
    drawn = [draw_timeline(debrief, ground)]
    drawn += [draw(chart, ground) for chart in charts_of(debrief.trajectory, beside)]
    return Markup().join(
        [sections.legend(debrief), charts([*drawn, draw_track(debrief, ground, beside)])]
    )


HEAD = 2000  # [characters] in which a page of ours says that it is


@dataclass(frozen=True)
class Asked:
    """How a recording is to be debriefed."""

    branch: int | None = None  # None: the latest
    width: str | None = None  # of the bands; None: as it was begun with
    reference_from: float | None = None  # [s] where the reference crew takes over, too
    boat: str = ""  # a page with the boat inside, to be put into this one


def debrief_file(
    path: Path, html: Path | None, pdf: Path | None, asked: Asked, *, as_json: bool
) -> None:
    """Write the page as HTML or PDF, and print where it is, or the figures.

    Asked for neither, it goes beside the recording as HTML. ConfigError on what is wrong.
    """
    for wanted in filter(None, (html, pdf)):
        _refuse_recording(path, wanted)
    if html is None and pdf is None and not as_json:
        html = beside(path, asked.branch)
        _refuse_other(html)
    with np.errstate(all="ignore"):  # a state may hold any number
        debrief = read_compared(path, asked)
        text = render(debrief, asked.boat) if html or pdf else ""
    written = []
    if html is not None:
        _write(html, text)
        written.append(html)
    if pdf is not None:
        _print(text, pdf)
        written.append(pdf)
    if as_json:
        click.echo(json_text(figures(debrief), indent=1))
    else:
        click.echo("\n".join(map(str, written)))


def read_dossier(path: Path, branch: int | None, width: str | None = None) -> DebriefData:
    """Return the dossier of a recording; ConfigError if it cannot be read."""
    with reading(path) as recording:
        return gather(recording, path, branch, width)


def read_compared(path: Path, asked: Asked) -> DebriefData:
    """Return the dossier of a recording beside the reference crew's run; ConfigError."""
    with reading(path) as recording:
        debrief = gather(recording, path, asked.branch, asked.width)
        return compared(debrief, recording, asked.reference_from)


def beside(path: Path, branch: int | None) -> Path:
    """Return where the page of a recording goes unless told otherwise."""
    return path.with_name(path.stem + ("" if branch is None else f".branch{branch}") + ".html")


def change_marks(path: Path, asked: Asked, texts: Sequence[str], back: Sequence[str]) -> None:
    """Keep changes of marks, having taken others back; ConfigError, nothing changed, on any."""
    if not (texts or back):
        return
    with reading(path) as recording:
        plan, branches = plan_of(recording.header()), recording.branches()
    branch = find_branch(branches, path, asked.branch).id
    changes = read_changes(path)
    for name in back:
        changes = without(changes, name, branch)
    write_changes(path, [*changes, *(change_of(text, branch, plan) for text in texts)])


def _refuse_recording(path: Path, wanted: Path) -> None:
    """Refuse to write over the recording."""
    if wanted.exists() and path.exists() and wanted.samefile(path):
        raise ConfigError(f"{wanted} is the recording itself: give another name")


def _refuse_other(html: Path) -> None:
    """Refuse to replace, without being told to, what is no debrief."""
    if not html.exists():
        return
    try:
        with html.open(encoding="utf-8", errors="replace") as file:
            ours = BADGE in file.read(HEAD)
    except OSError:
        ours = False
    if not ours:
        raise ConfigError(f"{html} is there and is no debrief: say --html FILE")


def _write(path: Path, text: str) -> None:
    try:
        write_whole(path, text)
    except OSError as error:
        raise ConfigError(f"{path} cannot be written: {error.strerror}") from None


def _print(text: str, pdf: Path) -> None:
    with tempfile.TemporaryDirectory() as folder:
        html = Path(folder) / "debrief.html"
        _write(html, text)
        print_pdf(html, pdf)
