"""The guide as one HTML page that needs nothing else, and in short.

``trainer boat guide`` writes it from ``contents``, and prints 79 columns of ASCII beside it, for
somebody who waits for the verdict. Figures and verdicts are made there; here they become tables,
charts and sentences.
"""

from collections.abc import Iterator
from dataclasses import asdict
from itertools import chain
from typing import Final

from markupsafe import Markup

from trainer.analysis.guide import judged_page
from trainer.analysis.guide.contents import (
    REDUCED_SETS,
    Guide,
    GuideContents,
    GuideMove,
    LegSheet,
    stand_alone,
    tally_set,
)
from trainer.analysis.guide.findings import ClaimVerdict
from trainer.analysis.guide.programme import SET_METHODS, Leg
from trainer.analysis.guide.validation import count_lines, flight_command, ranked_rows
from trainer.analysis.guide.verdicts import (
    BEYOND_TOLERANCE,
    NOT_JUDGED,
    WITHIN_TOLERANCE,
    Judgement,
)
from trainer.analysis.manoeuvres.catalogue import format_parameters
from trainer.analysis.manoeuvres.flight import Flight
from trainer.analysis.programs import characteristic, neutral, thrust
from trainer.report import text
from trainer.report.columns import figure, page_unit
from trainer.report.html import (
    Cell,
    charts,
    embed_json,
    fill_page,
    paragraph,
    section,
    table,
)
from trainer.report.panels import draw_panel, legend
from trainer.report.plots import TRACK_TITLE, Curve, Panel

CLAIM_STYLES: Final = {
    ClaimVerdict.HOLDS: "good",
    ClaimVerdict.HOLDS_IN_PART: "soft",
    ClaimVerdict.FAILS: "bad",
    ClaimVerdict.NOT_SHOWN: "soft",
}
VERDICT_STYLES: Final = {WITHIN_TOLERANCE: "good", BEYOND_TOLERANCE: "bad", NOT_JUDGED: "soft"}
COLUMN_NAMES: Final = {
    "t": "time",
    "u": "speed ahead",
    "v": "sway",
    "w": "heave",
    "p": "roll rate",
    "q": "pitch rate",
    "r": "yaw rate",
    "x": "run north",
    "y": "run east",
    "z": "depth from the start",
    "phi": "roll",
    "theta": "pitch",
    "psi": "heading",
    "delta_r": "rudder",
    "delta_s": "stern planes",
    "delta_b": "bow planes",
}
MAX_MOVES_SHOWN = 300  # rows of the table of changes
MAX_MOVES_PRINTED = 20  # entries that moved, on a terminal
MAX_FIGURES_SHOWN = 10  # published figures there, the worst
MIN_SHOWN_PERCENT = 0.05  # [%] a smaller effect is 0.0 in the one decimal that is shown
CHAPTER_TITLES: Final = {  # in the order of the page
    "validation": "Published figures",
    "predicted": judged_page.PREDICTED_TITLE,
    "findings": "Forces modelled: what was found in 1969",
    "why": "Forces modelled: why the reduced sets differ",
    "programs": "Forces modelled: neutral angles, modes, thrust",
    "steps": "Integration: steps and methods",
    "software": "Software",
    "delays": "Transport delay",
    "published": "Benchmark data",
    "causes": "Causes of error, sensitivity",
    "compliance": "Statement of compliance",
    "subjective": "Subjective checks",
    "overview": "Manoeuvres: the reduced sets beside the full one",
    "sources": "Rows of data and commands",
}


def verdicts_of(sheet: LegSheet) -> Iterator[tuple[str, str]]:
    """Yield the verdict of each reduced set, with its numbers beyond and judged."""
    words = {True: "within", False: "BEYOND", None: "not judged"}
    for equations in REDUCED_SETS:
        beyond = sheet.counted(equations, BEYOND_TOLERANCE)
        judged = beyond + sheet.counted(equations, WITHIN_TOLERANCE)
        yield words[sheet.passed(equations)], f"{beyond} of {judged}" if judged else "-"


def render(guide: Guide, moves: tuple[GuideMove, ...] | None) -> str:
    """Return the guide in short; ``moves`` are the changes since a baseline, None without one."""
    heads = ("", "modified", "beyond", "basic", "beyond")
    lines = [text.ascii_text(f"QUALIFICATION TEST GUIDE: {guide.vessel}"), ""]
    rows = [(text.cut_text(sheet.title, 40), *chain(*verdicts_of(sheet))) for sheet in guide.sheets]
    lines += text.table(heads, rows)
    lines += ["", "FINDINGS OF 1969"] if guide.findings else [""]
    for one in guide.findings:
        lines += text.wrap(f"{one.title}: {one.verdict}; {one.words}")
    if guide.trials:
        lines += ["", "PUBLISHED FIGURES", *_figures(guide)]
    if moves is not None:
        lines += ["", *_moves(moves)]
    for equations in REDUCED_SETS:
        counts = tally_set(guide, equations)
        lines += text.wrap(
            f"{equations}: manoeuvres within tolerance, {counts['manoeuvres']}; of their numbers "
            f"{counts['within']} within, {counts['beyond']} beyond"
        )
    lines.append(f"The compact set beside the full one: {guide.conclusion}.")
    return "\n".join(lines)


def _figures(guide: Guide) -> list[str]:
    """Return how many published figures are how far off, and the worst of them."""
    worst = [
        f"{row.percent:.0f} % {row.figure.quantity} ({one.title}): {row.verdict}, {row.figure.use}"
        for one, row in ranked_rows(guide.trials)[:MAX_FIGURES_SHOWN]
    ]
    return [
        line
        for words in (*count_lines(guide.trials), *guide.doubts, *worst)
        for line in text.wrap(text.ascii_text(words))
    ]


def _moves(moves: tuple[GuideMove, ...]) -> list[str]:
    """Return the changes as lines, the largest first."""
    if not moves:
        return ["Nothing moved since the baseline."]
    lines = [f"MOVED SINCE THE BASELINE: {len(moves)}"]
    for one in moves[:MAX_MOVES_PRINTED]:
        lines += text.wrap(f"{one.what}: {format_entry(one.before)} -> {format_entry(one.after)}")
    if len(moves) > MAX_MOVES_PRINTED:
        lines.append(f"{text.INDENT}... and {len(moves) - MAX_MOVES_PRINTED} more")
    return lines


def format_entry(value: float | str | None) -> str:
    """Return an entry as text."""
    if value is None:
        return "none"
    return value if isinstance(value, str) else f"{value:.6g}"


def anchor(title: str) -> str:
    """Return where a link to a manoeuvre leads."""
    return title.replace(" ", "-").replace(",", "")


def software(guide: Guide) -> Markup:
    """Return what the guide is made from, and by what the program is checked."""
    versions = ", ".join(f"{name} {value}" for name, value in guide.versions.items())
    rows = [("made", guide.made), ("step", f"{guide.step_s:g} s"), ("versions", versions)]
    rows += [(f"sha256 of {name}", value) for name, value in guide.checksums.items()]
    words = (
        "The program is compared with others by trainer boat check-cases; trainer dev conform says "
        "what of STCW it has."
    )
    facts = table((), rows, "facts")
    return section("software", CHAPTER_TITLES["software"], facts, paragraph(words))


def overview(guide: Guide) -> Markup:
    """Return one line for each manoeuvre."""
    rows: list[list[str | Cell]] = []
    for sheet in guide.sheets:
        row: list[str | Cell] = [sheet.title]
        for told, share in verdicts_of(sheet):
            row += [_verdict(told), share]
        rows.append(row)
    heads = ("manoeuvre", "modified set", "numbers beyond", "basic set", "numbers beyond")
    totals = []
    for equations in REDUCED_SETS:
        count = tally_set(guide, equations)
        totals.append(
            f"The {equations} set: manoeuvres within tolerance, {count['manoeuvres']}; "
            f"{count['within']} numbers within, {count['beyond']} beyond, {count['shown']} shown "
            "and not judged."
        )
    words = (
        "The full set is flown with exact accelerations by Runge and Kutta, the reduced sets with "
        "lagged ones by second-order Adams, all at the boat's own step, each from its own trim and "
        "with the boat's own rudder, planes and engine. Tolerances are those of 1969: 5 % of "
        "change, swings 5 % of the first peak, zero crossings 5 s; phase is not judged. Events are "
        "seen at the starts of cycles: a reduced set is flown beside the full one and takes its "
        "time of an event that its own is not more than a cycle from. Where the full set itself is "
        "lost nothing is judged; nor is a number of the modified set, beyond by its own "
        "difference, which the full set itself moves beyond when one row of its coefficients "
        "changes by 1 %."
    )
    paragraphs = map(paragraph, (*totals, words))
    return section("overview", CHAPTER_TITLES["overview"], *paragraphs, table(heads, rows))


def since_baseline(found: tuple[GuideMove, ...]) -> Markup:
    """Return the chapter of numbers and verdicts that changed since the baseline."""
    if not found:
        return section("moved", "Since the baseline", paragraph("Nothing moved."))
    rows = []
    for one in found[:MAX_MOVES_SHOWN]:
        change = "" if one.percent is None else f"{one.percent:+.3g} %"
        rows.append((one.what, format_entry(one.before), format_entry(one.after), change))
    words = f"{len(found)} entries are not what they were, SI and radians; the first are shown."
    heads = ("what", "before", "now", "change")
    return section("moved", "Since the baseline", paragraph(words), table(heads, rows))


def findings(guide: Guide) -> Markup:
    """Return the chapter of the findings of 1969, each with its verdict on this hull."""
    parts, head = [], Markup('<h3>{}: <span class="{}">{}</span></h3>\n')
    for one in guide.findings:
        parts.append(head.format(one.title, CLAIM_STYLES[one.verdict], one.verdict))
        parts.append(paragraph(f"1969: {one.claim}.", "soft"))
        parts.append(paragraph(f"Here: {one.words}."))
        if one.rows:
            parts.append(table(one.heads, one.rows, "numbers narrow"))
    return section("findings", CHAPTER_TITLES["findings"], *parts)


def drops(guide: Guide) -> Markup:
    """Return the table of the effects of each dropped coefficient."""
    columns = list(guide.drops[-1].percent)  # the last row is all of them together: always there
    heads = ("coefficient", "value", *(f"{name} [%]" for name in columns))
    rows = []
    for drop in guide.drops:
        value = f"{drop.value:.4g}" if drop.value else ""
        rows.append((drop.coefficient, value, *(_percent(drop.percent[name]) for name in columns)))
    words = (
        "What each coefficient that the modified set drops does by itself: changes when it alone "
        "is put to zero in the full set, at the boat's start speed. Those that change nothing by "
        "0.1 % are left out."
    )
    return section("why", CHAPTER_TITLES["why"], paragraph(words), table(heads, rows))


def _percent(value: float | None) -> str:
    """Return an effect [%] in one decimal, "-" for none."""
    if value is None:
        return "-"
    return f"{value:+.1f}" if abs(value) >= MIN_SHOWN_PERCENT else "0"


def steps(guide: Guide) -> Markup:
    """Return the step-size study."""
    sizes = sorted({run.step_s for run in guide.steps})
    rows: list[tuple[str | Cell, ...]] = []
    last = ""
    for case, scheme, rates in dict.fromkeys((r.case, r.scheme, r.rates) for r in guide.steps):
        key = case, scheme, rates
        runs = {run.step_s: run for run in guide.steps if (run.case, run.scheme, run.rates) == key}
        # a case has a row for each scheme; its name stands in the first of them alone
        cells: list[str | Cell] = ["" if case == last else case, f"{scheme}, {rates}"]
        last = case
        for size in sizes:
            run = runs[size]
            style = {"fine": "good", "coarse": "soft"}.get(run.verdict, "bad")
            digits = ".0f" if run.percent is not None and run.percent >= 10.0 else ".2g"
            error = "" if run.percent is None else f"{run.percent:{digits}} % {run.worst}, "
            cells.append(Cell(error + run.verdict, style))
        rows.append(tuple(cells))
    heads = ("case", "method, accelerations", *(f"{size:.3g} s" for size in sizes))
    words = (
        "The worst error of any extreme or last value, in % of how much that quantity changes, "
        "against Runge and Kutta at a tenth of the boat's step; full set, controls that act at "
        "once. Up to 1 % is fine, beyond 5 % of no use."
    )
    return section("steps", CHAPTER_TITLES["steps"], paragraph(words), table(heads, rows, "steps"))


def programs(book: GuideContents) -> Markup:
    """Return neutral angles, modes and thrust."""
    guide, file = book.guide, book.file
    figure = Markup("<figure><figcaption>{}</figcaption>{}{}</figure>")
    angles = neutral.render(guide.neutral), neutral.panels(file, guide.neutral)
    modes = characteristic.render(guide.modes), characteristic.panels(guide.modes)
    pushes = thrust.render(guide.thrust), thrust.panels(file, guide.thrust)
    parts = []
    for name, (listing, drawn) in (
        ("Neutral angles and critical speeds (EC470)", angles),
        ("Modes (EC140, EC200, EC320)", modes),
        ("Thrust less drag (ZC300)", pushes),
    ):
        figures = [
            figure.format(panel.title, draw_panel(panel), legend(panel.curves)) for panel in drawn
        ]
        parts.append(Markup("<h3>{}</h3>\n").format(name))
        parts += [charts(figures), Markup("<pre>{}</pre>\n").format(listing)]
    return section("programs", CHAPTER_TITLES["programs"], *parts)


def manoeuvres(book: GuideContents) -> Iterator[Markup]:
    """Yield the chapter of every leg."""
    for leg, sheet in zip(book.legs, book.guide.sheets, strict=True):
        yield _leg(book, leg, sheet)


def _leg(book: GuideContents, leg: Leg, sheet: LegSheet) -> Markup:
    """Return one manoeuvre: what was ordered, charts and numbers.

    The first line of a manoeuvre's docstring is its description on the page.
    """
    wanted = {each: book.flown[leg.task(book.file, each)] for each in SET_METHODS}
    flights = {each: flight for each, flight in wanted.items() if not isinstance(flight, str)}
    parameters = format_parameters(sheet.parameters)
    about = (type(leg.manoeuvre).__doc__ or "").splitlines()[0]
    command = flight_command(book.file, leg.name, leg.task(book.file, "full"))
    parts = [paragraph(f"{about} [{parameters}; degrees, seconds, knots]", "soft")]
    parts.append(paragraph(f"The full set alone: {command}", "soft"))
    losses = {name: flight.lost for name, flight in flights.items() if flight.lost}
    for problems in (sheet.problems, losses):
        parts += [paragraph(f"{name}: {problem}") for name, problem in problems.items()]
    if flights:
        pictures = _panels(leg.manoeuvre.shows, flights)
        parts.append(legend(pictures[0].curves) + charts(draw_panel(panel) for panel in pictures))
    heads = ("quantity", "unit", "full", "modified", "difference", "", "basic", "difference", "")
    parts.append(table(heads, _rows(sheet)))
    return section(anchor(leg.title), leg.title, *parts)


def _rows(sheet: LegSheet) -> list[list[str | Cell]]:
    """Return the numbers of a sheet, both reduced sets side by side."""
    by_set = {
        set_name: {one.quantity: one for one in sheet.judgements.get(set_name, ())}
        for set_name in REDUCED_SETS
    }
    rows = []
    for quantity in dict.fromkeys(name for found in by_set.values() for name in found):
        present = [found[quantity] for found in by_set.values() if quantity in found]
        one = present[0]
        unit = one.unit.replace("rad", "deg")
        cells: list[str | Cell] = [quantity, unit, figure(one.full, one.unit)]
        for found in by_set.values():
            cells += _judgement_cells(found.get(quantity))
        rows.append(cells)
    return rows


def _judgement_cells(one: Judgement | None) -> list[str | Cell]:
    """Return value, difference and verdict of one number."""
    if one is None:
        return ["-", "", ""]
    difference = one.difference
    told_difference = ""
    if difference is not None and one.full:
        told_difference = f"{100.0 * difference / abs(one.full):+.1f} %"
        if one.unit == "s":  # as the tolerance of zero crossings is given
            told_difference = f"{difference:+.1f} s"
    return [figure(one.other, one.unit), told_difference, _verdict(one.verdict)]


def html_page(book: GuideContents, moves: tuple[GuideMove, ...] | None) -> str:
    """Return the page; ``moves`` are the changes since a baseline, None without one."""
    guide = book.guide
    since = [] if moves is None else [since_baseline(moves)]
    names = CHAPTER_TITLES | ({} if moves is None else {"moved": "Since the baseline"})
    if stand_alone(book.legs):
        names = {name: names[name] for name in names if name in ("overview", "software", "moved")}
        parts = [*since, overview(guide), *manoeuvres(book), software(guide)]
    else:
        parts = _chapters(book, since)
    return fill_page(
        "guide.html",
        "guide.css",
        vessel=guide.vessel,
        verdict=Cell(guide.conclusion, "good" if guide.passed else "bad"),
        made=guide.made,
        contents=names.items(),
        legs=[(anchor(leg.title), leg.title) for leg in book.legs],
        parts=parts,
        data=embed_json(asdict(guide)),
    )


def _chapters(book: GuideContents, since: list[Markup]) -> list[Markup]:
    """Return the chapters of a whole guide; ``since`` is that on changes, if there is one."""
    guide = book.guide
    return [
        judged_page.validation(book),
        *since,
        judged_page.predicted(book),
        findings(guide),
        drops(guide),
        programs(book),
        steps(guide),
        software(guide),
        judged_page.delays(guide),
        judged_page.benchmark(book),
        judged_page.causes(book),
        *judged_page.statements(),
        overview(guide),
        *manoeuvres(book),
        judged_page.sources(book),
    ]


def _panels(shows: tuple[str, ...], flights: dict[str, Flight]) -> tuple[Panel, ...]:
    """Return the panels of a manoeuvre, a curve for each flight; depth from its start."""
    panels = []
    for name in shows:
        if name != TRACK_TITLE and not all(flight.has(name) for flight in flights.values()):
            continue
        curves = []
        for label, flight in flights.items():
            factor, _ = page_unit(name)
            if name == TRACK_TITLE:  # as on a chart: north (x) up, east (y) to the right
                curves.append(Curve(label, flight.column("y"), flight.column("x")))
                continue
            values = flight.change(name) if name == "z" else flight.column(name)
            curves.append(Curve(label, flight.t, factor * values))
        if name == TRACK_TITLE:
            panels.append(Panel(TRACK_TITLE, "east [m]", "track, north [m]", tuple(curves)))
        else:
            title = f"{COLUMN_NAMES[name]} [{page_unit(name)[1]}]"
            panels.append(Panel(title, "time [s]", title, tuple(curves), downwards=name == "z"))
    return tuple(panels)


def _verdict(name: str) -> Cell:
    """Return a verdict as a cell: a word, and a colour beside it."""
    return Cell(name, VERDICT_STYLES.get(name, "soft"))
