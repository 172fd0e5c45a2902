"""The command ``trainer debrief``: a recording in, a page out."""

import json
import tempfile
from pathlib import Path

import click
import numpy as np

from trainer.config import ConfigError
from trainer.debrief.dossier import Dossier, gather
from trainer.debrief.figures import figures
from trainer.debrief.page import BADGE, render
from trainer.io.whole_file import write_whole
from trainer.printing import print_pdf
from trainer.records.log_book import reading

HEAD = 2000  # [characters] in which a page of ours says that it is


def debrief_file(
    path: Path, html: Path | None, pdf: Path | None, branch: int | None, *, as_json: bool
) -> None:
    """Write the page as HTML or PDF, and print where it is, or the figures.

    Asked for neither, it goes beside the recording as HTML. ConfigError on what is wrong.
    """
    for wanted in filter(None, (html, pdf)):
        _refuse_recording(path, wanted)
    if html is None and pdf is None and not as_json:
        html = beside(path, branch)
        _refuse_other(html)
    with np.errstate(all="ignore"):  # a state may hold any number
        dossier = read_dossier(path, branch)
        page = render(dossier) if html or pdf else ""
    written = []
    if html is not None:
        _write(html, page)
        written.append(html)
    if pdf is not None:
        _print(page, pdf)
        written.append(pdf)
    if as_json:
        click.echo(json.dumps(figures(dossier), indent=1))
    else:
        click.echo("\n".join(map(str, written)))


def read_dossier(path: Path, branch: int | None) -> Dossier:
    """Return the dossier of a recording; ConfigError if it cannot be read."""
    with reading(path) as recording:
        return gather(recording, path, branch)


def beside(path: Path, branch: int | None) -> Path:
    """Return where the page of a recording goes unless told otherwise."""
    return path.with_name(path.stem + ("" if branch is None else f".branch{branch}") + ".html")


def _refuse_recording(path: Path, wanted: Path) -> None:
    """Refuse to write over the recording."""
    if wanted.exists() and path.exists() and wanted.samefile(path):
        raise ConfigError(f"{wanted} is the recording itself: give another name")


def _refuse_other(html: Path) -> None:
    """Refuse to replace, without being told to, what is no debrief."""
    if not html.exists():
        return
    try:
        with html.open(encoding="utf-8", errors="replace") as file:
            ours = BADGE in file.read(HEAD)
    except OSError:
        ours = False
    if not ours:
        raise ConfigError(f"{html} is there and is no debrief: say --html FILE")


def _write(path: Path, page: str) -> None:
    try:
        write_whole(path, page)
    except OSError as error:
        raise ConfigError(f"{path} cannot be written: {error.strerror}") from None


def _print(page: str, pdf: Path) -> None:
    with tempfile.TemporaryDirectory() as folder:
        html = Path(folder) / "debrief.html"
        _write(html, page)
        print_pdf(html, pdf)
