"""What was identified as one HTML page that needs nothing beside itself."""

import json
from collections.abc import Iterable
from dataclasses import asdict
from html import escape
from typing import Any

from trainer.analysis.guide.document import STYLE
from trainer.analysis.report.html import charts, paragraph, section, table
from trainer.analysis.report.panels import draw, legend
from trainer.analysis.report.plots import Panel
from trainer.identify.pages.results import Direction


def sheet(title: str, text: str, panels: Iterable[Panel], report: Any) -> str:
    """Return the page: ``text`` as the terminal has it, the ``panels`` drawn, ``report`` as JSON.

    The same report gives the same bytes.
    """
    data = json.dumps(asdict(report)).replace("</", "<\\/")
    heading, _, rest = text.partition("\n")
    figures = charts(_figure(panel) for panel in panels)
    parts = [
        _head(title),
        f"<header><p>{escape(heading)}</p><h1>{escape(title)}</h1></header>\n",
        section("figures", "Measured and predicted", figures),
        section("numbers", "Numbers", f"<pre>{escape(rest)}</pre>\n"),
        _directions(getattr(report, "eigenvalues", ())),
        f'<script type="application/json" id="identified">{data}</script>\n</body></html>\n',
    ]
    return "".join(parts)


def _head(title: str) -> str:
    """Return what comes before the page's body."""
    style = STYLE.read_text(encoding="utf-8")
    return (
        '<!DOCTYPE html>\n<html lang="en"><head><meta charset="utf-8">'
        '<meta name="generator" content="trainer identify">'
        '<meta name="viewport" content="width=device-width, initial-scale=1">'
        f"<title>Identified: {escape(title)}</title>\n<style>{style}</style></head>\n<body>"
    )


def _figure(panel: Panel) -> str:
    """Return a panel with its title and what its curves mean."""
    caption = f"<figcaption>{escape(panel.title)}</figcaption>"
    return f"<figure>{caption}{draw(panel)}{legend(panel.curves)}</figure>"


def _directions(directions: tuple[Direction, ...]) -> str:
    """Return the eigenvalues of the second derivatives and what each is made of."""
    if not directions:
        return ""
    rows = [(f"{one.eigenvalue:.3g}", _parts(one.parts)) for one in directions]
    words = (
        "Eigenvalues of the second derivatives of -log L, scaled to a unit diagonal, smallest "
        "first. The record tells least of the combination of parameters beside a small one."
    )
    heads = ("eigenvalue", "parts of the unit vector")
    return section("directions", "What is known least", paragraph(words), table(heads, rows))


def _parts(parts: dict[str, float]) -> str:
    """Return a direction in words, its largest part first."""
    order = sorted(parts.items(), key=lambda part: -abs(part[1]))
    return ", ".join(f"{name} {value:+.2f}" for name, value in order)
