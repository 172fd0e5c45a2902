"""A trainee's name forgotten: in recordings, progress, classes, and what was made of them.

``trainer recordings --forget`` calls it. Every file of a folder is looked through, as it lies on
the disk, before it is cleaned and after. What is the trainer's own is cleaned, each file by itself;
where a name still stands is told.
"""

import glob
import html
import json
import os
import re
import unicodedata
from collections.abc import Collection, Iterable, Iterator, Sequence
from contextlib import suppress
from pathlib import Path
from typing import Final
from urllib.parse import quote as percented

import click
from markupsafe import escape

from trainer.config.exercise.class_file import CLASS_FILE_NAME
from trainer.config.exercise.progress import forget_progress
from trainer.config.files import ConfigError, nearest, quote
from trainer.debrief.page.page import PAGE_BADGE
from trainer.debrief.passage.watches import persons_in
from trainer.debrief.trainees.history import MARKS_SUFFIX, fold_name, searched, unforeseen
from trainer.debrief.trainees.run_summary import SUMMARY_SUFFIX
from trainer.io.orders.table import FORMS
from trainer.io.outputs import renewing
from trainer.io.paths import RECORDING_SUFFIX
from trainer.io.recording.recording import RecordingError, erase_texts, texts_in
from trainer.session.past.header import TRAINEES_KEY, open_recording, trainees_of

REMOVED_NAME: Final = "(name removed)"
# How files are written that others have saved again; "utf-8" is ours
NAME_CODECS: Final = (
    *("utf-8", "cp1250", "cp1251", "cp1252", "cp1253", "cp1254", "cp1257"),
    *("gb18030", "shift_jis", "euc_kr"),
)
WIDE_CODECS: Final = ("utf_16_le", "utf_16_be")
NARROW_GAP: Final = rb"(?:\s|\xc2?\xa0|%20|&nbsp;|\\[nrt])+"  # between the words of a name
# Letters before or after, which make it another word; those of two bytes are Latin to Arabic
NO_LETTER_BEFORE: Final = rb"(?:(?<![0-9A-Za-z_])(?<![\xc3-\xdf][\x80-\xbf])|(?<=\\[nrt])|(?<=%20))"
NO_LETTER_AFTER: Final = rb"(?![0-9A-Za-z_]|[\xc3-\xdf][\x80-\xbf])"
# Where a bare number is a name: anywhere else it may be any
NUMBER_PLACES: Final = (
    rb"(?<=relief )%b(?!\w)|(?<!\w)%b(?= has the watch| is relieved)|"
    rb'(?<=[^\\]")%b(?=")|(?<=>)%b(?=<)|(?<![^,;\t\r\n])%b(?=[,;\t]"?[a-z])'
)
HEAD_BYTES: Final = 4000  # of a file, by which it is known
CHUNK_BYTES, OVERLAP_BYTES = 1 << 20, 4096  # [bytes] read at once, and again with the next
OWN_TOML: Final = re.compile(rb'^schema = "(?:changes|forms?)/', re.MULTILINE)
OWN_COLUMNS: Final = ({b"trainee", b"exercise"}, {b"tick", b"who", b"text"})  # of tables
CLASS_NAMES: Final = re.compile(rb"^(?:trainees|name) = .*$", re.MULTILINE)
LISTED_REMOVED: Final = re.compile(rb'"\(name removed\)", |(?:, )?"\(name removed\)"(?=\])')
# What begins a file whose content is packed, so that no name is seen in it
PACKED_HEADS: Final = (
    b"%PDF",
    b"PK\3\4",
    b"\x1f\x8b",
    b"\xfd7zXZ",
    b"BZh",
    b"\x28\xb5\x2f\xfd",
    b"RRF",
)


class SoughtName:
    """A name, as it is found in the bytes of any file."""

    def __init__(self, name: str, others: Iterable[str] = ()) -> None:
        """Take a name, and those of others, of which it may be a part."""
        self.name = name
        run = max(re.findall("[0-9A-Za-z]+", name), key=len, default="").lower()
        self.runs = (run.encode(), run.encode("utf-16-le"))  # quickly looked for
        longer = [each for each in others if fold_name(name) in fold_name(each) != fold_name(name)]
        kept = [spelt for each in longer for spelt in _spelt(each, whole=False).values()]
        own = [b"(?P<%b>%b)" % (codec.encode(), each) for codec, each in _spelt(name).items()]
        found = [b"(?P<other>%b)" % b"|".join(kept), *own] if kept else own
        self.pattern = re.compile(b"|".join(found), re.IGNORECASE)
        # in the bytes of a recording one text follows the other; in a damaged one that is all
        self.loose = re.compile(_spelt(name, whole=False)["utf_8"], re.IGNORECASE)

    def is_in(self, path: Path) -> bool:
        """Return whether it stands in the bytes of a file or its texts; OSError."""
        places = self.places_in(path) if path.suffix == RECORDING_SUFFIX else []
        pattern = self.pattern if places is not None else self.loose
        with path.open("rb") as file:
            data = b""
            while not places and (chunk := file.read(CHUNK_BYTES)):
                data = data[-OVERLAP_BYTES:] + chunk
                lowered = data.lower()
                if any(each in lowered for each in self.runs) and self.stands_in(data, pattern):
                    return True
        return bool(places)

    def stands_in(self, data: bytes, pattern: re.Pattern[bytes] | None = None) -> bool:
        """Return whether it stands in some bytes, and not as a part of another's."""
        found = (pattern or self.pattern).finditer(data)
        return any(each.lastgroup != "other" for each in found)

    def places_in(self, path: Path) -> list[str] | None:
        """Return where it stands in the texts of a recording, None if unreadable."""
        with suppress(RecordingError):
            return [place for place, text in texts_in(path) if self.stands_in(text.encode())]
        return None

    def without(self, text: str) -> str:
        """Return a text without it."""
        return self.taken_from(text.encode("utf-8", "surrogateescape")).decode(
            "utf-8", "surrogateescape"
        )

    def taken_from(self, data: bytes) -> bytes:
        """Return the bytes of a text without it, in the encoding that they have."""

        def replaced(found: re.Match[bytes]) -> bytes:
            codec = found.lastgroup or ""
            return found[0] if codec == "other" else REMOVED_NAME.encode(codec)

        return self.pattern.sub(replaced, data)


def _spelt(name: str, *, whole: bool = True) -> dict[str, bytes]:
    """Return patterns of a name by their encodings, by default as words of its own."""
    words = unicodedata.normalize("NFC", name).split()
    if not re.search(r"[^\W\d_]", name):
        return {"utf_8": NUMBER_PLACES.replace(b"%b", re.escape(" ".join(words).encode()))}
    narrow = NARROW_GAP.join(b"".join(map(_narrow_letter, word)) for word in words)
    narrow = NO_LETTER_BEFORE + narrow + NO_LETTER_AFTER if whole else narrow
    signs = [_cases(sign) for sign in " ".join(words)]
    wide = {each: b"".join(_any_of(sign, each) for sign in signs) for each in WIDE_CODECS}
    order_words = {word for form in FORMS for word in form.pattern.casefold().split()}
    capital = b"(?-i:(?=[A-Z]))" if fold_name(name) in order_words else b""  # Mark, who says mark
    return {codec: capital + each for codec, each in {"utf_8": narrow, **wide}.items()}


def _narrow_letter(sign: str) -> bytes:
    """Return a pattern of a character, as texts, JSON, tables, pages and addresses have it."""
    escapes = (lambda case: json.dumps(case)[1:-1]), html.escape, escape, percented
    cases = _cases(sign)
    return _any_of(
        {*cases, *(str(spell(case)) for spell in escapes for case in cases)}, *NAME_CODECS
    )


def _cases(sign: str) -> set[str]:
    """Return a character large and small, its accent apart, as a quote doubled in tables."""
    cases = {sign, sign.lower(), sign.upper(), sign.replace('"', '""')}
    return cases | {unicodedata.normalize("NFD", case) for case in cases}


def _any_of(spelt: Iterable[str], *codecs: str) -> bytes:
    """Return a pattern of any of some texts in any encoding that has them."""
    found = set()
    for text in spelt:
        for codec in codecs:
            with suppress(UnicodeEncodeError):
                found.add(text.encode(codec))
    return b"(?:%b)" % b"|".join(map(re.escape, sorted(found, key=len, reverse=True)))


def forget_trainee(name: str, files: Iterable[Path], left: list[str]) -> Iterator[str]:
    """Remove a name from files, recordings first, and yield each step.

    What still has it is added to ``left``, with why.
    """
    cleaned = set[Path]()
    ordered = sorted(files, key=lambda path: (path.suffix != RECORDING_SUFFIX, path))
    sought = SoughtName(name, names_in(ordered))
    for path in ordered:
        step, why = _forget_in(path, sought)
        if step or why:
            cleaned.add(path)
        if why:
            left.append(f"{path}: {why}")
        elif step:
            yield f"{path}: {step}"
        if path.exists() and sought.stands_in(os.fsencode(path.name)):
            left.append(f"{path}: its own name has it: give it another")
    if cleaned:
        left += [f"{each}: is packed, and may show it" for each in _doubtful(ordered, cleaned)]


def _forget_in(path: Path, sought: SoughtName) -> tuple[str, str]:
    """Remove a name from a file; return what was done, and why the name is still in it."""
    step = why = ""
    try:
        if path.exists() and sought.is_in(path):  # the log of a recording goes with the name
            step = _clean(path, sought)
            if path.exists() and sought.is_in(path):
                why = ", ".join(sought.places_in(path) or ["where the trainer writes none"])
    except OSError as wrong:
        return step, f"the name may be in it: {wrong.strerror}"
    except (ConfigError, RecordingError) as wrong:
        why = str(wrong)
    except Exception as wrong:  # noqa: BLE001 the name has to go from the others
        why = unforeseen(path, wrong)
    return step, why and f"the name is still in it: {why}"


def _clean(path: Path, sought: SoughtName) -> str:
    """Remove a name from a file of the trainer's own; return what was done. One of others stays."""
    if path.suffix == RECORDING_SUFFIX:
        with open_recording(path) as recording:
            trainees = trainees_of(recording.header())
        others = [each for each in trainees if fold_name(each) != fold_name(sought.name)]
        erase_texts(path, {TRAINEES_KEY: json.dumps(others) if others else None}, sought.without)
    elif _is_made_anew(path):
        path.unlink()
        return "removed, it showed the name; a debrief makes it anew"
    elif _is_own_text(path):
        data = path.read_bytes()
        if path.name == CLASS_FILE_NAME:
            data = CLASS_NAMES.sub(lambda line: sought.taken_from(line[0]), data)
            data = LISTED_REMOVED.sub(b"", data)
        else:
            data = sought.taken_from(data)
        with renewing(path) as made:
            made.write_bytes(data)
    return "the name is removed"


def _head(path: Path) -> bytes:
    with path.open("rb") as file:
        return file.read(HEAD_BYTES)


def _is_made_anew(path: Path) -> bool:
    """Return whether a file is the page or the result of a debrief."""
    kept = path.name.endswith((MARKS_SUFFIX, SUMMARY_SUFFIX))
    return kept or PAGE_BADGE.encode() in _head(path)


def _is_own_text(path: Path) -> bool:
    """Return whether a text is the trainer's: of a class, a table, or what somebody thinks."""
    head = _head(path)
    if path.suffix == ".csv":
        first = head.replace(b"\0", b"").partition(b"\n")[0]
        cells = set(re.split(rb'[,;\t\r"\xef\xbb\xbf\xff\xfe]+', first))
        return any(columns <= cells for columns in OWN_COLUMNS)
    of_class = path.with_name(CLASS_FILE_NAME).is_file()
    said = of_class and re.fullmatch(r"boat-\d+\.log", path.name)
    return bool(said or path.name == CLASS_FILE_NAME or OWN_TOML.search(head))


def _doubtful(files: Sequence[Path], cleaned: Collection[Path]) -> Iterator[Path]:
    """Yield files that no name is seen in, but those made of a recording without it."""
    stems = {path: path.stem for path in files if path.suffix == RECORDING_SUFFIX}
    for path in files:
        beside = [each for each in stems if path.name.startswith(stems[each])]
        beside = [each for each in beside if each.parent == path.parent]
        with suppress(OSError):  # it is gone by now, or was told already
            if not beside or max(beside, key=lambda each: len(stems[each])) in cleaned:
                yield from [path] if _head(path).startswith(PACKED_HEADS) else ()


def files_of(sources: Sequence[Path], left: list[str]) -> Iterator[Path]:
    """Yield all files of folders, and recordings with what lies beside them; ConfigError.

    A folder that cannot be looked through is added to ``left``.
    """

    def tell(wrong: OSError) -> None:
        left.append(f"{wrong.filename}: the name may be in it: {wrong.strerror}")

    for source in searched(sources):
        if not source.exists():
            raise ConfigError(f"{source}: there is no such file or folder")
        if source.is_dir():
            walked = os.walk(source, onerror=tell)
            found = [Path(folder, name) for folder, _, names in walked for name in names]
        else:
            beside = source.parent.glob(f"{glob.escape(source.stem)}*")
            found = [path for path in beside if path == source or path.suffix != RECORDING_SUFFIX]
        yield from (path for path in found if path.is_file())


def print_forgotten(sources: Sequence[Path], name: str) -> int:
    """Remove a name, print where it stood and still stands; return the exit code.

    ConfigError if it is nowhere, or none.
    """
    if not re.search(r"\w", name):
        raise ConfigError(f"--forget {quote(name)}: say whose name; this is none")
    left, found = list[str](), False
    files = list(files_of(sources, left))
    for line in forget_trainee(name, files, left):
        click.echo(line)
        found = True
    try:
        for path in forget_progress(name):
            click.echo(f"{path}: removed")
            found = True
    except ConfigError:  # no trainee's file can have this name
        pass
    except OSError as wrong:
        left.append(f"{wrong.filename}: the name is still in it: {wrong.strerror}")
    for line in left:
        click.echo(f"trainer: --forget: {line}", err=True)
    if not (found or left):
        raise ConfigError(
            f"--forget {quote(name)}: no recording has that name{nearest(name, names_in(files))}"
        )
    return 1 if left else 0


def names_in(files: Iterable[Path]) -> set[str]:
    """Return the trainees and the persons of the watches that recordings name."""
    names: set[str] = set()
    for path in (each for each in files if each.suffix == RECORDING_SUFFIX):
        with suppress(Exception), open_recording(path) as recording:  # told where it is cleaned
            names.update(trainees_of(recording.header()))
            names |= persons_in(path)
    return names
