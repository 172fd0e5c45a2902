"""Pages of HTML by Jinja2: every text that is put into one is escaped.

Debriefs, guides, fits and estimates make their pages with it. A name in a user's file can hold
anything, and must not become HTML. Text of type ``Markup`` is HTML already and is not escaped:
pieces made here, charts by ``svg``.
"""

from collections.abc import Iterable, Sequence
from functools import cache
from pathlib import Path
from typing import Any, Final, NamedTuple

from jinja2 import Environment, FileSystemLoader, StrictUndefined
from markupsafe import Markup

from trainer.config.files import json_text

PAGE_FOLDER: Final = Path(__file__).parent


class Cell(NamedTuple):
    """A table's cell with a style."""

    text: str
    style: str


@cache
def _environment() -> Environment:
    """Return the templates' environment, which escapes every text."""
    return Environment(
        loader=FileSystemLoader(PAGE_FOLDER / "templates"),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        keep_trailing_newline=True,
    )


def fill_page(template: str, style: str, **parts: Any) -> str:
    """Return the page of a template with a style sheet, both files beside this one."""
    css = Markup((PAGE_FOLDER / style).read_text(encoding="utf-8"))  # noqa: S704  our own
    return _environment().get_template(template).render(style=css, **parts)


def _piece(name: str, *given: Any, **more: Any) -> Markup:
    """Return the HTML of a macro of the template of pieces."""
    macros: Any = _environment().get_template("pieces.html").module
    return Markup(getattr(macros, name)(*given, **more))  # noqa: S704  it has been escaped there


def table(
    heads: Sequence[str], rows: Iterable[Sequence[str | Cell]], style: str = "numbers"
) -> Markup:
    """Return a table."""
    return _piece("table", heads, list(rows), style)


def paragraph(words: str, style: str = "") -> Markup:
    """Return a paragraph."""
    return _piece("paragraph", words, style)


def section(name: str, title: str, *parts: Markup) -> Markup:
    """Return a chapter with its heading; ``name`` is where links lead, "" for none."""
    return _piece("section", title, parts, name)


def charts(drawn: Iterable[str]) -> Markup:
    """Return charts, which are SVG already, beside one another."""
    return _piece("charts", [Markup(each) for each in drawn])  # noqa: S704  by svg, escaped there


def embed_json(data: Any) -> Markup:
    """Return data as JSON within a script element."""
    return Markup(json_text(data).replace("</", "<\\/"))  # noqa: S704  nothing can end the element
