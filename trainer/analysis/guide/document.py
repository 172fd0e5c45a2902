"""The guide as one HTML page that needs nothing else, and its JSON."""

from dataclasses import asdict
from typing import Any, Final

from trainer.analysis.guide import chapters
from trainer.analysis.guide.baseline import Moved
from trainer.analysis.guide.contents import Guide, GuideContents
from trainer.analysis.report.html import Cell, embed, page

CONTENTS: Final = {
    "overview": "Overview",
    "findings": "What was found in 1969",
    "published": "Published results",
    "why": "Why the reduced sets differ",
    "steps": "Steps and methods",
    "programs": "Neutral angles, modes, thrust",
}


def as_json(guide: Guide) -> dict[str, Any]:
    """Return the guide as JSON holds it."""
    return asdict(guide)


def render(book: GuideContents, moves: tuple[Moved, ...] | None) -> str:
    """Return the page; ``moves`` is what moved since a baseline, None without one."""
    guide = book.guide
    names = dict(CONTENTS)
    if moves is not None:
        names["moved"] = "Since the baseline"
    return page(
        "guide.html",
        "guide.css",
        vessel=guide.vessel,
        verdict=Cell(guide.conclusion, "good" if guide.passed else "bad"),
        facts=chapters.facts(guide),
        contents=names.items(),
        legs=[(chapters.anchor(leg.title), leg.title) for leg in book.legs],
        parts=[
            chapters.overview(guide),
            *([chapters.moves(moves)] if moves is not None else []),
            chapters.findings(guide),
            chapters.trials(guide),
            chapters.drops(guide),
            chapters.steps(guide),
            chapters.programs(book),
            *chapters.manoeuvres(book),
        ],
        data=embed(as_json(guide)),
    )
