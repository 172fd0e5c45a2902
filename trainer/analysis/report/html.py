"""Pieces of HTML: tables, facts, sections.

How the page looks: colours of Okabe and Ito, dashes beside them, light, dark and on paper.
"""

from collections.abc import Iterable, Sequence
from html import escape
from typing import Final, NamedTuple

from trainer.analysis.guide.verdicts import BEYOND, SHOWN, WITHIN


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


STYLE: Final = """
:root { color-scheme: light dark; --paper: #fff; --ink: #1a1a1a; --soft: #595959; --line: #d0d0d0;
  --band: #f3f3f3; --first: #0072b2; --told: #b34700; --second: #00785a; --spell: #cc79a7; }
@media (prefers-color-scheme: dark) { :root { --paper: #15181c; --ink: #ececec; --soft: #b0b4ba;
  --line: #3c4148; --band: #1f242a; --first: #56b4e9; --told: #e69f00; --second: #3ecfa4; } }
@media print { :root { color-scheme: light; --paper: #fff; --ink: #000; --soft: #444; --line: #ccc;
  --band: #f3f3f3; --first: #0072b2; --told: #b34700; --second: #00785a; } }
@page { size: A4; margin: 14mm 12mm; }
* { box-sizing: border-box; }
body { margin: 0 auto; max-width: 62rem; padding: 1.5rem; background: var(--paper);
  color: var(--ink); font: 15px/1.45 system-ui, "Segoe UI", Helvetica, Arial, sans-serif; }
header { border-bottom: 3px solid var(--ink); margin-bottom: 1rem; }
h1 { font-size: 1.7rem; line-height: 1.2; margin: 0 0 .2rem; }
h2 { font-size: 1.15rem; margin: 2rem 0 .5rem; break-after: avoid; }
p { margin: .4rem 0; }
.under { color: var(--soft); margin: 0 0 .8rem; }
.total { font-size: 1.2rem; } .total b { font-size: 2.6rem; line-height: 1; }
.briefing { white-space: pre-line; border-left: 4px solid var(--line); padding-left: .8rem; }
.wide { overflow-x: auto; }
table { border-collapse: collapse; width: 100%; font-size: .87rem; }
th, td { text-align: left; vertical-align: top; padding: .28rem .6rem .28rem 0;
  border-bottom: 1px solid var(--line); }
th { color: var(--soft); font-weight: 600; white-space: nowrap; }
thead { display: table-header-group; } tr { break-inside: avoid; }
td:first-child { white-space: nowrap; }
.facts td:first-child { color: var(--soft); width: 9rem; } .facts thead { display: none; }
.scores td:nth-child(2) { font-weight: 600; }
.scores td:last-child { color: var(--soft); min-width: 13rem; }
.log { font-size: .8rem; }
small { color: var(--soft); white-space: nowrap; }
.share { display: block; width: 4rem; height: .4rem; margin-top: .2rem;
  border: 1px solid var(--soft); print-color-adjust: exact; }
.share i { display: block; height: 100%; background: var(--first); }
svg { display: block; width: 100%; height: auto; margin: .35rem 0; break-inside: avoid;
  font: 11.5px system-ui, "Segoe UI", Helvetica, Arial, sans-serif; print-color-adjust: exact; }
svg .title { font-weight: 600; font-size: 13px; fill: var(--ink); }
svg .tick { fill: var(--soft); } svg .middle { text-anchor: middle; } svg .end { text-anchor: end; }
svg .grid { stroke: var(--line); stroke-width: .7; } svg .axis { stroke: var(--soft); }
svg .spell { fill: var(--spell); opacity: .16; }
svg .bar { fill: var(--spell); opacity: .75; stroke: var(--ink); stroke-width: .8; }
svg .mark { stroke: var(--ink); stroke-dasharray: 2 3; }
svg .limit { stroke: var(--ink); stroke-width: .9; stroke-dasharray: 9 3 2 3; }
svg .limit-name { fill: var(--ink); font-size: 10.5px; }
svg .order { stroke: var(--first); stroke-width: 1.6; }
svg .call { fill: var(--told); font-weight: 700; font-size: 13px; }
svg .line { fill: none; stroke-width: 1.7; stroke-linejoin: round; }
svg .actual { stroke: var(--first); }
svg .ordered { stroke: var(--told); stroke-dasharray: 7 4; stroke-width: 1.5; }
svg .second { stroke: var(--second); stroke-dasharray: 12 2; }
svg .second.ordered { stroke: var(--told); stroke-dasharray: 2 3; }
svg .second.fine { stroke: var(--second); stroke-dasharray: 3 2; stroke-width: 1.2; }
footer { margin-top: 2.5rem; border-top: 1px solid var(--line); color: var(--soft);
  font-size: .82rem; }
"""
