"""The pages are made once at the start from templates and catalogues of words.

Catalogues hold plain text, without contexts and plurals. So a short reader here does the work of a
library.
"""

import ast
import re
from collections.abc import Container
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any, Final

from jinja2 import Environment, FileSystemLoader, StrictUndefined

from trainer import __version__
from trainer.config.contacts import SHIP_TYPES
from trainer.config.course import course
from trainer.config.files import ConfigError, read_text
from trainer.io.orders.help import limits_and_units, usage
from trainer.io.orders.quantities import NUMBER_KINDS
from trainer.io.orders.table import FORMS, Form, heading_word

LOCALE_FOLDER: Final = Path(__file__).parent / "locale"
CATALOGUE_KEYWORDS: Final = ("msgid", "msgstr")
CATALOGUE_LINE: Final = re.compile(r'(?:(\w+(?:\[\d+\])?)\s+)?("(?:[^"\\]|\\.)*")')
VALUE_HOLE: Final = re.compile(r"\{\d\}")  # the place of a value in a text

Catalogue = dict[str, str]  # translated texts, by the English ones
WEB_FOLDER: Final = Path(__file__).parent
ASSETS_FOLDER: Final = WEB_FOLDER / "assets"
LEAD_GROUP, CREW_GROUP, WATCH_GROUP = "Lead", "Crew", "Watch"


def catalogues(folder: Path = LOCALE_FOLDER) -> dict[str, Catalogue]:
    """Return the catalogues by their languages, such as "de"; ConfigError if one is wrong."""
    return {path.stem: read_catalogue(path) for path in sorted(folder.glob("*.po"))}


def read_catalogue(path: Path) -> Catalogue:
    """Return the entries of a catalogue that are translated; ConfigError for what is none."""
    catalogue: Catalogue = {}
    for first, msgid, msgstr, fuzzy in entries(path):
        if sorted(VALUE_HOLE.findall(msgid)) != sorted(VALUE_HOLE.findall(msgstr)) and msgstr:
            raise ConfigError(f"{path.name}: line {first}: {msgstr!r}: not the holes of {msgid!r}")
        if msgid in catalogue:
            raise ConfigError(f"{path.name}: line {first}: msgid {msgid!r}: is there twice")
        if msgid and msgstr and not fuzzy:
            catalogue[msgid] = msgstr
    return catalogue


def entries(path: Path) -> list[tuple[int, str, str, bool]]:
    """Return the entries of a catalogue: line, msgid, msgstr, and whether it is in doubt."""
    catalogue_entries: list[tuple[int, str, str, bool]] = []
    texts: dict[str, str] = {}
    key, first, fuzzy = "", 0, False
    for number, line in enumerate([*read_text(path).splitlines(), ""], 1):
        words = line.strip()
        if not words and "msgid" in texts:
            catalogue_entries.append((first, texts["msgid"], texts.get("msgstr", ""), fuzzy))
        if not words:
            texts, key, fuzzy = {}, "", False
        elif words.startswith("#"):
            fuzzy = fuzzy or (words.startswith("#,") and "fuzzy" in words)
        else:
            said, text = read_line(words, f"{path.name}: line {number}")
            first = number if said == "msgid" else first
            key = said or key
            texts[key] = texts.get(key, "") + text
    return catalogue_entries


def read_line(line: str, place: str) -> tuple[str, str]:
    """Return the keyword of a line, "" where it goes on, and its text; ConfigError."""
    match = CATALOGUE_LINE.fullmatch(line)
    if match is None or match[1] not in (None, *CATALOGUE_KEYWORDS):
        raise ConfigError(
            f"{place}: {line}: expected {' or '.join(CATALOGUE_KEYWORDS)} and a text in quotes"
        )
    return match[1] or "", str(ast.literal_eval(match[2]))


@dataclass(frozen=True)
class Page:
    """One page: its address, its title, the role of its station, its template."""

    name: str  # "" is the choice of a role
    title: str
    role: str
    template: str
    group: str = ""  # under which the first page has it
    says: str = ""  # what is done there, in one line


MISSING_PAGE: Final = Page("missing", "There is no such page", "", "missing.html")
# fmt: off
PAGES: Final = (
    Page("", "Control room", "", "choice.html"),
    Page(
        "instructor", "Instructor", "instructor", "instructor.html",
        LEAD_GROUP, "Time, casualties and orders; looks back, judges, debriefs",
    ),
    Page(
        "helm", "Helm", "helm", "steering.html",
        CREW_GROUP, "Steers the course and orders the engine",
    ),
    Page(
        "planes", "Planes", "planes", "steering.html",
        CREW_GROUP, "Keeps depth and angle with bow and stern planes",
    ),
    Page(
        "pilot", "Pilot", "pilot", "steering.html",
        CREW_GROUP, "Helm and planes, worked by one person",
    ),
    Page(
        "ballast", "Ballast", "ballast", "ballast.html",
        CREW_GROUP, "Tanks, pumps, valves and air",
    ),
    Page(
        "diving", "Diving officer", "diving", "diving.html",
        CREW_GROUP, "Orders planes and ballast, and keeps the boat in trim",
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
        form for form in FORMS if not form.refusal and (taken is None or name_of(form) in taken)
    ]
    forms = [(usage(form), form.says) for form in wanted]
    return {
        "forms": forms,
        "numbers": {name: limits_and_units(n) for name, n in NUMBER_KINDS.items()},
    }


def name_of(form: Form) -> str:
    """Return the name of the order that a form words."""
    return form.name or heading_word(form)


def lessons() -> list[dict[str, Any]]:
    """Return the exercises in the course's order, without the names of their files.

    A file name tells what will break, and trainees read this page. The instructor's line tells the
    names, by the order ``next``.
    """
    return [
        {"title": exercise.title, "briefing": " ".join(exercise.briefing.split())}
        | {"seconds": exercise.seconds, "hand": exercise.hand, "vessel": exercise.vessel}
        for exercise in course()
    ]


def mastheads() -> list[tuple[str, str]]:
    """Return the height [m] of the masthead of each type of ship, the highest first."""
    kinds = sorted(SHIP_TYPES.items(), key=lambda each: -each[1].mast)
    return [(name, f"{ship.mast:g}") for name, ship in kinds]


def render(page: Page, **parts: Any) -> str:
    """Return the HTML of a page."""
    template = _environment().get_template(page.template)
    words = catalogues()
    return template.render(page=page, pages=PAGES, version=__version__, words=words, **parts)
