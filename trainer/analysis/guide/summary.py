"""The guide on a terminal: 79 columns of ASCII.

``trainer boat guide`` prints it beside the HTML page, for somebody who waits for the verdict.
"""

from collections.abc import Iterator
from itertools import chain

from trainer.analysis.guide.contents import REDUCED_SETS, Guide, LegSheet, tally_set
from trainer.analysis.guide.moves import GuideMove
from trainer.analysis.guide.validation import count_lines, ranked_rows
from trainer.analysis.guide.verdicts import BEYOND_TOLERANCE, WITHIN_TOLERANCE
from trainer.report.text import INDENT, ascii_text, cut_text, table, wrap

MAX_MOVES_SHOWN = 20  # entries that moved
MAX_FIGURES_SHOWN = 10  # published figures, the worst


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
    lines = [ascii_text(f"QUALIFICATION TEST GUIDE: {guide.vessel}"), ""]
    rows = [(cut_text(sheet.title, 40), *chain(*verdicts_of(sheet))) for sheet in guide.sheets]
    lines += table(heads, rows)
    lines += ["", "FINDINGS OF 1969"] if guide.findings else [""]
    for one in guide.findings:
        lines += wrap(f"{one.title}: {one.verdict}; {one.words}")
    if guide.trials:
        lines += ["", "PUBLISHED FIGURES", *_figures(guide)]
    if moves is not None:
        lines += ["", *_moves(moves)]
    for equations in REDUCED_SETS:
        counts = tally_set(guide, equations)
        lines += wrap(
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
        for text in (*count_lines(guide.trials), *guide.doubts, *worst)
        for line in wrap(ascii_text(text))
    ]


def _moves(moves: tuple[GuideMove, ...]) -> list[str]:
    """Return the changes as lines, the largest first."""
    if not moves:
        return ["Nothing moved since the baseline."]
    lines = [f"MOVED SINCE THE BASELINE: {len(moves)}"]
    for one in moves[:MAX_MOVES_SHOWN]:
        lines += wrap(f"{one.what}: {format_entry(one.before)} -> {format_entry(one.after)}")
    if len(moves) > MAX_MOVES_SHOWN:
        lines.append(f"{INDENT}... and {len(moves) - MAX_MOVES_SHOWN} more")
    return lines


def format_entry(value: float | str | None) -> str:
    """Return an entry as text."""
    if value is None:
        return "none"
    return value if isinstance(value, str) else f"{value:.6g}"
