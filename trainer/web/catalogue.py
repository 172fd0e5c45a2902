"""Words of the pages in other languages, read from gettext catalogues: `locale/LANGUAGE.po`.

Pages hold plain text alone: no contexts, no plurals. So this reader is shorter than a dependency.
"""

import ast
import re
from pathlib import Path
from typing import Final

from trainer.config.files import ConfigError, read_text

LOCALE: Final = Path(__file__).parent / "locale"
KNOWN: Final = ("msgid", "msgstr")
LINE: Final = re.compile(r'(?:(\w+(?:\[\d+\])?)\s+)?("(?:[^"\\]|\\.)*")')
HOLE: Final = re.compile(r"\{\d\}")  # where a value stands

Catalogue = dict[str, str]  # what is said, by the English words


def catalogues(folder: Path = LOCALE) -> dict[str, Catalogue]:
    """Return the catalogues by their languages, such as "de"; ConfigError if one is wrong."""
    return {path.stem: read_catalogue(path) for path in sorted(folder.glob("*.po"))}


def read_catalogue(path: Path) -> Catalogue:
    """Return the entries of a catalogue that are translated; ConfigError for what is none."""
    found: Catalogue = {}
    for first, msgid, msgstr, fuzzy in entries(path):
        if sorted(HOLE.findall(msgid)) != sorted(HOLE.findall(msgstr)) and msgstr:
            raise ConfigError(f"{path.name}: line {first}: {msgstr!r}: not the holes of {msgid!r}")
        if msgid in found:
            raise ConfigError(f"{path.name}: line {first}: msgid {msgid!r}: is there twice")
        if msgid and msgstr and not fuzzy:
            found[msgid] = msgstr
    return found


def entries(path: Path) -> list[tuple[int, str, str, bool]]:
    """Return the entries of a catalogue: line, msgid, msgstr, and whether it is in doubt."""
    found: list[tuple[int, str, str, bool]] = []
    texts: dict[str, str] = {}
    key, first, fuzzy = "", 0, False
    for number, line in enumerate([*read_text(path).splitlines(), ""], 1):
        words = line.strip()
        if not words and "msgid" in texts:
            found.append((first, texts["msgid"], texts.get("msgstr", ""), fuzzy))
        if not words:
            texts, key, fuzzy = {}, "", False
        elif words.startswith("#"):
            fuzzy = fuzzy or (words.startswith("#,") and "fuzzy" in words)
        else:
            said, text = read_line(words, f"{path.name}: line {number}")
            first = number if said == "msgid" else first
            key = said or key
            texts[key] = texts.get(key, "") + text
    return found


def read_line(line: str, place: str) -> tuple[str, str]:
    """Return the keyword of a line, "" where it goes on, and its text; ConfigError."""
    match = LINE.fullmatch(line)
    if match is None or match[1] not in (None, *KNOWN):
        raise ConfigError(f"{place}: {line}: expected {' or '.join(KNOWN)} and a text in quotes")
    return match[1] or "", str(ast.literal_eval(match[2]))
