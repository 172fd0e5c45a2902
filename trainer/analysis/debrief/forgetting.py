"""The name of a trainee removed: from recordings, remarks, changed marks, and pages beside them."""

import json
import re
from collections.abc import Callable, Iterable, Iterator
from dataclasses import replace
from pathlib import Path
from typing import Final

from markupsafe import escape

from trainer.analysis.debrief.changes import read_changes, write_changes
from trainer.analysis.debrief.history import folded, marks_path
from trainer.analysis.debrief.page import BADGE
from trainer.config.files import ConfigError, nearest, quote
from trainer.io.recording.erasure import erase
from trainer.io.recording.recording import RecordingError
from trainer.session.header import TRAINEES, reading, trainees_of

REMOVED: Final = "(name removed)"
HEAD: Final = 2000  # [characters] in which a page of ours says that it is


def forget(name: str, recordings: Iterable[Path]) -> Iterator[str]:
    """Remove a name everywhere, and yield what was done; ConfigError if no recording has it."""
    names: set[str] = set()
    done, left = 0, []
    for path in recordings:
        try:
            with reading(path) as recording:
                trainees = trainees_of(recording.header())
        except ConfigError:  # it is no recording, or damaged: it is not ours to change
            continue
        names.update(trainees)
        if folded(name) not in map(folded, trainees):
            continue
        try:
            yield from _forget(name, path, trainees)
            done += 1
        except (ConfigError, RecordingError) as wrong:
            left.append(str(wrong))
    if left:
        raise ConfigError(*(f"--forget: the name is still in it: {each}" for each in left))
    if not done:
        raise ConfigError(
            f"--forget {quote(name)}: no recording has that name{nearest(name, names)}"
        )


def _forget(name: str, path: Path, trainees: tuple[str, ...]) -> Iterator[str]:
    """Remove a name from one recording and from what is beside it."""
    others = [each for each in trainees if folded(each) != folded(name)]
    without = _remover(name)
    remarks = erase(path, {TRAINEES: json.dumps(others) if others else None}, without)
    marks_path(path).unlink(missing_ok=True)  # it is of another state of the recording
    changes = read_changes(path)
    if changes:
        write_changes(path, [replace(each, reason=without(each.reason)) for each in changes])
    told = f"; also from {remarks} remark{'s' if remarks > 1 else ''}" if remarks else ""
    yield f"{path}: the name is removed{told}"
    yield from _pages(name, path)


def _remover(name: str) -> Callable[[str], str]:
    """Return what takes a name out of a text; a number alone stays, it may be any."""
    if not re.search(r"[^\W\d_]", name):
        return lambda text: text
    words = r"\s+".join(re.escape(word) for word in name.split())
    found = re.compile(rf"(?<!\w){words}(?!\w)", re.IGNORECASE)
    return lambda text: found.sub(REMOVED, text)


def _pages(name: str, path: Path) -> Iterator[str]:
    """Remove the debriefs beside a recording that show a name; yield which, and what may."""
    shown = folded(str(escape(name)))
    for page in sorted(path.parent.glob(f"{_literal(path.stem)}*.html")):
        text = page.read_text(encoding="utf-8", errors="replace")
        if BADGE in text[:HEAD] and shown in folded(text):
            page.unlink()
            yield f"{page}: removed, it showed the name; trainer debrief makes it anew"
    for printed in sorted(path.parent.glob(f"{_literal(path.stem)}*.pdf")):
        yield f"{printed}: may show the name: look, and remove it"


def _literal(stem: str) -> str:
    """Return a name as a pattern of files that matches it alone."""
    return re.sub(r"([*?[])", r"[\1]", stem)
