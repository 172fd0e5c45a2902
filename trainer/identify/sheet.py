"""One HTML page of a fit: text, figures as SVG, data as JSON.

``--html`` of ``trainer identify`` writes it. It needs no other file and no network.
"""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import asdict
from typing import Any, Final

import numpy as np
from markupsafe import Markup

from trainer.core.kernel import Numbers
from trainer.report import html
from trainer.report.panels import draw_panel, legend
from trainer.report.plots import Curve, Panel, Screen

MAX_PANELS: Final = 4  # of a screen
Part = tuple[str, Markup]  # a screen of the page: its title, and what is on it


def screens_of(groups: Mapping[str, Iterable[Panel]]) -> tuple[Screen, ...]:
    """Return groups of panels as screens, those of many panels as several.

    More than MAX_PANELS on a screen are too small to read.
    """
    screens = []
    for title, group in groups.items():
        panels = tuple(group)
        pieces = [panels[i : i + MAX_PANELS] for i in range(0, len(panels), MAX_PANELS)]
        names = [title] if len(pieces) == 1 else [f"{title} {i}" for i in range(1, len(pieces) + 1)]
        screens += [Screen(name, piece) for name, piece in zip(names, pieces, strict=True)]
    return tuple(screens)


def sheet(
    title: str, text: str, screens: Iterable[Screen], report: Any, further: Iterable[Part] = ()
) -> str:
    """Return the page: ``text``, ``screens`` drawn, ``further`` parts, and ``report`` as data.

    The first screen comes before the text, for people look before they read. The page needs no
    other file. The same report gives the same bytes.
    """
    heading, _, rest = text.partition("\n")
    first, *others = map(draw_screen, screens)
    parts = [first, ("Numbers", listing(rest)), *others, *further]
    return fill_sheet(title, heading, parts, report)


def fill_sheet(title: str, heading: str, parts: Sequence[Part], report: Any) -> str:
    """Return the page of these parts, with ``report`` as data; links lead to each."""
    return html.fill_page(
        "identified.html",
        "guide.css",
        title=title,
        heading=heading,
        screens=parts,
        data=html.embed_json(asdict(report)),
    )


def draw_screen(screen: Screen) -> Part:
    """Return a screen: its figures in rows of two, and what curves mean."""
    figure = Markup("<figure><figcaption>{}</figcaption>{}{}</figure>")
    figures = html.charts(
        figure.format(panel.title, draw_panel(panel), legend(panel.curves))
        for panel in screen.panels
    )
    rows = Markup('<div class="rows{}">{}</div>')
    return screen.title, rows.format((len(screen.panels) + 1) // 2, figures)


def listing(text: str) -> Markup:
    """Return text as the terminal has it, in columns; no table is split between columns."""
    blocks = Markup("\n").join(map(Markup("<pre>{}</pre>").format, text.split("\n\n")))
    return Markup('<div class="listing">\n{}\n</div>\n').format(blocks)


def input_curve(name: str, t: Numbers, values: Numbers, between_readings: str) -> Curve:
    """Return the curve of an input as it acts: straight lines or steps."""
    if between_readings == "straight":
        return Curve(name, t, values)
    return Curve(name, np.repeat(t, 2)[1:], np.repeat(values, 2)[:-1])
