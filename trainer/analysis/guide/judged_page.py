"""The guide's chapters on published figures, and what no test can show.

``page`` puts them among its own. Each number links to the line of data, or to the command, that it
comes from; both stand at the end of the page. Chapters have the headings of ITTC 7.5-02-06-03.
"""

from collections.abc import Iterator, Sequence
from functools import cache
from typing import Any, Final

from markupsafe import Markup

from trainer.analysis.guide.contents import SCREEN_PERIODS_S, Guide, GuideContents
from trainer.analysis.guide.validation import (
    COUNTED_VERDICTS,
    FigureRow,
    TrialComparison,
    count_rows,
    ranked_rows,
)
from trainer.analysis.guide.verdicts import MODEL_ERRORS, Validity
from trainer.config.files import parse_toml, read_text, shipped_path
from trainer.report.html import Cell, paragraph, section, table

NO_HISTORY: Final = (
    "No public time history of a free-running submarine exists; what is compared are figures read "
    "from papers."
)
VALIDITY_STYLES: Final = {
    **dict.fromkeys(MODEL_ERRORS, "bad"),
    Validity.NOISE: "good",
    Validity.UNCERTAIN: "soft",
    Validity.NOT_JUDGED: "soft",
}
STATEMENTS_NAME: Final = "guide-statements"
PREDICTED_TITLE: Final = "Forces predicted: coefficients and masses"
SIGNATURE: Final = "{}: ____________________  Signature: ____________________  Date: __________"
NEEDLE_HEADS: Final = ("mean [s]", "most [s]")
WORST_HEADS: Final = ("D", "S", "E", "u_val", "|E| of D", "verdict", "use")
FIGURE_HEADS: Final = ("quantity", *WORST_HEADS, "u_num", "order", "u_input", "u_D")


@cache
def _statements() -> Any:
    """Return what the guide states in words, by the tables of its file."""
    path = shipped_path("", STATEMENTS_NAME)
    return parse_toml(read_text(path), path.name)


def _words(name: str) -> Markup:
    """Return the words of a chapter as a paragraph."""
    return paragraph(_statements()["words"][name])


def link(text: str, anchor: str) -> Markup:
    """Return a link within the page; the text alone where there is no anchor."""
    return Markup('<a href="#{}">{}</a>').format(anchor, text) if anchor else Markup.escape(text)


def _number(value: float | None, none: str = "none") -> str:
    """Return a number as it is shown."""
    return none if value is None else f"{value:.4g}"


def validation(book: GuideContents) -> Markup:
    """Return the first page: how many figures are how far off, the worst first."""
    guide = book.guide
    if not guide.trials:
        found = book.published.provenance.nothing_found if book.published else ""
        words = paragraph("Nothing published of this boat is beside ours: nothing is validated.")
        return section("validation", "Published figures", words, paragraph(found))
    worst = [
        [
            Markup("{}, {}").format(
                row.figure.quantity, link(one.title, f"trial-{guide.trials.index(one)}")
            ),
            *_verdict_cells(guide, one, row),
            row.figure.use,
        ]
        for one, row in ranked_rows(guide.trials)
        if row.verdict in (*MODEL_ERRORS, Validity.UNCERTAIN)
    ]
    return section(
        "validation",
        "Published figures",
        paragraph(NO_HISTORY),
        *(paragraph(f"{doubt}.", "bad") for doubt in guide.doubts),
        table(("figures", "compared", *COUNTED_VERDICTS), count_rows(guide.trials), "narrow"),
        paragraph("Model errors and what is too uncertain to judge, the worst first:"),
        table(("figure", *WORST_HEADS), worst, "figures"),
    )


def _verdict_cells(guide: Guide, one: TrialComparison, row: FigureRow) -> list[str | Cell]:
    """Return data, simulation, error, its uncertainty and the verdict of a figure."""
    words = "below the noise" if row.verdict is Validity.NOISE else row.verdict.value
    if row.verdict is Validity.MODEL_ERROR:
        words = f"{words} {row.error:+.2g} +- {row.u_val:.2g}"
    return [
        link(f"{_number(row.figure.value)} {row.figure.unit}", f"data-{row.figure.line}"),
        link(_number(row.ours), f"command-{guide.trials.index(one)}"),
        "" if row.error is None else f"{row.error:+.3g}",
        _number(row.u_val, "-"),
        "-" if row.error is None else f"{row.percent:.0f} %",
        Cell(words, VALIDITY_STYLES[row.verdict]),
    ]


def benchmark(book: GuideContents) -> Markup:
    """Return every published figure beside ours, with what was fitted."""
    guide, published = book.guide, book.published
    if published is None:
        return section("published", "Benchmark data", paragraph("There is none for this boat."))
    told = published.provenance
    dated = f"Fitted and held out as of {told.judged}, of the boat {told.digest}."
    fits = [f"{', '.join(fit.coefficients)}: fitted to {fit.to}." for fit in published.fits]
    words = [dated, *(fits or ["Nothing is fitted."]), told.nothing_found]
    parts = [_words("benchmark"), paragraph(" ".join(filter(None, words)))]
    spreads = book.spreads.spreads if book.spreads else ()
    lines = {(one.title, one.quantity): f"input-{one.line}" for one in spreads}
    for i, one in enumerate(guide.trials):
        rows = [
            (
                row.figure.quantity,
                *_verdict_cells(guide, one, row),
                row.figure.use,
                _number(row.u_num),
                "-" if row.order is None else f"{row.order:.1f}",
                link(_number(row.u_input, "-"), lines.get((one.title, row.figure.quantity), "")),
                link(_number(row.figure.u), f"data-{row.figure.line}"),
            )
            for row in one.rows
        ]
        parts.append(Markup('<h3 id="trial-{}">{}</h3>\n').format(i, one.title))
        parts += [paragraph(f"{one.source}.", "soft"), table(FIGURE_HEADS, rows, "figures")]
    return section("published", "Benchmark data", *parts)


def predicted(book: GuideContents) -> Markup:
    """Return what each coefficient and mass rests on, and one standard deviation of it."""
    rows = [
        (
            one.name,
            f"{one.value:.4g}",
            link(f"{one.sd:.2g}", f"input-{one.line}"),
            f"{100.0 * one.sd / abs(one.value):.0f} %",
            one.reason,
        )
        for one in (book.spreads.inputs if book.spreads else ())
    ]
    told = _stored(("number", "value", "sd", "of it", "reason"), rows)
    return section("predicted", PREDICTED_TITLE, _words("predicted"), told)


def _stored(heads: tuple[str, ...], rows: Sequence[tuple[str, ...]]) -> Markup:
    """Return rows of the stored table of spreads; a sentence where there are none."""
    if not rows:
        return paragraph("None are stored for this boat.")
    return table(heads, rows, "reasons")


def causes(book: GuideContents) -> Markup:
    """Return what the uncertainty of each figure goes with."""
    spreads = book.spreads
    rows = [
        (
            f"{one.quantity}, {one.title}",
            link(f"{one.u_input:.3g}", f"input-{one.line}"),
            f"{one.members} of {spreads.members}",
            ", ".join(f"{name} {share:.0%}" for name, share in one.causes) or "none alone",
        )
        for one in (spreads.spreads if spreads else ())
        if spreads
    ]
    told = _stored(("figure", "u_input", "boats that have it", "largest causes"), rows)
    return section("causes", "Causes of error, sensitivity", _words("causes"), told)


def delays(guide: Guide) -> Markup:
    """Return the sheet of transport delays."""
    rows = []
    for sheet in guide.delays:
        ticks = sheet.control_ticks, sheet.motion_ticks
        seconds = [sheet.mean_s(ticks[1])]
        for screen in SCREEN_PERIODS_S:
            seconds += [sheet.mean_s(ticks[0], screen), sheet.most_s(ticks[0], screen)]
        numbers = [_number(value, "-") for value in (*ticks, *seconds)]
        rows.append((sheet.control, f"{sheet.step_s:g} s", *numbers, sheet.problem))
    needles = [f"needle, {screen}, {what}" for screen in SCREEN_PERIODS_S for what in NEEDLE_HEADS]
    heads = ("control", "step", "ticks to control", "to motion", "motion, mean [s]", *needles, "")
    return section("delays", "Transport delay", _words("delays"), table(heads, rows))


def statements() -> Iterator[Markup]:
    """Yield the statement of compliance, and the subjective checks with places to sign."""
    told = _statements()
    compliance = [(one["subject"], one["words"], one["basis"]) for one in told["statements"]]
    checks = [(one["check"], one["fly"], "yes / no", "", "") for one in told["checks"]]
    yield section(
        "compliance",
        "Statement of compliance",
        _words("compliance"),
        table(("subject", "statement", "basis"), compliance, "reasons"),
        paragraph(SIGNATURE.format("For the program")),
    )
    heads = ("check", "flown by", "satisfied", "remarks", "name, signature, date")
    yield section(
        "subjective",
        "Subjective checks",
        _words("subjective"),
        table(heads, checks, "reasons sign"),
        paragraph(SIGNATURE.format("Evaluator")),
    )


def sources(book: GuideContents) -> Markup:
    """Return the rows of data and the commands to which numbers link."""
    parts = [_lines("command", [one.command for one in book.guide.trials], "Commands of S", 0)]
    if book.published:
        parts.append(_lines("data", book.published.text.split("\n"), book.published.file, 1))
    if book.spreads:
        parts.append(_lines("input", book.spreads.text.split("\n"), book.spreads.file, 1))
    return section("sources", "Rows of data and commands", *parts)


def _lines(name: str, lines: Sequence[str], title: str, first: int) -> Markup:
    """Return numbered lines to which links lead."""
    row = Markup('<span id="{}-{}">{:4d}  {}</span>')
    rows = Markup("\n").join(row.format(name, i, i, line) for i, line in enumerate(lines, first))
    return Markup("<h3>{}</h3>\n<pre>{}</pre>\n").format(title, rows)
