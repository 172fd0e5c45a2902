"""The guide as one HTML page that needs nothing else, and its JSON."""

import json
from dataclasses import asdict
from html import escape
from pathlib import Path
from typing import Any, Final

from trainer.analysis.guide import chapters
from trainer.analysis.guide.baseline import Moved
from trainer.analysis.guide.contents import Book, Guide

STYLE: Final = Path(__file__).parents[1] / "report" / "style.css"
CONTENTS: Final = {
    "overview": "Overview",
    "findings": "What was found in 1969",
    "published": "Published results",
    "why": "Why the reduced sets differ",
    "steps": "Steps and methods",
    "programs": "Neutral angles, modes, thrust",
}
PASSED: Final = {True: "Within tolerance", False: "OUT OF TOLERANCE"}


def as_json(guide: Guide) -> dict[str, Any]:
    """Return the guide as JSON holds it."""
    return asdict(guide)


def render(book: Book, moves: tuple[Moved, ...] | None) -> str:
    """Return the page; ``moves`` is what moved since a baseline, None without one."""
    guide = book.guide
    title = f"Qualification test guide: {guide.vessel}"
    data = json.dumps(as_json(guide)).replace("</", "<\\/")
    parts = [
        _head(title),
        _title(guide),
        chapters.facts(guide),
        _contents(book, moves),
        chapters.overview(guide),
        chapters.moves(moves) if moves is not None else "",
        chapters.findings(guide),
        chapters.trials(guide),
        chapters.drops(guide),
        chapters.steps(guide),
        chapters.programs(book),
        *chapters.manoeuvres(book),
        f'<script type="application/json" id="guide">{data}</script>\n</body></html>\n',
    ]
    return "".join(parts)


def _head(title: str) -> str:
    """Return what comes before the page's body."""
    style = STYLE.read_text(encoding="utf-8")
    return (
        '<!DOCTYPE html>\n<html lang="en"><head><meta charset="utf-8">'
        '<meta name="viewport" content="width=device-width, initial-scale=1">'
        f"<title>{escape(title)}</title>\n<style>{style}</style></head>\n<body>"
    )


def _title(guide: Guide) -> str:
    """Return vessel and verdict."""
    style = "good" if guide.passed else "bad"
    return (
        f"<header><p>Qualification test guide</p><h1>{escape(guide.vessel)}</h1>"
        f'<p class="total {style}">{PASSED[guide.passed]}</p></header>\n'
    )


def _contents(book: Book, moves: tuple[Moved, ...] | None) -> str:
    """Return links to the chapters."""
    names = dict(CONTENTS)
    if moves is not None:
        names["moved"] = "Since the baseline"
    links = [f'<a href="#{name}">{escape(title)}</a>' for name, title in names.items()]
    legs = [
        f'<a href="#{leg.title.replace(" ", "-").replace(",", "")}">{escape(leg.title)}</a>'
        for leg in book.legs
    ]
    return f"<nav><p>{' '.join(links)}</p><p>{' '.join(legs)}</p></nav>\n"
