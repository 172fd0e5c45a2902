"""A reduction is written into a vessel file. All other text of the file stays.

``trainer boat reduce -o`` writes so. The text is changed and not made anew, because a user's
comments and order of keys must survive.
"""

import re
import textwrap
from collections.abc import Iterator, Mapping, Sequence
from typing import Final

from trainer import __version__
from trainer.analysis.reduce.search import TermNeed
from trainer.core.terms import EXTRA_TERMS, SLIP_TERMS

REDUCTION_TABLES: Final = ("compact", "compensation.modified", "compensation.basic", "reduction")
TABLE_HEADER: Final = re.compile(r"\s*\[\[?\s*([^\]]+?)\s*\]")
LINE_WIDTH: Final = 96  # [characters] of the lines written
COEFFICIENTS_HEADER: Final = re.compile(r"^\[coefficients", re.MULTILINE)


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
            f"{key} = {value:.4g}"
            for key, value in of_set.items()
            if value != 1.0 and (key not in EXTRA_TERMS or (value and key in extra))
        )
        lines += [f"[compensation.{name}]   # 0: dropped", *listed, ""]
    lines += ["[reduction]   # evidence; the program reads none of it"]
    lines.append(f'by = "trainer boat reduce, version {__version__}"')
    lines += [f"{key} = {value:.4g}" for key, value in notes.items()]
    why = {need.term: need for need in needs}
    for name in extra:
        if name in why:
            need = why[name]
            words = f"without it {need.quantity} in {need.leg}: {need.worst:.3g} of the allowed"
            lines.append(f'{name} = "{words}"')
        elif name in SLIP_TERMS:
            lines.append(f'{name} = "the propeller\'s, always kept"')
    return "\n".join(lines) + "\n"
