"""A reduction as text: for a terminal, and as tables of a vessel file.

``trainer boat reduce`` prints it: which terms stay and why, which were dropped, and what the set is
worth. It writes the tables into a file whose other text stays, because a user's comments and order
of keys must survive.
"""

import re
import textwrap
from collections.abc import Iterator, Mapping, Sequence
from typing import Final

from trainer import __version__
from trainer.analysis.guide.reasons import DropEffect
from trainer.analysis.guide.verdicts import verdict_account
from trainer.analysis.reduce.reduction import PART_TOLERANCES, LegVerdict, Reduction
from trainer.analysis.reduce.search import TermNeed
from trainer.config.files import toml_value
from trainer.core.terms import EXTRA_TERMS, SLIP_TERMS
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
REDUCTION_TABLES: Final = ("compact", "compensation.modified", "compensation.basic", "reduction")
TABLE_HEADER: Final = re.compile(r"\s*\[\[?\s*([^\]]+?)\s*\]")
LINE_WIDTH: Final = 96  # [characters] of the lines written
COEFFICIENTS_HEADER: Final = re.compile(r"^\[coefficients", re.MULTILINE)


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


def rewrite_vessel(text: str, tables: str) -> str:
    """Return the text of a vessel file with its reduction replaced by ``tables``."""
    kept_text = "\n".join(_without_ours(text.splitlines()))
    kept_text = re.sub(r"\n{3,}", "\n\n", kept_text)
    first = COEFFICIENTS_HEADER.search(kept_text)
    if not first:
        return f"{kept_text.rstrip()}\n\n{tables}"
    index = _above_comments(kept_text, first.start())
    return f"{kept_text[:index].rstrip()}\n\n{tables}\n{kept_text[index:].rstrip()}\n"


def _above_comments(text: str, index: int) -> int:
    """Return the start of the comment lines right above ``index``."""
    lines = text[:index].split("\n")[:-1]
    while lines and lines[-1].startswith("#"):
        index -= len(lines.pop()) + 1
    return index


def _without_ours(lines: Sequence[str]) -> Iterator[str]:
    """Yield the lines outside the reduction's tables; comments of other tables stay."""
    ours = False
    for line in lines:
        header = TABLE_HEADER.match(line)
        if header:
            ours = header[1].replace(" ", "") in REDUCTION_TABLES
        if not ours or line.startswith("#"):
            yield line


def factor_tables(
    factors: Mapping[str, Mapping[str, float]],
    needs: Sequence[TermNeed],
    notes: Mapping[str, float],
) -> str:
    """Return the tables of a reduction's ``factors`` by equation set and term. 0: dropped.

    The evidence names what would be worst without each term beyond those of 1969.
    """
    extra = [name for name in EXTRA_TERMS if factors["modified"].get(name)]
    names, indent = " ".join(f'"{name}",' for name in extra), " " * 4
    rows = textwrap.wrap(names, LINE_WIDTH, initial_indent=indent, subsequent_indent=indent)
    lines = ["[compact]", "extra_terms = [", *rows, "]", ""]
    for name, of_set in factors.items():
        listed = (
            f"{key} = {toml_value(value, '.4g')}"
            for key, value in of_set.items()
            if value != 1.0 and (key not in EXTRA_TERMS or (value and key in extra))
        )
        lines += [f"[compensation.{name}]   # 0: dropped", *listed, ""]
    lines += ["[reduction]   # evidence; the program reads none of it"]
    lines.append(f'by = "trainer boat reduce, version {__version__}"')
    lines += [f"{key} = {toml_value(value, '.4g')}" for key, value in notes.items()]
    why = {need.term: need for need in needs}
    for name in extra:
        if name in why:
            need = why[name]
            words = f"without it {need.quantity} in {need.leg}: {need.worst:.3g} of the allowed"
            lines.append(f"{name} = {toml_value(words)}")
        elif name in SLIP_TERMS:
            lines.append(f'{name} = "the propeller\'s, always kept"')
    return "\n".join(lines) + "\n"
