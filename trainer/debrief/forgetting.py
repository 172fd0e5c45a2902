"""A trainee's name forgotten: in recordings, progress, classes, and what was made of them.

``trainer recordings --forget`` calls it, and each step is told.
"""

import csv
import io
import json
import re
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Final

import click
from markupsafe import escape

from trainer.config.class_file import class_folders, forget_in_classes
from trainer.config.files import ConfigError, nearest, quote, renew_file
from trainer.config.progress import forget_progress
from trainer.debrief.changes import read_changes, write_changes
from trainer.debrief.class_debrief import CLASS_HEADER
from trainer.debrief.forms import EvaluationForm, read_forms, write_forms
from trainer.debrief.history import fold_name, marks_path, recordings_in, searched, unforeseen
from trainer.debrief.page import BADGE_SEARCH_CHARS, PAGE_BADGE
from trainer.debrief.progress_words import CSV_HEADER
from trainer.debrief.run_summary import summary_path
from trainer.debrief.watches import persons_in
from trainer.io.recording.recording import RecordingError, erase_header
from trainer.session.past.header import TRAINEES_KEY, open_recording, trainees_of

REMOVED_NAME: Final = "(name removed)"


class NoSuchTraineeError(ConfigError):
    """No recording has the name."""


def forget_trainee(name: str, recordings: Iterable[Path]) -> Iterator[str]:
    """Remove a name everywhere, and yield each step; ConfigError if no recording has it."""
    names: set[str] = set()
    done, troubles = 0, []
    for path in recordings:
        try:
            with open_recording(path) as recording:
                trainees = trainees_of(recording.header())
        except ConfigError:  # it is no recording, or damaged: it is not ours to change
            continue
        try:
            named = {*trainees, *persons_in(path), *(form.by for form in read_forms(path))}
            names |= named
            if fold_name(name) in map(fold_name, named):
                yield from _forget(name, path, trainees)
                done += 1
        except (ConfigError, RecordingError) as wrong:
            troubles.append(str(wrong))
        except Exception as wrong:  # noqa: BLE001 the name has to go from the others
            troubles.append(unforeseen(path, wrong))
    if troubles:
        raise ConfigError(*(f"--forget: the name is still in it: {each}" for each in troubles))
    if not done:
        raise NoSuchTraineeError(
            f"--forget {quote(name)}: no recording has that name{nearest(name, names)}"
        )


def _forget(name: str, path: Path, trainees: tuple[str, ...]) -> Iterator[str]:
    """Remove a name from one recording and from the files beside it."""
    others = [each for each in trainees if fold_name(each) != fold_name(name)]
    without = _remover(name)
    remarks = erase_header(path, {TRAINEES_KEY: json.dumps(others) if others else None}, without)
    for kept in (marks_path(path), summary_path(path)):  # of another state of the recording
        kept.unlink(missing_ok=True)
    changes = read_changes(path)
    if changes:
        write_changes(path, [replace(each, reason=without(each.reason)) for each in changes])
    forms = read_forms(path)
    if forms:
        write_forms(path, [_nameless(form, name, without) for form in forms])
    remark_words = f"; also from {remarks} remark{'s' if remarks > 1 else ''}" if remarks else ""
    yield f"{path}: the name is removed{remark_words}"
    yield from _pages(name, path)


def _nameless(form: EvaluationForm, name: str, without: Callable[[str], str]) -> EvaluationForm:
    """Return a filled form without a name, which may be of who filled it in."""
    by = REMOVED_NAME if fold_name(form.by) == fold_name(name) else form.by
    return replace(form, by=by, remark=form.remark and without(form.remark))


def _remover(name: str) -> Callable[[str], str]:
    """Return a function that removes a name from a text. A bare number stays: it may be any."""
    if not re.search(r"[^\W\d_]", name):
        return lambda text: text
    words = r"\s+".join(re.escape(word) for word in name.split())
    pattern = re.compile(rf"(?<!\w){words}(?!\w)", re.IGNORECASE)
    return lambda text: pattern.sub(REMOVED_NAME, text)


def forget_in_papers(folders: Iterable[Path], name: str) -> Iterator[str]:
    """Remove a name from what lies in folders of classes; yield each step. ConfigError.

    That are pages, tables that ``trainer class debrief`` has written there, and what boats said.
    """
    without = _remover(name)
    for folder in (kept for each in folders for kept in class_folders(each)):
        yield from _remove_pages(name, (*folder.glob("*.html"), *folder.glob("*/*.html")))
        for path in sorted((*folder.glob("*.csv"), *folder.glob("*/*.csv"))):
            yield from _renew(path, _nameless_table(path, name))
        for path in sorted(folder.glob("boat-*.log")):
            yield from _renew(path, without(_text_of(path)))


def _renew(path: Path, text: str) -> Iterator[str]:
    """Write a text over a file if it is another one, and yield that."""
    if text != _text_of(path):
        renew_file(path, text)
        yield f"{path}: the name is removed"


def _text_of(path: Path) -> str:
    return path.read_bytes().decode("utf-8", "surrogateescape")


def _nameless_table(path: Path, name: str) -> str:
    """Return a table of ours without a trainee's name; one of others as it is."""
    text = _text_of(path)
    rows = list(csv.reader(io.StringIO(text, newline="")))
    if not rows or tuple(rows[0]) not in (CLASS_HEADER, CSV_HEADER):
        return text
    place, written = rows[0].index("trainee"), io.StringIO(newline="")
    for row in rows:
        if fold_name(row[place]) == fold_name(name):
            row[place] = REMOVED_NAME
    csv.writer(written).writerows(rows)
    return written.getvalue()


def _pages(name: str, path: Path) -> Iterator[str]:
    """Remove the debriefs beside a recording that show a name; yield those, and doubtful ones."""
    yield from _remove_pages(name, path.parent.glob(f"{_literal(path.stem)}*.html"))
    for printed in sorted(path.parent.glob(f"{_literal(path.stem)}*.pdf")):
        yield f"{printed}: may show the name: look, and remove it"


def _remove_pages(name: str, pages: Iterable[Path]) -> Iterator[str]:
    """Remove those debriefs among some pages that show a name, and yield them."""
    shown = fold_name(str(escape(name)))
    for page in sorted(pages):
        text = page.read_text(encoding="utf-8", errors="replace")
        if PAGE_BADGE in text[:BADGE_SEARCH_CHARS] and shown in fold_name(text):
            page.unlink()
            yield f"{page}: removed, it showed the name; a debrief makes it anew"


def _literal(stem: str) -> str:
    """Return a file pattern that matches this name alone."""
    return re.sub(r"([*?[])", r"[\1]", stem)


def print_forgotten(sources: Sequence[Path], name: str) -> None:
    """Remove a name and print where it stood; ConfigError if nowhere, or not removable."""
    removed = [f"{path}: removed" for path in forget_progress(name)]
    folders = searched(sources)
    removed += forget_in_classes(folders, lambda one: fold_name(one) == fold_name(name))
    removed += forget_in_papers(folders, name)
    for line in removed:
        click.echo(line)
    try:
        for line in forget_trainee(name, recordings_in(sources)):
            click.echo(line)
    except NoSuchTraineeError:
        if not removed:
            raise
