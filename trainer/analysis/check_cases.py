"""Check cases flown, laid beside what other programs give for them, and shown.

The first run of a case is the one that all else is laid beside, unless the case says another. A
difference is told with the spread that the case states; who is right, nobody can read off it. A
terminal has tables, the page all runs in one plot.
"""

import time
from collections import defaultdict
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any, Final

import numpy as np
from markupsafe import Markup

from trainer.boat.assemble import Method
from trainer.boat.boat import STATE_OFFSETS, Boat
from trainer.boat.due_orders import entries_due, obey_all
from trainer.boat.world.world import world_of
from trainer.config.exercise.check_case import (
    ANGLE_CHANNELS,
    CASE_CHANNELS,
    CaseRun,
    CheckCase,
    load_case,
    read_outputs,
)
from trainer.config.files import ConfigError, nearest
from trainer.core.digest import core_digest
from trainer.core.kernel import Numbers
from trainer.debrief.marks.rehearsal import stretches
from trainer.report import html, text
from trainer.report.columns import DEPTH_COLUMNS
from trainer.report.panels import draw_panel, legend
from trainer.report.plots import Curve, Panel

STORED_DIGITS: Final = 8  # significant, of outputs in a file of ours
TURN_DEG: Final = 360.0  # [deg]
STILL_SPAN: Final = 1e-9  # of a channel over a case, in its unit, below which nothing is drawn
DIFFERENCE_HEADS: Final = ("channel", "largest difference", "at [s]", "stated spread", "unit", "")
COST_HEADS: Final = ("run", "ticks", "time [ms]", "outputs stored")
READING_TEXT: Final = (
    "A difference is the largest over the times of the case. The spread is what the case states "
    "that two sound computations may be apart; it judges no program. Programs that agree may share "
    "a mistake: a case shows that two are alike, not which of them is right."
)


@dataclass(frozen=True)
class CaseOutputs:
    """The outputs of one run, at the times of its case."""

    name: str
    columns: Mapping[str, Numbers]  # by channel, in its unit
    ticks: int = 0  # flown; 0: they were read from a file
    seconds: float = 0.0  # [s] of this machine that the flight took
    changed: tuple[str, ...] = ()  # channels that are not as the file of this run has them


@dataclass(frozen=True)
class Difference:
    """The largest difference of a channel between two runs, in its unit."""

    channel: str
    largest: float
    at_s: float
    spread: float  # as the case states it


@dataclass(frozen=True)
class Comparison:
    """One run laid beside another."""

    run: str
    beside: str
    stated: bool  # whether the case says the spread of this run, not only of sound runs in general
    differences: tuple[Difference, ...]

    @property
    def beyond(self) -> tuple[str, ...]:
        """Return the channels that differ by more than the spread."""
        return tuple(each.channel for each in self.differences if each.largest > each.spread)


@dataclass(frozen=True)
class CaseFlight:
    """A case with all its runs, and what lies between them."""

    case: CheckCase
    runs: tuple[CaseOutputs, ...]
    comparisons: tuple[Comparison, ...]  # of the case's own runs
    others: tuple[Comparison, ...]  # of files from elsewhere

    @property
    def as_stated(self) -> bool:
        """Return whether the case's own runs are as its files and its spreads say."""
        changed = any(run.changed for run in self.runs)
        return not changed and not any(each.beyond for each in self.comparisons)


def fly_cases(paths: Sequence[Path], others: Sequence[Path] = ()) -> list[CaseFlight]:
    """Return cases flown, files of other programs laid beside them.

    A file NAME.csv or NAME.PROGRAM.csv is of the case NAME; with such files only their cases are
    flown. ConfigError if a case or file is wrong.
    """
    by_case: dict[str, list[Path]] = defaultdict(list)
    names = [path.stem for path in paths]
    for other in others:
        name = other.name.partition(".")[0]
        if name not in names:
            raise ConfigError(
                f"--with {other}: no case {name!r}{nearest(name, names)}; name the file after its "
                f"case, CASE.csv or CASE.PROGRAM.csv: {', '.join(names)}"
            )
        by_case[name].append(other)
    cases = [load_case(path) for path in paths if not others or path.stem in by_case]
    return [fly_case(case, by_case[case.name]) for case in cases]


def fly_case(case: CheckCase, others: Sequence[Path] = ()) -> CaseFlight:
    """Return a case with its runs flown or read, others' files laid beside the first."""
    runs = {run.name: outputs_of(case, run) for run in case.runs}
    first = case.runs[0].name
    strangers = [
        CaseOutputs(path.name, read_outputs(path, case.times, [*case.spread])) for path in others
    ]
    return CaseFlight(
        case=case,
        runs=(*runs.values(), *strangers),
        comparisons=tuple(
            compare(case, runs[run.name], runs[run.beside or first], run.spread)
            for run in case.runs[1:]
        ),
        others=tuple(compare(case, other, runs[first]) for other in strangers),
    )


def outputs_of(case: CheckCase, run: CaseRun) -> CaseOutputs:
    """Return the outputs of a run: flown, or those of its file."""
    path = None if run.file is None else case.path.parent / run.file
    if run.integrator is None and path is not None:
        return CaseOutputs(run.name, read_outputs(path, case.times, [*case.spread]))
    flown = fly_run(case, run)
    if path is None:
        return flown
    stored = read_outputs(path, case.times, [*case.spread])
    changed = [
        name
        for name, values in stored.items()
        if any(map(float.__ne__, map(stored_number, flown.columns[name]), values.tolist()))
    ]
    return CaseOutputs(flown.name, flown.columns, flown.ticks, flown.seconds, tuple(changed))


def stored_number(value: float) -> float:
    """Return a number as the file of a run of ours has it."""
    return float(f"{value:.{STORED_DIGITS}g}")


def boat_of_run(case: CheckCase, run: CaseRun) -> Boat:
    """Return the boat of a run, at the exact start of its case."""
    method = Method(
        case.heading.equations,
        run.rates or "exact",
        "exact",
        run.integrator or "",
        run.step_s or 0.0,
    )
    boat = Boat(case.boat, method)
    boat.sea = case.sea
    start = {
        CASE_CHANNELS[name].state: value / CASE_CHANNELS[name].factor
        for name, value in case.start.items()
    }
    boat.start_from(start, int(case.heading.seed))
    boat.world = world_of(boat, case.world)  # the start would take its ground away
    boat.meet_world()
    return boat


def fly_run(case: CheckCase, run: CaseRun) -> CaseOutputs:
    """Return a run flown; ConfigError if an order is refused, or the boat lost."""
    boat, step = boat_of_run(case, run), run.step_s or 0.0
    offsets = np.array([STATE_OFFSETS[CASE_CHANNELS[name].state] for name in case.spread], np.int64)
    due = entries_due(boat, case.orders)
    ticks = round(case.heading.duration_s / step)
    rows = np.empty((ticks + 1, offsets.size))
    rows[0] = boat.records.state.view(np.float64)[offsets]
    boat.fly(offsets, rows[:0])  # its machine code is loaded here, and not timed
    begun = time.perf_counter()
    with np.errstate(all="ignore"):  # a lost boat is told below
        for tick, until in stretches(0, ticks, due):
            for entry in due.get(tick, ()):
                for words, why in obey_all(boat, [case.orders[entry].order]):
                    raise case.problem(f"[orders[{entry}]] order = {words!r}: refused: {why}")
            if status := boat.fly(offsets, rows[tick + 1 : until + 1]):
                raise case.problem(f"run {run.name}: {boat.failure(status)}")
    spent = time.perf_counter() - begun
    rows = rows[:: round(case.heading.sample_s / step)]
    columns = {name: rows[:, i] * CASE_CHANNELS[name].factor for i, name in enumerate(case.spread)}
    return CaseOutputs(run.name, columns, ticks, spent)


def compare(
    case: CheckCase,
    outputs: CaseOutputs,
    beside: CaseOutputs,
    spread: Sequence[float] | None = None,
) -> Comparison:
    """Return the largest differences of the channels that both runs have."""
    spreads = dict(zip(case.spread, spread or case.spread.values(), strict=True))
    differences = []
    for name in outputs.columns:
        if name not in beside.columns:
            continue
        size = np.abs(outputs.columns[name] - beside.columns[name])
        if name in ANGLE_CHANNELS:
            size = np.minimum(size % TURN_DEG, TURN_DEG - size % TURN_DEG)
        worst = int(np.argmax(size))
        at = float(case.times[worst])
        differences.append(Difference(name, float(size[worst]), at, spreads[name]))
    return Comparison(outputs.name, beside.name, spread is not None, tuple(differences))


def case_figures(flights: Sequence[CaseFlight]) -> dict[str, Any]:
    """Return the figures of cases by their names, for JSON."""
    return {
        flight.case.name: {
            "as_stated": flight.as_stated,
            "ticks": {run.name: run.ticks for run in flight.runs},
            "changed": {run.name: run.changed for run in flight.runs},
            "comparisons": [asdict(each) for each in (*flight.comparisons, *flight.others)],
        }
        for flight in flights
    }


def cases_text(flights: Sequence[CaseFlight]) -> str:
    """Return the cases for a terminal."""
    lines = [line for flight in flights for line in _case_lines(flight)]
    return "\n".join([*lines, *text.wrap(READING_TEXT, "", ""), "", conclusion(flights)])


def conclusion(flights: Sequence[CaseFlight]) -> str:
    """Return in a sentence which cases are not as they are stated."""
    wrong = [flight.case.name for flight in flights if not flight.as_stated]
    of = f"{len(flights)} case{'s' * (len(flights) > 1)}"
    if wrong:
        return f"{len(wrong)} of {of} NOT as stated: {', '.join(wrong)}."
    return f"{of}: this trainer's outputs are those stored, and within the stated spreads."


def _case_lines(flight: CaseFlight) -> Iterator[str]:
    """Yield the lines of one case."""
    heading = flight.case.heading
    yield f"{flight.case.name}: {heading.title}"
    yield f"  {flight.case.boat.name}, {heading.equations} set, {heading.duration_s:g} s"
    yield from text.table(COST_HEADS, _cost_rows(flight))
    for each in (*flight.comparisons, *flight.others):
        title = f"  {each.run}, beside {each.beside}:"
        yield from text.titled_table(title, DIFFERENCE_HEADS, _difference_rows(each))
    yield ""


def _cost_rows(flight: CaseFlight) -> Iterator[tuple[str, ...]]:
    """Yield what each run has cost, and whether its stored outputs still hold."""
    stored = {run.name for run in flight.case.runs if run.integrator and run.file}
    for run in flight.runs:
        if not run.ticks:
            yield (run.name, "read", "", "")
            continue
        kept = "the same" if run.name in stored else "none"
        kept = f"CHANGED: {', '.join(run.changed)}" if run.changed else kept
        yield (run.name, f"{run.ticks}", f"{1000.0 * run.seconds:.1f}", kept)


def _difference_rows(each: Comparison) -> Iterator[tuple[str, ...]]:
    """Yield a row for each channel of a comparison."""
    for one in each.differences:
        beyond = "beyond" if one.channel in each.beyond else ""
        unit, at = CASE_CHANNELS[one.channel].unit, f"{one.at_s:g}"
        yield (one.channel, f"{one.largest:.2e}", at, f"{one.spread:.1e}", unit, beyond)


def cases_page(flights: Sequence[CaseFlight]) -> str:
    """Return the page of HTML."""
    sound = all(flight.as_stated for flight in flights)
    return html.fill_page(
        "check-cases.html",
        "guide.css",
        verdict=html.Cell(conclusion(flights), "good" if sound else "bad"),
        contents=[flight.case.name for flight in flights],
        facts=html.paragraph(f"{READING_TEXT} Flown with the core {core_digest()}.", "soft"),
        parts=[_case_section(flight) for flight in flights],
        data=html.embed_json(case_figures(flights)),
    )


def _case_section(flight: CaseFlight) -> Markup:
    """Return the chapter of one case: what it is, its runs, plots, differences."""
    heading = flight.case.heading
    panels, tables = _panels(flight), []
    for each in (*flight.comparisons, *flight.others):
        tables.append(html.paragraph(f"{each.run} beside {each.beside}"))
        tables.append(html.table(DIFFERENCE_HEADS, _difference_rows(each), "narrow"))
    source = [html.paragraph(f"Source: {heading.source}", "soft")] if heading.source else []
    return html.section(
        flight.case.name,
        f"{flight.case.name}: {heading.title}",
        html.paragraph(heading.mechanism),
        *source,
        html.paragraph(f"{flight.case.boat.name}, {heading.equations} set of equations."),
        html.table(COST_HEADS, _cost_rows(flight), "narrow"),
        html.charts(map(draw_panel, panels)),
        legend(panels[0].curves),
        *tables,
    )


def _panels(flight: CaseFlight) -> list[Panel]:
    """Return a panel for each channel that moves, with all runs that have it."""
    t = flight.case.times
    missing = np.full(t.size, np.nan)
    panels = []
    for name, channel in ((name, CASE_CHANNELS[name]) for name in flight.case.spread):
        runs = [(run.name, run.columns.get(name, missing)) for run in flight.runs]
        if max(float(np.ptp(values)) for _, values in runs if values is not missing) < STILL_SPAN:
            continue
        curves = tuple(Curve(label, t, values) for label, values in runs)
        title = f"{name}: {channel.meaning} [{channel.unit}]"
        downwards = channel.state in DEPTH_COLUMNS
        panels.append(Panel(flight.case.name, "time [s]", title, curves, downwards=downwards))
    return panels
