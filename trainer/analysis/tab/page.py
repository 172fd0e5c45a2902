"""What goes into a page with a boat inside, and the file that it is written to."""

from pathlib import Path
from typing import Any, NamedTuple

import click

from trainer.analysis.tab.boat import boat_for_page
from trainer.analysis.tab.recording import boat_of
from trainer.boat.boat import Boat
from trainer.boat.export.wasm import shipped
from trainer.config.files import ConfigError
from trainer.io.atomic_write import write_whole


class Parts(NamedTuple):
    """The boat as a page knows her, the core, and the page's title."""

    boat: dict[str, Any]
    core: bytes
    title: str


def page_of(boat: Boat | None, recording: Path | None, role: str) -> Parts:
    """Return the parts of a page of a boat at her start, or of a recording."""
    told = None
    if recording is not None:
        boat, told = boat_of(recording)
    if boat is None:
        raise ValueError("a page has a boat or a recording")
    core = shipped(boat)
    numbers = boat_for_page(boat, role) | {"recording": told}
    title = boat.file.name if told is None else f"{boat.file.name}: {told['from']}"
    return Parts(numbers, core, title)


def write_page(path: Path, text: str, recording: Path | None) -> None:
    """Write the page whole and print its name; ConfigError where it cannot be written."""
    if recording is not None and path.exists() and path.samefile(recording):
        raise ConfigError(f"{path} is the recording itself: give another name")
    try:
        write_whole(path, text)
    except OSError as error:
        raise ConfigError(f"{path} cannot be written: {error.strerror}") from None
    click.echo(f"{path}  {path.stat().st_size / 1000:.0f} kB")
