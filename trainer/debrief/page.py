"""The debrief as one HTML page that needs nothing beside itself."""

from collections.abc import Iterator
from html import escape
from typing import Final

from trainer import __version__
from trainer.debrief import sections
from trainer.debrief.axes import clock
from trainer.debrief.chart import draw
from trainer.debrief.charts import charts_of, ground_of
from trainer.debrief.dossier import Dossier
from trainer.debrief.style import STYLE
from trainer.debrief.timeline import draw_timeline

BADGE: Final = '<meta name="generator" content="trainer debrief">'  # by which a page is known


def render(dossier: Dossier) -> str:
    """Return the page; the same record gives the same bytes."""
    title = escape(dossier.title)
    return "\n".join(
        (
            "<!DOCTYPE html>",
            f'<html lang="en"><head><meta charset="utf-8">{BADGE}',
            '<meta name="viewport" content="width=device-width, initial-scale=1">',
            f"<title>Debrief: {title}</title><style>{STYLE}</style></head><body>",
            f"<header><h1>{title}</h1>{_under(dossier)}</header><main>",
            *_body(dossier),
            f"</main><footer>Made by trainer {__version__} from {escape(dossier.source.name)}.",
            "</footer></body></html>",
            "",
        )
    )


def _under(dossier: Dossier) -> str:
    """Return what is below the title: the boat, the day, how long, and which branch."""
    told = [
        dossier.plan.file.name,
        dossier.header.get("started", ""),
        f"{clock(float(dossier.passage.seconds[-1]))} flown",
    ]
    if len(dossier.branches) > 1:
        told.append(f"branch {dossier.branch.id} of {len(dossier.branches)}")
    return f'<p class="under">{escape(" - ".join(filter(None, told)))}</p>'


def _body(dossier: Dossier) -> Iterator[str]:
    yield sections.verdict(dossier)
    if dossier.plan.briefing:
        yield f'<p class="briefing">{escape(dossier.plan.briefing)}</p>'
    if dossier.card.scores:
        yield _section("Scores", sections.scores(dossier))
    yield _section("Ordered and actual", _drawings(dossier))
    told = sections.casualties(dossier) if dossier.casualties else "<p>Nothing broke.</p>"
    yield _section("Casualties", told)
    if dossier.of_kind("mark"):
        yield _section("Marks", sections.marks(dossier))
    if dossier.hands:
        yield _section("Who gave orders", sections.hands(dossier))
    yield _section("Orders and events", sections.log(dossier))
    if len(dossier.branches) > 1:
        yield _section("Branches", sections.branches(dossier))
    yield _section("Ticks", sections.ledger(dossier))
    yield _section("What was flown", sections.made_of(dossier))


def _section(title: str, html: str) -> str:
    return f"<section><h2>{title}</h2>{html}</section>"


def _drawings(dossier: Dossier) -> str:
    """Return the time line and the charts."""
    ground = ground_of(dossier)
    drawn = [draw(chart, ground) for chart in charts_of(dossier.passage)]
    told = "Shaded: a casualty. Dotted upright: a mark. Time from the start, minutes and seconds."
    return "".join([f"<p><small>{told}</small></p>", draw_timeline(dossier, ground), *drawn])
