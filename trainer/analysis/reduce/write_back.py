"""A reduction is written into a vessel file. All else in its text stays as it stands."""

import re
from collections.abc import Iterator, Mapping, Sequence
from typing import Final

from trainer import __version__
from trainer.analysis.reduce.search import Need
from trainer.core.terms import EXTRA_TERMS

OURS: Final = ("compact", "compensation.modified", "compensation.basic", "reduction")
HEADER: Final = re.compile(r"\s*\[\[?\s*([^\]]+?)\s*\]")
WIDTH: Final = 96
BEFORE: Final = re.compile(r"^\[coefficients", re.MULTILINE)


def rewritten(text: str, tables: str) -> str:
    """Return the text of a vessel file with its reduction replaced by ``tables``."""
    kept = "\n".join(_without_ours(text.splitlines()))
    kept = re.sub(r"\n{3,}", "\n\n", kept)
    first = BEFORE.search(kept)
    if not first:
        return f"{kept.rstrip()}\n\n{tables}"
    place = _above_comments(kept, first.start())
    return f"{kept[:place].rstrip()}\n\n{tables}\n{kept[place:].rstrip()}\n"


def _above_comments(text: str, place: int) -> int:
    """Return the start of the comment lines right above ``place``."""
    lines = text[:place].split("\n")[:-1]
    while lines and lines[-1].startswith("#"):
        place -= len(lines.pop()) + 1
    return place


def _without_ours(lines: Sequence[str]) -> Iterator[str]:
    """Yield the lines that are not of a table of ours; comments of their own stay."""
    ours = False
    for line in lines:
        header = HEADER.match(line)
        if header:
            ours = header[1].replace(" ", "") in OURS
        if not ours or line.startswith("#"):
            yield line


def tables(
    factors: Mapping[str, Mapping[str, float]], needs: Sequence[Need], notes: Mapping[str, float]
) -> str:
    """Return the tables of a reduction's ``factors`` by equation set and term. 0: dropped.

    The evidence names what would be worst without each term beyond those of 1969.
    """
    extra = [name for name in EXTRA_TERMS if factors["modified"].get(name)]
    lines = ["[compact]", *_list_names("extra_terms", extra), ""]
    for name, of_set in factors.items():
        shown = {
            key: value
            for key, value in of_set.items()
            if value != 1.0 and (value or key not in EXTRA_TERMS) and not _unseen(key, extra)
        }
        lines += [f"[compensation.{name}]   # 0: dropped", *_list_factors(shown), ""]
    lines += ["[reduction]   # evidence; the program reads none of it"]
    lines.append(f'by = "trainer reduce, version {__version__}"')
    lines += [f"{key} = {value:.4g}" for key, value in notes.items()]
    why = {need.term: need for need in needs}
    for name in extra:
        if name in why:
            need = why[name]
            words = f"without it {need.quantity} in {need.leg}: {need.worst:.3g} of the allowed"
            lines.append(f'{name} = "{words}"')
    return "\n".join(lines) + "\n"


def _unseen(key: str, extra: Sequence[str]) -> bool:
    """Return whether a term has no place in the tables, for it is no extra one of this hull."""
    return key in EXTRA_TERMS and key not in extra


def _list_names(key: str, names: Sequence[str]) -> Iterator[str]:
    """Yield an array of names in lines that fit."""
    yield f"{key} = ["
    row = "   "
    for name in names:
        if len(row) + len(name) + 4 > WIDTH:
            yield row
            row = "   "
        row += f' "{name}",'
    if names:
        yield row
    yield "]"


def _list_factors(values: Mapping[str, float]) -> list[str]:
    """Return a factor a line."""
    return [f"{key} = {value:.4g}" for key, value in values.items()]
