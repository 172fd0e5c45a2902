"""The HTML of the pages, made once at the server's start from Jinja templates.

``PAGES`` lists them. What a page says is put into it in every language (``words``), and its script
chooses one.
"""

from collections.abc import Collection, Container
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any, Final

from jinja2 import Environment, FileSystemLoader, StrictUndefined

from trainer import __version__
from trainer.config.exercise.course import course
from trainer.config.exercise.course import lessons as step_lessons
from trainer.config.world.contacts import SHIP_TYPES
from trainer.io.orders.help import limits_and_units, usage
from trainer.io.orders.quantities import NUMBER_KINDS
from trainer.io.orders.table import FORMS, word_of
from trainer.web.words import said_in_page, translated

WEB_FOLDER: Final = Path(__file__).parent
LEAD_GROUP, CREW_GROUP, WATCH_GROUP = "Lead", "Crew", "Watch"


@dataclass(frozen=True)
class Page:
    """One page: its address, its title, the role of its station, its template."""

    name: str  # "" is the choice of a role
    title: str
    role: str
    template: str
    group: str = ""  # under which the first page has it
    says: str = ""  # what is done there, in one line
    works: str = ""  # what of an exercise's ``hand`` is worked there


MISSING_PAGE: Final = Page(
    "missing",
    "There is no such page",
    "",
    "missing.html",
    says="The address has no page of this session.",
)
MISSING_DEBRIEF: Final = Page(
    "missing",
    "There is no such debrief",
    "",
    "missing.html",
    says="The instructor's page has the addresses of the debriefs.",
)
# of a class; its boats have all others
ENTRANCE_PAGE: Final = Page("", "Come aboard", "", "entrance.html")
CLASS_PAGE: Final = Page("class", "Class", "instructor", "class.html")
NOTHING_SHOWN_PAGE: Final = Page("wall", "Wall", "", "nothing-shown.html")
# fmt: off
PAGES: Final = (
    Page("", "Control room", "", "choice.html"),
    Page(
        "trainee", "I train", "trainee", "trainee.html",
        LEAD_GROUP, "Alone: lessons that lead step by step, then exercises with marks",
    ),
    Page(
        "instructor", "Instructor", "instructor", "instructor.html",
        LEAD_GROUP, "Time, casualties and orders; looks back, judges, debriefs",
    ),
    Page(
        "helm", "Helm", "helm", "steering.html",
        CREW_GROUP, "Steers the course and orders the engine", "rudder speed",
    ),
    Page(
        "planes", "Planes", "planes", "steering.html",
        CREW_GROUP, "Keeps depth and angle with bow and stern planes", "planes",
    ),
    Page(
        "pilot", "Pilot", "pilot", "steering.html",
        CREW_GROUP, "Helm and planes, worked by one person", "rudder planes speed",
    ),
    Page(
        "ballast", "Ballast", "ballast", "ballast.html",
        CREW_GROUP, "Tanks, pumps, valves and air", "ballast",
    ),
    Page(
        "diving", "Diving officer", "diving", "diving.html",
        CREW_GROUP, "Orders planes and ballast, and keeps the boat in trim",
    ),
    Page(
        "deck", "Deck", "deck", "diving.html",
        CREW_GROUP, "Officer of the deck: orders course, depth and speed alone",
    ),
    Page(
        "scope", "Periscope", "scope", "scope.html",
        CREW_GROUP, "Looks round, takes bearings and ranges, marks contacts",
    ),
    Page(
        "observer", "Observer", "observer", "observer.html",
        WATCH_GROUP, "All instruments, no controls; marks moments",
    ),
    Page(
        "wall", "Wall", "observer", "wall.html",
        WATCH_GROUP, "A large screen that everybody looks at",
    ),
    Page(
        "kiosk", "Kiosk", "visitor", "kiosk.html",
        WATCH_GROUP, "For visitors: one lever, three minutes",
    ),
)
# fmt: on


@cache
def _environment() -> Environment:
    """Return the environment of the templates, which escapes every value."""
    environment = Environment(
        loader=FileSystemLoader(WEB_FOLDER / "templates"),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    environment.globals |= {"order_words": order_words, "lessons": lessons, "mastheads": mastheads}
    return environment


def order_words(taken: Container[str] | None = None) -> dict[str, Any]:
    """Return the wordings of orders and what their numbers are, for their completion.

    ``taken`` has the names of the orders that the page takes; without it they are all orders.
    """
    wanted = [
        form for form in FORMS if not form.refusal and (taken is None or word_of(form) in taken)
    ]
    forms = [(usage(form), form.says) for form in wanted]
    return {
        "forms": forms,
        "numbers": {name: limits_and_units(n) for name, n in NUMBER_KINDS.items()},
    }


@cache  # each page is rendered twice
def lessons() -> list[dict[str, Any]]:
    """Return the lessons, then the exercises in the course's order, without their files' names.

    A file name tells what will break, and trainees read this page. The instructor's line tells the
    names, by the order ``next``.
    """
    return [
        {"word": each.word, "title": each.title, "briefing": " ".join(each.briefing.split())}
        | {"seconds": each.seconds, "hand": each.hand, "vessel": each.vessel, "steps": each.steps}
        for each in (*step_lessons(), *course())
    ]


def mastheads() -> list[tuple[str, str]]:
    """Return the height [m] of the masthead of each type of ship, the highest first."""
    kinds = sorted(SHIP_TYPES.items(), key=lambda each: -each[1].mast)
    return [(name, f"{ship.mast:g}") for name, ship in kinds]


def render(page: Page, said: Collection[str] = (), **parts: Any) -> str:
    """Return the HTML of a page, with its words in all languages.

    ``said`` is added to it later.
    """
    template = _environment().get_template(page.template)
    plain = template.render(page=page, pages=PAGES, version=__version__, words={}, **parts)
    words = translated(said_in_page(plain) | {*said})
    return template.render(page=page, pages=PAGES, version=__version__, words=words, **parts)
