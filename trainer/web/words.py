"""The words of the pages in English, and the catalogues that translate them.

A catalogue is a file ``locale/LANGUAGE.po`` in gettext's format, whose keys are the English words.
They hold plain text, without contexts and plurals, so a short reader here does what a gettext
library would. Nothing else knows which languages there are.
"""

import ast
import json
import re
from collections.abc import Set as AbstractSet
from functools import cache
from html.parser import HTMLParser
from pathlib import Path
from typing import Final

from trainer.config.files import ConfigError, read_text
from trainer.web.modules import SCRIPT_TAG, collect_modules

LOCALE_FOLDER: Final = Path(__file__).parent / "locale"
CATALOGUE_KEYWORDS: Final = ("msgid", "msgstr")
CATALOGUE_LINE: Final = re.compile(r'(?:(\w+(?:\[\d+\])?)\s+)?("(?:[^"\\]|\\.)*")')
VALUE_HOLE: Final = re.compile(r"\{\d\}")  # the place of a value in a text

Catalogue = dict[str, str]  # translated texts, by the English ones
SAID_WORDS: Final = re.compile(r'\bsay\(\s*("(?:[^"\\]|\\.)*")')
# Attributes that people read or hear: those of READ in js/words.js.
READ_ATTRIBUTES: Final = frozenset(
    (
        *("aria-label", "placeholder", "title", "label", "low", "high"),
        *("data-says", "data-short", "data-lower", "data-higher", "word-centre", "word-forward"),
    )
)
WORDLESS_TEXT: Final = re.compile(r"[^A-Za-z]*(?:m|kn|s)?")  # a text without a word, but for a unit
OWN_NAME: Final = "English"  # a catalogue has the language's own name of itself for it


def catalogues(folder: Path | None = None) -> dict[str, Catalogue]:
    """Return the catalogues by their languages, such as "de"; ConfigError if one is wrong."""
    return read_catalogues(folder or LOCALE_FOLDER)


@cache  # each page asks for them, and to read them is half of what a server does before it serves
def read_catalogues(folder: Path) -> dict[str, Catalogue]:
    """Return the catalogues in a folder by their languages; ConfigError if one is wrong."""
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


def read_line(line: str, position: str) -> tuple[str, str]:
    """Return the keyword of a line, "" where it goes on, and its text; ConfigError."""
    match = CATALOGUE_LINE.fullmatch(line)
    if match is None or match[1] not in (None, *CATALOGUE_KEYWORDS):
        raise ConfigError(
            f"{position}: {line}: expected {' or '.join(CATALOGUE_KEYWORDS)} and a text in quotes"
        )
    return match[1] or "", str(ast.literal_eval(match[2]))


def translated(said: AbstractSet[str]) -> dict[str, Catalogue]:
    """Return the catalogues, with what a page says and no more."""
    wanted = {*said, OWN_NAME}
    return {
        language: {words: text for words, text in catalogue.items() if words in wanted}
        for language, catalogue in catalogues().items()
    }


class WrittenWords(HTMLParser):
    """The words in the HTML of a page: texts and read attributes."""

    def __init__(self) -> None:
        super().__init__()
        self.words: set[str] = set()
        self._data = False  # within data for scripts

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        """Take the attributes of an element."""
        self._data = tag in ("script", "style")
        for name, value in attrs:
            if name in READ_ATTRIBUTES and value:
                self.words.add(value)

    def handle_data(self, data: str) -> None:
        """Take a text."""
        if not self._data:
            self.words.add(" ".join(data.split()))

    def handle_endtag(self, _tag: str) -> None:
        """End what holds data."""
        self._data = False


def written_in(html: str) -> set[str]:
    """Return the words that are written in a page, without figures and units."""
    parser = WrittenWords()
    parser.feed(html)
    return {words for words in parser.words if not WORDLESS_TEXT.fullmatch(words)}


def said_in_page(html: str) -> set[str]:
    """Return all that a page says in English, by its scripts too."""
    said = written_in(html)
    for entry in SCRIPT_TAG.findall(html):
        for source in collect_modules(entry, {}).values():
            said |= said_in_script(source)
    return said


@cache
def said_in_script(source: str) -> frozenset[str]:
    """Return the English words that a script says."""
    return frozenset(json.loads(words) for words in SAID_WORDS.findall(source))
