"""The guide on a terminal: 79 columns of ASCII."""

from trainer.analysis.guide.contents import REDUCED, Guide, Moved, Sheet, tally
from trainer.analysis.guide.verdicts import BEYOND, WITHIN
from trainer.report.text import INDENT, cut, plain, table, wrap

MOST = 20  # entries that moved


def word(passed: bool | None) -> str:  # noqa: FBT001 (a verdict)
    """Return a verdict in words."""
    return {True: "within", False: "BEYOND", None: "not judged"}[passed]


def _row(sheet: Sheet) -> tuple[str, ...]:
    """Return one manoeuvre as a line: verdict, numbers beyond and judged, of each set."""
    cells = []
    for equations in REDUCED:
        beyond = sheet.counted(equations, BEYOND)
        judged = beyond + sheet.counted(equations, WITHIN)
        cells += [word(sheet.passed(equations)), f"{beyond} of {judged}" if judged else "-"]
    return (cut(sheet.title, 40), *cells)


def render(guide: Guide, moves: tuple[Moved, ...] | None) -> str:
    """Return the guide in short; ``moves`` is what moved since a baseline, None without one."""
    heads = ("", "modified", "beyond", "basic", "beyond")
    lines = [plain(f"QUALIFICATION TEST GUIDE: {guide.vessel}"), ""]
    lines += table(heads, [_row(sheet) for sheet in guide.sheets])
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
