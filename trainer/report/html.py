"""Pages of HTML by Jinja2: every text that is put into one is escaped. A browser prints PDF.

What is HTML already is ``Markup``: pieces made here, and charts made by ``svg``.
"""

import os
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Iterable, Sequence
from functools import cache
from pathlib import Path
from typing import Any, Final, NamedTuple

from jinja2 import Environment, FileSystemLoader, StrictUndefined
from markupsafe import Markup

from trainer.config.files import ConfigError, json_text
from trainer.io.atomic_write import replacing

HERE: Final = Path(__file__).parent


class Cell(NamedTuple):
    """A table's cell with a style."""

    text: str
    style: str


@cache
def _environment() -> Environment:
    """Return where templates are found: all of them escape what they are given."""
    return Environment(
        loader=FileSystemLoader(HERE / "templates"),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        keep_trailing_newline=True,
    )


def page(template: str, style: str, **parts: Any) -> str:
    """Return the page of a template with a style sheet, both files beside this one."""
    css = Markup((HERE / style).read_text(encoding="utf-8"))  # noqa: S704  our own
    return _environment().get_template(template).render(style=css, **parts)


def _piece(name: str, *given: Any, **more: Any) -> Markup:
    """Return what a macro of the pieces makes."""
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


def embed(data: Any) -> Markup:
    """Return data as JSON within a script element."""
    return Markup(json_text(data).replace("</", "<\\/"))  # noqa: S704  nothing can end the element


# A page printed as PDF, by a browser found on this machine.


NAMES: Final = (
    *("chromium", "chromium-browser", "google-chrome", "google-chrome-stable", "chrome"),
    *("microsoft-edge", "microsoft-edge-stable", "msedge", "chromium-headless-shell"),
)
MAC: Final = (
    "/Applications/Google Chrome.app/Contents/MacOS/Google Chrome",
    "/Applications/Chromium.app/Contents/MacOS/Chromium",
    "/Applications/Microsoft Edge.app/Contents/MacOS/Microsoft Edge",
)
WINDOWS: Final = (
    "Google/Chrome/Application/chrome.exe",
    "Chromium/Application/chrome.exe",
    "Microsoft/Edge/Application/msedge.exe",
)
FOLDERS: Final = ("PROGRAMFILES", "PROGRAMFILES(X86)", "LOCALAPPDATA")  # of Windows
PATIENCE: Final = 120.0  # [s]


def find_browser() -> str | None:
    """Return a Chromium, Chrome or Edge, None if there is none."""
    for name in NAMES:
        if found := shutil.which(name):
            return found
    places = [Path(place) for place in MAC]
    places += [Path(os.environ.get(each, "")) / place for each in FOLDERS for place in WINDOWS]
    return next((str(place) for place in places if place.is_absolute() and place.is_file()), None)


def print_pdf(html: Path, pdf: Path) -> None:
    """Print a page to ``pdf``, which is replaced. ConfigError if no browser is there to do it."""
    browser = find_browser()
    if browser is None:
        raise ConfigError(
            f"--pdf {pdf}: no Chromium, Chrome or Edge is on this machine: install one, or open "
            "the HTML page in a browser and print it from there"
        )
    with tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as folder:
        printed = Path(folder) / "page.pdf"
        said = _print(browser, html, printed)
        if not printed.is_file():
            raise ConfigError(
                f"--pdf {pdf}: {browser} printed nothing: {said or 'it does not say why'}; open "
                "the HTML page in a browser and print it from there"
            )
        try:
            with replacing(pdf) as made:
                shutil.copyfile(printed, made)
        except OSError as error:
            raise ConfigError(f"--pdf {pdf}: cannot be written: {error.strerror}") from None


def _print(browser: str, html: Path, pdf: Path) -> str:
    """Let the browser print; return the last line of its complaints."""
    confined = hasattr(os, "geteuid") and os.geteuid() != 0  # a browser's sandbox refuses root
    words = [
        browser,
        *("--headless", "--disable-gpu", "--no-pdf-header-footer", "--no-first-run"),
        *(() if confined or sys.platform == "win32" else ("--no-sandbox",)),
        f"--user-data-dir={pdf.parent / 'profile'}",
        f"--print-to-pdf={pdf}",
        html.resolve().as_uri(),
    ]
    try:
        done = subprocess.run(  # noqa: S603 (a browser found by its name)
            words, capture_output=True, timeout=PATIENCE, check=False, text=True, errors="replace"
        )
    except subprocess.TimeoutExpired:
        return f"not done within {PATIENCE:g} s"
    except OSError as error:
        return str(error.strerror)
    lines = done.stderr.strip().splitlines()
    return lines[-1] if lines else ""
