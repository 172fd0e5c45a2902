"""Pieces of HTML: tables, facts, sections."""

from collections.abc import Iterable, Sequence
from html import escape
from typing import NamedTuple

from trainer.guide.verdicts import BEYOND, SHOWN, WITHIN


class Cell(NamedTuple):
    """A table's cell with a style."""

    text: str
    style: str


STYLES = {WITHIN: "good", BEYOND: "bad", SHOWN: "soft"}


def verdict(word: str) -> Cell:
    """Return a verdict as a cell: a word, and a colour beside it."""
    return Cell(word, STYLES.get(word, "soft"))


def cell(value: str | Cell, tag: str = "td") -> str:
    """Return one cell."""
    if isinstance(value, Cell):
        return f'<{tag} class="{value.style}">{escape(value.text)}</{tag}>'
    return f"<{tag}>{escape(value)}</{tag}>"


def table(
    heads: Sequence[str], rows: Iterable[Sequence[str | Cell]], style: str = "numbers"
) -> str:
    """Return a table."""
    top = "".join(cell(head, "th") for head in heads)
    body = "".join(f"<tr>{''.join(cell(value) for value in row)}</tr>\n" for row in rows)
    head = f"<thead><tr>{top}</tr></thead>" if heads else ""
    return f'<div class="wide"><table class="{style}">{head}<tbody>\n{body}</tbody></table></div>\n'


def paragraph(words: str, style: str = "") -> str:
    """Return a paragraph."""
    told = f' class="{style}"' if style else ""
    return f"<p{told}>{escape(words)}</p>\n"


def section(name: str, title: str, *parts: str) -> str:
    """Return a chapter with its heading."""
    return f'<section id="{name}"><h2>{escape(title)}</h2>\n{"".join(parts)}</section>\n'


def charts(drawn: Iterable[str]) -> str:
    """Return charts beside one another."""
    return f'<div class="charts">{"".join(drawn)}</div>\n'
