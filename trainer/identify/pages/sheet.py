"""The findings as one HTML page that needs no other file."""

from collections.abc import Iterable
from dataclasses import asdict
from typing import Any

from markupsafe import Markup

from trainer.analysis.report.html import charts, embed, page, paragraph, section, table
from trainer.analysis.report.panels import draw, legend
from trainer.analysis.report.plots import Panel
from trainer.identify.pages.results import Direction


def sheet(title: str, text: str, panels: Iterable[Panel], report: Any) -> str:
    """Return the page: ``text`` as the terminal has it, the ``panels`` drawn, ``report`` as JSON.

    The same report gives the same bytes.
    """
    heading, _, rest = text.partition("\n")
    return page(
        "identified.html",
        "guide.css",
        title=title,
        heading=heading,
        parts=[
            section("figures", "Measured and predicted", charts(map(_figure, panels))),
            section("numbers", "Numbers", Markup("<pre>{}</pre>\n").format(rest)),
            _directions(getattr(report, "eigenvalues", ())),
        ],
        data=embed(asdict(report)),
    )


def _figure(panel: Panel) -> Markup:
    """Return a panel with its title and what its curves mean."""
    caption = Markup("<figcaption>{}</figcaption>").format(panel.title)
    return Markup("<figure>{}{}{}</figure>").format(caption, draw(panel), legend(panel.curves))


def _directions(directions: tuple[Direction, ...]) -> Markup:
    """Return the eigenvalues of the second derivatives and what each is made of."""
    if not directions:
        return Markup()
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
