"""The guide on a terminal: 79 columns of ASCII."""

from collections.abc import Iterator
from itertools import chain

from trainer.analysis.guide.contents import REDUCED, Guide, Sheet, tally
from trainer.analysis.guide.moves import Moved
from trainer.analysis.guide.verdicts import BEYOND, WITHIN
from trainer.report.text import INDENT, cut, plain, table, wrap

MOST = 20  # entries that moved


def verdicts_of(sheet: Sheet) -> Iterator[tuple[str, str]]:
    """Yield the verdict of each reduced set, with its numbers beyond and judged."""
    words = {True: "within", False: "BEYOND", None: "not judged"}
    for equations in REDUCED:
        beyond = sheet.counted(equations, BEYOND)
        judged = beyond + sheet.counted(equations, WITHIN)
        yield words[sheet.passed(equations)], f"{beyond} of {judged}" if judged else "-"


def render(guide: Guide, moves: tuple[Moved, ...] | None) -> str:
    """Return the guide in short; ``moves`` is what moved since a baseline, None without one."""
    heads = ("", "modified", "beyond", "basic", "beyond")
    lines = [plain(f"QUALIFICATION TEST GUIDE: {guide.vessel}"), ""]
    rows = [(cut(sheet.title, 40), *chain(*verdicts_of(sheet))) for sheet in guide.sheets]
    lines += table(heads, rows)
    lines += ["", "FINDINGS OF 1969"]
    for one in guide.findings:
        lines += wrap(f"{one.title}: {one.verdict}; {one.words}")
    if guide.trials:
        lines += ["", f"{len(guide.trials)} published manoeuvres beside ours: in the document"]
    if moves is not None:
        lines += ["", *_moves(moves)]
    for equations in REDUCED:
        told = tally(guide, equations)
        lines += wrap(
            f"{equations}: manoeuvres within tolerance, {told['manoeuvres']}; of their numbers "
            f"{told['within']} within, {told['beyond']} beyond"
        )
    lines.append(f"{guide.conclusion}.")
    return "\n".join(lines)


def _moves(moves: tuple[Moved, ...]) -> list[str]:
    """Return what moved, the most first."""
    if not moves:
        return ["Nothing moved since the baseline."]
    lines = [f"MOVED SINCE THE BASELINE: {len(moves)}"]
    for one in moves[:MOST]:
        lines += wrap(f"{one.what}: {format_entry(one.before)} -> {format_entry(one.after)}")
    if len(moves) > MOST:
        lines.append(f"{INDENT}... and {len(moves) - MOST} more")
    return lines


def format_entry(value: float | str | None) -> str:
    """Return an entry as text."""
    if value is None:
        return "none"
    return value if isinstance(value, str) else f"{value:.6g}"
