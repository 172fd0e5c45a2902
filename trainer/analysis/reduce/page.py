"""A reduction as text for a terminal.

``trainer boat reduce`` prints it: which terms stay and why, which were dropped, and what the set is
worth.
"""

from collections.abc import Iterator, Sequence
from typing import Final

from trainer.analysis.guide.reasons import DropEffect
from trainer.analysis.guide.verdicts import verdict_account
from trainer.analysis.reduce.reduction import Reduction
from trainer.analysis.reduce.verdict import PART_TOLERANCES, LegVerdict
from trainer.report.text import ascii_text, format_number, table, wrap

SENSITIVITY_ROWS: Final = 40  # rows of the table of sensitivities
SENSITIVITY_COLUMNS: Final = (  # columns of that table; JSON has all
    "turn: steady diameter",
    "turn: steady speed",
    "turn: largest roll",
    "meander: pitch peak 1",
    "overshoot: depth change",
    "roll-decay: amplitude after cycle 1",
)
TERMS_PER_LINE: Final = 3  # of the terms kept, each with its factor


def render(found: Reduction) -> str:
    """Return the whole page."""
    lines = [ascii_text(f"REDUCTION: {found.vessel}"), ""]
    if found.sensitivity:
        lines += [*sensitivity(found.sensitivity), ""]
    lines += [*_terms(found), "", *_verdict(found.checked), ""]
    if found.cost:
        lines += wrap(
            f"A tick takes {found.cost.compact_ns:.0f} ns by the compact set, "
            f"{found.cost.full_ns:.0f} ns by the full one: {found.cost.ratio:.2f} of it"
        )
    # a set of which nothing was judged is not called within tolerance
    judged = any(one.judged for one in found.checked)
    conclusion = "Within tolerance" if found.passed else "Out of tolerance"
    lines.append(f"{conclusion if judged else 'Nothing was judged'}.")
    return "\n".join(lines)


def sensitivity(drops: Sequence[DropEffect]) -> list[str]:
    """Return the table of the effects of each coefficient by itself."""
    # each word of a head has a line of its own, so that columns stay narrow
    short = (name.replace("amplitude after ", "").replace(":", "") for name in SENSITIVITY_COLUMNS)
    heads = ["without", *(name.replace("-", " ").replace(" ", "\n") for name in short)]
    rows = []
    for drop in drops[:SENSITIVITY_ROWS]:
        changes = (format_number(drop.percent.get(name), "+.1f") for name in SENSITIVITY_COLUMNS)
        rows.append((drop.coefficient, *changes))
    words = (
        "What each coefficient does by itself: change [%] when it alone is put to zero in the full "
        "set, at the boat's own speed; none where the manoeuvre then has no such number"
    )
    lines, more = [*wrap(words, "", ""), *table(heads, rows)], len(drops) - SENSITIVITY_ROWS
    return [*lines, f"  ... and {more} with less effect"] if more > 0 else lines


def _terms(found: Reduction) -> Iterator[str]:
    """Yield the terms kept, with their factors, and those dropped."""
    yield from wrap(
        f"{len(found.kept)} of this hull's {found.hull_terms} terms are kept; the reduction of "
        f"1969 keeps {found.report_terms}. Factors, + for a term beyond those of 1969:",
        "",
        "",
    )
    cells = [
        f"{one.term}{'' if one.in_1969 else '+'}".ljust(9) + f"{one.factor:8.4g}"
        for one in found.kept
    ]
    for i in range(0, len(cells), TERMS_PER_LINE):
        yield "  " + "    ".join(cells[i : i + TERMS_PER_LINE])
    yield from wrap(f"Dropped: {', '.join(found.dropped)}", "", "  ")
    if found.needs:
        yield ""
        yield "Why terms stay: the worst number without each, the others fitted anew"
        for one in found.needs:
            need = f"{one.worst:.2f} of the allowed, {one.leg}: {one.quantity}"
            yield from wrap(f"{one.term}: {need}")


def _verdict(checked: Sequence[LegVerdict]) -> Iterator[str]:
    """Yield the verdict on the compact set, part by part."""
    for part, percent in PART_TOLERANCES.items():
        of_part = [one for one in checked if one.part == part]
        judged = [one for one in of_part if one.judged]
        failed = [one for one in judged if one.beyond]
        yield from wrap(
            f"{part}, {percent:g} %: manoeuvres within, "
            f"{verdict_account([one.passed for one in of_part])};"
            f" {sum(one.beyond for one in judged)} of {sum(one.judged for one in judged)} numbers "
            "beyond",
            "",
            "  ",
        )
        # all that fail, else the one that comes closest to failing
        for one in failed or sorted(judged, key=lambda each: -each.worst)[:1]:
            yield from wrap(f"{one.leg}: {one.quantity}, {one.worst:.2f} of the allowed")
        for one in of_part:
            if one.undetermined:
                told = ", ".join(one.undetermined)
                yield from wrap(f"{one.leg}: not judged, not determined (below): {told}")
        if unjudged := "; ".join(
            one.leg for one in of_part if not one.judged and not one.undetermined
        ):
            yield from wrap(f"not judged, the full set is lost or cannot start: {unjudged}")
    if apart := sum(len(one.undetermined) for one in checked):
        yield from wrap(
            f"numbers that are not determined: {apart}. One row of the hull's own coefficients, "
            "1 % larger or smaller, moves each by more than is allowed",
            "",
            "  ",
        )
