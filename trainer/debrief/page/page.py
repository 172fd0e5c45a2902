"""``trainer debrief``: a recording in, one HTML page out that needs nothing beside itself.

``cli`` calls ``debrief_file`` for a recording, and ``run`` after an exercise. The sections are made
by ``sections`` and ``charts`` from ``DebriefData``; here they are put in their order. The same
record gives the same bytes.
"""

import contextlib
import sys
import tempfile
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from textwrap import fill
from typing import Final, NamedTuple

import click
import numpy as np
from markupsafe import Markup

from trainer import __version__
from trainer.config.files import ConfigError, json_text, write_over
from trainer.core.kernel import Numbers
from trainer.debrief.attainable.words import terminal_lines
from trainer.debrief.marks.changes import change_of, without_changes, write_changes
from trainer.debrief.marks.forms import compared_lines, compared_table, with_forms, write_forms
from trainer.debrief.page import sections
from trainer.debrief.page.charts import (
    RunBeside,
    attainable_chart,
    charts_of,
    draw_timeline,
    ground_of,
    runs_beside,
)
from trainer.debrief.page.data import (
    DebriefData,
    RunOpinions,
    compare_debrief,
    debrief_figures,
    find_branch,
    gather_debrief,
    read_opinions,
)
from trainer.debrief.passage.ships_met import ShipWay, locate_ship, meet_ships, ways_of_ships
from trainer.debrief.passage.trajectory import row_stretches
from trainer.io.lines import plain
from trainer.report.html import charts, fill_page, paragraph, section
from trainer.report.pdf import print_pdf
from trainer.report.svg import (
    CHART_WIDTH_PX,
    Axis,
    ChartGround,
    clock,
    draw_chart,
    rule,
    step_of,
    svg_element,
    text,
)
from trainer.session.past.header import open_whole_recording, plan_of

PAGE_BADGE: Final = Markup('<meta name="generator" content="trainer debrief">')  # a page of ours
BADGE_SEARCH_CHARS = 2000  # [characters] at the start of a file, among which PAGE_BADGE must stand
MAX_TRACK_HEIGHT_PX: Final = 420.0  # [px] of the track
TRACK_SIDE_PX, TRACK_ABOVE_PX, TRACK_BELOW_PX = 10.0, 26.0, 30.0  # [px] about it
MIN_TRACK_WIDTH_M: Final = 400.0  # [m] across the shorter way
TIME_MARK_PERIODS_S: Final = (
    10.0,
    30.0,
    60.0,
    300.0,
    600.0,
    1800.0,
)  # [s] between its marks of time
MAX_TRACK_POINTS: Final = 1600  # points of it
MAX_TIME_MARKS: Final = 12  # of them at most
MAX_RULE_SHARE: Final = 0.2  # of the width, the longest rule
TEXT_WIDTH: Final = 79  # [columns] of what is printed
CLOSE_RANGE_M: Final = 3000.0  # [m] from the boat, within which a ship's way widens the map


class Chapter(NamedTuple):
    """A chapter of the page: where links lead, its heading, what it holds."""

    name: str
    title: str
    content: Markup


def render(debrief: DebriefData, boat: str = "") -> str:
    """Return the page, one with a boat inside it; same record, same bytes."""
    chapters = [*_parts(debrief, sections.PLAY_BY_LINK if boat else sections.PLAY_BY_ORDERS)]
    return fill_page(
        "debrief.html",
        "debrief.css",
        badge=PAGE_BADGE,
        title=debrief.title,
        under=_under(debrief),
        verdict=sections.verdict(debrief),
        briefing=debrief.plan.briefing,
        contents=[(each.name, each.title) for each in chapters],
        parts=[section(*each) for each in chapters],
        boat=boat,
        version=__version__,
        source=plain(debrief.source.name),
    )


def _under(debrief: DebriefData) -> str:
    """Return the line below the title: boat, day, length and branch."""
    parts = [
        debrief.plan.file.name,
        debrief.header.get("started", ""),
        f"{clock(float(debrief.trajectory.seconds[-1]))} flown",
    ]
    parts.append(", ".join(debrief.trainees))
    if len(debrief.branches) > 1:
        parts.append(f"branch {debrief.branch.id} of {len(debrief.branches)}")
    return " - ".join(filter(None, parts))


def _parts(debrief: DebriefData, play: sections.PlayOn) -> Iterator[Chapter]:
    """Yield the sections, in the order in which a crew wants to know."""
    if debrief.card.scores:
        yield Chapter("minutes", "What each minute cost", sections.minutes(debrief, play))
        yield Chapter("cost", "What cost most", sections.cost(debrief))
    if debrief.changes:
        yield Chapter("changes", "Changed by the instructor", sections.changes(debrief))
    if debrief.forms:
        yield Chapter(
            "forms",
            "Assessors, peers and the program",
            compared_table(debrief.forms, debrief.final),
        )
    yield Chapter("charts", "Ordered and actual", _drawings(debrief))
    yield from _talk(debrief)
    yield from _troubles(debrief)
    yield from _measured(debrief)
    if met := sections.ships(debrief):
        yield Chapter("ships", "Ships", met)
    if debrief.of_kind("mark"):
        yield Chapter("words", "Marks and remarks", sections.marks(debrief))
    if debrief.hands:
        yield Chapter("hands", "Who gave orders", sections.hands(debrief))
    if len(debrief.branches) > 1:
        yield Chapter("branches", "Branches", sections.branches(debrief))
    yield Chapter("ticks", "Ticks", sections.tick_ledger(debrief))
    yield Chapter("run", "What was flown", sections.run_facts(debrief))
    yield Chapter("log", "Orders and events", sections.log(debrief))  # the longest comes last


def _talk(debrief: DebriefData) -> Iterator[Chapter]:
    """Yield the orders to the crew, and how the crew worked with them."""
    if debrief.read_backs:
        yield Chapter("orders", "Orders to the crew", sections.read_backs(debrief))
    if debrief.crew_work:
        content = sections.crew_work(debrief, debrief.crew_work)
        yield Chapter("crew", "How this crew worked", content)


def _troubles(debrief: DebriefData) -> Iterator[Chapter]:
    """Yield what broke, and the alerts."""
    content = sections.casualties(debrief) if debrief.casualties else paragraph("Nothing broke.")
    yield Chapter("casualties", "Casualties", content)
    if debrief.trajectory.alerts:
        yield Chapter("alerts", "Alerts", sections.alerts(debrief))


def _measured(debrief: DebriefData) -> Iterator[Chapter]:
    """Yield the scores, and whose they are."""
    if debrief.card.scores:
        yield Chapter("scores", "Measures", sections.scores(debrief))
        if debrief.manned and debrief.task_marks:
            yield Chapter("whose", "Whose the marks are", sections.task_marks(debrief))


def _drawings(debrief: DebriefData) -> Markup:
    """Return the time line, the charts and the track."""
    ground, beside = ground_of(debrief), runs_beside(debrief)
    drawn = [draw_timeline(debrief, ground)]
    if (curve := attainable_chart(debrief)) is not None:
        drawn.append(draw_chart(curve, ground))
    drawn += [draw_chart(chart, ground) for chart in charts_of(debrief.trajectory, beside)]
    return Markup().join(
        [sections.legend(debrief), charts([*drawn, draw_track(debrief, ground, beside)])]
    )


@dataclass(frozen=True)
class DebriefRequest:
    """How a recording is to be debriefed."""

    branch: int | None = None  # None: that of ``crew_branch``
    width: str | None = None  # of the bands; None: as it was begun with
    reference_from: float | None = None  # [s] where the reference crew takes over, too
    boat: str = ""  # a page with the boat inside, to be put into this one
    change: tuple[str, ...] = ()  # marks, each NAME: WHAT, REASON
    change_back: tuple[str, ...] = ()  # names of changes to be taken back, before others are made
    forms: tuple[Path, ...] = ()  # filled ones, to be kept beside the recording

    @property
    def changes_marks(self) -> bool:
        """Return whether marks are changed, or changes taken back."""
        return bool(self.change or self.change_back)


def debrief_file(
    path: Path,
    html: Path | None,
    pdf: Path | None,
    asked: DebriefRequest,
    printed: Callable[[DebriefData], str] | None = None,
) -> None:
    """Keep what is changed, write the page as HTML or PDF, and name it.

    With ``printed``, what that makes of the debrief is printed instead.

    Asked for neither, it goes beside the recording as HTML. ConfigError on what is wrong, and then
    nothing is changed.
    """
    if html is None and pdf is None and printed is None:
        html = default_page_path(path, asked.branch)
        _refuse_other(html)
    with np.errstate(all="ignore"):  # a state may hold any number
        opinions = opinions_as_asked(path, asked)
        debrief = read_compared(path, asked, opinions)
        text = render(debrief, asked.boat) if html or pdf else ""
    if pdf is not None:  # first, because there may be no browser
        with tempfile.TemporaryDirectory() as folder:
            page = Path(folder) / "debrief.html"
            write_over(page, text)
            print_pdf(page, pdf)
    if asked.changes_marks:
        write_changes(path, opinions.changes)
    if asked.forms:
        write_forms(path, opinions.forms)
    if html is not None:
        write_over(html, text)
    for problem in debrief.excess:
        click.echo(f"trainer: {path}: {problem}", err=True)
    written = filter(None, (html, pdf))
    click.echo(printed(debrief) if printed else "\n".join(map(str, written)))


def as_json(debrief: DebriefData) -> str:
    """Return the figures of a debrief for programs."""
    return json_text(debrief_figures(debrief), indent=1)


def as_text(debrief: DebriefData) -> str:
    """Return the marks and what each minute cost, for a terminal of 80 columns."""
    beside = sections.how_sure(debrief) + "".join(f", with {aid}" for aid in debrief.aids)
    lines = [f"{debrief.title}: {sections.describe_card(debrief.final)}{beside}"]
    comparison = debrief.compared
    if debrief.familiarisation:
        lines = [f"{debrief.title}: a familiarisation run, without marks"]
    elif comparison is None:
        lines.append("This exercise has no reference crew to compare with.")
    elif comparison.curve is None:
        lines.append(f"There is no curve: {comparison.no_curve}.")
    else:
        lines += terminal_lines(comparison.curve, debrief.step)
    lines += sections.branch_notes(debrief)
    lines += [] if sections.is_of_today(debrief) else [sections.OLDER_RULES]
    lines += [each.told for each in debrief.costs]
    if debrief.manned:
        lines += [f"{one.name}: {one.marks:.0f}, {one.whose}" for one in debrief.task_marks]
    lines += compared_lines(debrief.forms, debrief.final)
    wrapped = (fill(plain(line), TEXT_WIDTH) if len(line) > TEXT_WIDTH else line for line in lines)
    return "\n".join(wrapped)


def read_dossier(path: Path, branch: int | None, width: str | None = None) -> DebriefData:
    """Return the debrief of a recording; ConfigError if it cannot be read."""
    with open_whole_recording(path) as recording:
        return gather_debrief(recording, path, branch, width)


def read_compared(
    path: Path, asked: DebriefRequest, opinions: RunOpinions | None = None
) -> DebriefData:
    """Return the debrief of a recording beside the reference crew's run; ConfigError.

    ``opinions`` stands for what is kept beside the recording.
    """
    with open_whole_recording(path) as recording:
        debrief = gather_debrief(recording, path, asked.branch, asked.width, opinions)
    with told_progress() as progress:
        return compare_debrief(debrief, asked.reference_from, progress)


def write_beside(path: Path, branch: int, progress: Callable[[float], object]) -> DebriefData:
    """Write the page of a branch beside its recording; ConfigError, OSError.

    ``progress`` is told the share of the curve that is known.
    """
    html = default_page_path(path, branch)
    _refuse_other(html)
    debrief = compare_debrief(read_dossier(path, branch), progress=progress)
    write_over(html, render(debrief))
    return debrief


@contextlib.contextmanager
def told_progress() -> Iterator[Callable[[float], object]]:
    """Show on a terminal how much of the curve is known."""
    if not sys.stderr.isatty():
        yield lambda _: None
        return

    def show(share: float) -> None:
        sys.stderr.write(f"\rflying on from each moment of the run ... {share:.0%} ")
        sys.stderr.flush()

    try:
        yield show
    finally:
        sys.stderr.write("\r\x1b[K")


def default_page_path(path: Path, branch: int | None) -> Path:
    """Return where the page of a recording goes unless told otherwise."""
    return path.with_name(path.stem + ("" if branch is None else f".branch{branch}") + ".html")


def opinions_as_asked(path: Path, asked: DebriefRequest) -> RunOpinions:
    """Return what is to be kept beside a recording; ConfigError if it cannot be.

    Some changes of marks are taken back, then others are made.
    """
    changes, forms = read_opinions(path)
    if asked.changes_marks or asked.forms:
        with open_whole_recording(path) as recording:
            plan = plan_of(recording.header())
            branch = find_branch(recording, path, asked.branch).id
        for name in asked.change_back:
            changes = without_changes(changes, name, branch)
        changes = *changes, *(change_of(text, branch, plan) for text in asked.change)
        forms = with_forms(forms, asked.forms, plan)
    return RunOpinions(changes, forms)


def _refuse_other(html: Path) -> None:
    """Refuse to replace, without being told to, what is no debrief."""
    if not html.exists():
        return
    try:
        with html.open(encoding="utf-8", errors="replace") as file:
            ours = PAGE_BADGE in file.read(BADGE_SEARCH_CHARS)
    except OSError:
        ours = False
    if not ours:
        raise ConfigError(f"{html} is there and is no debrief: say --html FILE")


# The track from above: the boat's, the reference crew's, those of the ships that were met


def draw_track(
    debrief: DebriefData, ground: ChartGround, beside: tuple[RunBeside, ...] = ()
) -> Markup:
    """Return the track from above as an SVG element, north up, equal scales both ways."""
    column = debrief.trajectory.columns
    good = np.isfinite(column["x"]) & np.isfinite(column["y"])
    north, east, seconds = column["x"][good], column["y"][good], ground.seconds[good]
    if not seconds.size:
        return Markup()
    others = [_way_of(run, float(seconds[-1])) for run in beside]
    ships = ways_of_ships(debrief.trajectory)
    shown = [*others, *(_near(ship, debrief) for ship in ships)]
    across, up = axes = _equal_axes(
        np.concatenate([east, *(way[0] for way in shown)]),
        np.concatenate([north, *(way[1] for way in shown)]),
    )
    x, y = across.pixels(east), up.pixels(north)
    parts = [text("title", TRACK_SIDE_PX, 16.0, "Track [m], north up")]
    for run, way in zip(beside, others, strict=True):
        parts.append(_path(run.style, across.pixels(way[0]), up.pixels(way[1])))
    step = next(
        (s for s in TIME_MARK_PERIODS_S if seconds[-1] / s <= MAX_TIME_MARKS),
        TIME_MARK_PERIODS_S[-1],
    )
    for ship in ships:
        parts += _ship(ship, axes, step)
    parts += _approaches(debrief, axes)
    for first, after in row_stretches(np.isfinite(ground.broken_seconds[good])):
        parts.append(_path("actual", x[first:after], y[first:after]))
    for begin, end in ground.spans:
        inside = (seconds >= begin) & (seconds <= end)
        if inside.any():
            parts.append(_path("broken", x[inside], y[inside]))
    for second in np.arange(0.0, float(seconds[-1]) + 1e-9, step):
        if any(last < second < after for last, after in ground.holes):
            continue
        index = int(np.searchsorted(seconds, second))
        parts.append(f'<circle class="axis" cx="{x[index]:.1f}" cy="{y[index]:.1f}" r="2.5"/>')
        parts.append(text("tick", x[index] + 6.0, y[index] - 4.0, clock(float(second))))
    return svg_element(
        "The track from above", (CHART_WIDTH_PX, MAX_TRACK_HEIGHT_PX), [*parts, *_rule_of(across)]
    )


def _near(ship: ShipWay, debrief: DebriefData) -> tuple[Numbers, Numbers]:
    """Return the locations of a ship, east and north [m], at which it was near the boat."""
    column = debrief.trajectory.columns
    off = np.hypot(ship.north - column["x"][ship.rows], ship.east - column["y"][ship.rows])
    near = off < CLOSE_RANGE_M
    return ship.east[near], ship.north[near]


def _ship(ship: ShipWay, axes: tuple[Axis, Axis], step: float) -> Iterator[str]:
    """Yield the way of a ship as far as the map goes, its name, and its marks of time."""
    across, up = axes
    x, y = across.pixels(ship.east), up.pixels(ship.north)
    inside = (
        (x > TRACK_SIDE_PX)
        & (x < CHART_WIDTH_PX - TRACK_SIDE_PX)
        & (y > TRACK_ABOVE_PX)
        & (y < MAX_TRACK_HEIGHT_PX - TRACK_BELOW_PX)
    )
    for first, after in row_stretches(inside):
        yield _path("ship", x[first:after], y[first:after])
    if not inside.any():
        return
    last = int(np.flatnonzero(inside)[-1])
    side = "ship-name end" if x[last] > 0.8 * CHART_WIDTH_PX else "ship-name"
    yield text(side, x[last] + (-6.0 if "end" in side else 6.0), y[last] + 12.0, ship.name)
    for second in np.arange(0.0, float(ship.seconds[-1]) + 1e-9, step):
        index = int(np.argmin(np.abs(ship.seconds - second)))
        if inside[index] and abs(ship.seconds[index] - second) < 0.5 * step:
            yield f'<circle class="ship-dot" cx="{x[index]:.1f}" cy="{y[index]:.1f}" r="2.5"/>'
            yield text("tick", x[index] + 6.0, y[index] - 4.0, clock(float(second)))


def _approaches(debrief: DebriefData, axes: tuple[Axis, Axis]) -> Iterator[str]:
    """Yield a line from the boat to each ship where it was nearest, within the map."""
    across, up = axes
    column = debrief.trajectory.columns
    for name, (apart, tick) in meet_ships(debrief.trajectory).closest.items():
        row = debrief.trajectory.row(tick)
        ship = locate_ship(debrief.trajectory, name, tick)
        if ship is None or apart > CLOSE_RANGE_M:
            continue
        boat_at = across.at(float(column["y"][row])), up.at(float(column["x"][row]))
        ship_at = across.at(ship[1]), up.at(ship[0])
        yield rule("approach", *boat_at, *ship_at)
        middle = 0.5 * (boat_at[0] + ship_at[0]), 0.5 * (boat_at[1] + ship_at[1])
        yield text("tick middle", *middle, f"{apart:.0f} m")


def _way_of(run: RunBeside, end: float) -> tuple[Numbers, Numbers]:
    """Return the way of another run up to a time [s]: east and north [m]."""
    column = run.trajectory.columns
    good = np.isfinite(column["x"]) & np.isfinite(column["y"])
    good &= run.trajectory.seconds <= end + 1e-6
    return column["y"][good], column["x"][good]


def _equal_axes(east: Numbers, north: Numbers) -> tuple[Axis, Axis]:
    """Return axes of one scale about the whole track: a turning circle is round."""
    wide, high = (
        CHART_WIDTH_PX - 2.0 * TRACK_SIDE_PX,
        MAX_TRACK_HEIGHT_PX - TRACK_ABOVE_PX - TRACK_BELOW_PX,
    )
    metres = 1.12 * max(float(np.ptp(east)) / wide, float(np.ptp(north)) / high)
    metres = max(metres, MIN_TRACK_WIDTH_M / min(wide, high))
    middle_e = 0.5 * (float(east.min()) + float(east.max()))
    middle_n = 0.5 * (float(north.min()) + float(north.max()))
    half_e, half_n = 0.5 * metres * wide, 0.5 * metres * high
    return (
        Axis(middle_e - half_e, middle_e + half_e, TRACK_SIDE_PX, CHART_WIDTH_PX - TRACK_SIDE_PX),
        Axis(
            middle_n - half_n,
            middle_n + half_n,
            MAX_TRACK_HEIGHT_PX - TRACK_BELOW_PX,
            TRACK_ABOVE_PX,
        ),
    )


def _path(style: str, x: Numbers, y: Numbers) -> str:
    """Return a line through points [px], with no more points than can be told apart."""
    every = max(x.size // MAX_TRACK_POINTS, 1)
    rows = [*range(0, x.size, every), x.size - 1]
    points = "L".join(f"{x[i]:.1f} {y[i]:.1f}" for i in rows)
    return f'<path class="line {style}" d="M{points}"/>'


def _rule_of(across: Axis) -> Iterator[str]:
    """Yield a scale of a round length, labelled with that length."""
    pixels = (across.end - across.begin) / (across.high - across.low)  # [px/m]
    length = step_of(MAX_RULE_SHARE * CHART_WIDTH_PX / pixels, 1)
    length = length if length * pixels <= 2.0 * MAX_RULE_SHARE * CHART_WIDTH_PX else 0.5 * length
    bottom = MAX_TRACK_HEIGHT_PX - 10.0
    yield rule("axis", TRACK_SIDE_PX, bottom, TRACK_SIDE_PX + length * pixels, bottom)
    for end in (TRACK_SIDE_PX, TRACK_SIDE_PX + length * pixels):
        yield rule("axis", end, bottom - 4.0, end, bottom + 4.0)
    yield text("tick", TRACK_SIDE_PX + length * pixels + 8.0, bottom + 4.0, f"{length:g} m")
