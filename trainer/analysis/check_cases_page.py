"""Check cases for a terminal and as a page, all runs in one plot."""

from collections.abc import Iterator, Sequence
from typing import Final

import numpy as np
from markupsafe import Markup

from trainer.analysis.check_cases import CaseFlight, Comparison, case_figures
from trainer.config.check_case import CASE_CHANNELS
from trainer.core.digest import core_digest
from trainer.report import html, text
from trainer.report.columns import DEPTH_COLUMNS
from trainer.report.panels import draw_panel, legend
from trainer.report.plots import Curve, Panel

STILL_SPAN: Final = 1e-9  # of a channel over a case, in its unit, below which nothing is drawn
DIFFERENCE_HEADS: Final = ("channel", "largest difference", "at [s]", "stated spread", "unit", "")
COST_HEADS: Final = ("run", "ticks", "time [ms]", "outputs stored")
READING_TEXT: Final = (
    "A difference is the largest over the times of the case. The spread is what the case states "
    "that two sound computations may be apart; it judges no program. Programs that agree may share "
    "a mistake: a case shows that two are alike, not which of them is right."
)


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
