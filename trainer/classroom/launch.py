"""The start of a class, new or resumed, and its end in order."""

import contextlib
import signal
import socket
import sys
import tempfile
import threading
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import Final, NamedTuple, NoReturn

import click

from trainer.classroom.distant import DistantBoat
from trainer.classroom.entrance import class_pages
from trainer.classroom.fleet import BoatState, Fleet
from trainer.classroom.one_sea import OneSea
from trainer.config.exercise.class_file import (
    CLASS_FILE_NAME,
    ClassFile,
    class_text,
    kept_class,
    load_class,
    with_exercises,
)
from trainer.config.files import ConfigError, is_path, write_once
from trainer.io import client
from trainer.io.paths import dated_name, made_folder, recordings_folder
from trainer.io.serial_line import LinkError
from trainer.web.address import Address, announce_address
from trainer.web.front import front_of
from trainer.web.launch import address_of, certificate_of, listen_for_browsers, send_no_pulse
from trainer.web.server import Certificate, serve_at_socket

END_SIGNALS: Final = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)


def new_folder(asked: Path | None, planned: ClassFile) -> Path:
    """Make the folder of a new class and return it; ConfigError if it has one."""
    usual = recordings_folder() / f"class-{dated_name(planned.exercises[0])}"
    folder = made_folder((asked or usual).absolute())
    if (folder / CLASS_FILE_NAME).exists():
        raise ConfigError(
            f"--folder {folder}: there is a class already: trainer class --resume {folder}"
        )
    write_once(folder / CLASS_FILE_NAME, class_text(with_exercises(planned, whole_path)))
    folder.chmod(0o700)
    return folder


def whole_path(exercise: str) -> str:
    """Return an exercise so that it is found from any folder."""
    return str(Path(exercise).absolute()) if is_path(exercise) else exercise


@dataclass(frozen=True)
class ClassSite:
    """Where the pages of a class are."""

    web: str  # HOST:PORT
    cert: Path | None = None
    key: Path | None = None
    public_url: str | None = None
    proxy: tuple[str, ...] = ()


class Place(NamedTuple):
    """Where the pages of a class are: listened at already."""

    listener: socket.socket
    address: Address
    certificate: Certificate | None


@contextlib.contextmanager
def listening_at(site: ClassSite) -> Iterator[Place]:
    """Listen for browsers inside the block; ConfigError, before anything else is done."""
    certificate = certificate_of(site.cert, site.key)
    front = front_of(site.public_url, site.proxy, site.cert)
    address = address_of(site.web, certificate, front)
    with listen_for_browsers(address) as listener:
        port = listener.getsockname()[1]
        yield Place(listener, replace(address, port=port), certificate)


def begin_class(
    planned: ClassFile, asked: Path | None, tokens: Sequence[str], site: ClassSite
) -> int:
    """Begin a new class and serve it to its end; return the exit code.

    ConfigError, before anything is left behind.
    """
    refuse_addresses(planned)
    with listening_at(site) as place:
        return serve_class(planned, new_folder(asked, planned), tokens, place)


def resume_class(folder: Path, tokens: Sequence[str], site: ClassSite) -> int:
    """Go on with the class of a folder, to its end; return the exit code. ConfigError."""
    kept_class(folder)
    planned = load_class(folder / CLASS_FILE_NAME)
    refuse_addresses(planned)
    with listening_at(site) as place:
        return serve_class(planned, folder.absolute(), tokens, place)


def serve_class(planned: ClassFile, folder: Path, tokens: Sequence[str], place: Place) -> int:
    """Keep the boats of a class at sea, and serve their pages.

    It ends by Ctrl-C, by a signal, or when no boat will be at sea again. The exit code is 1 if none
    could go to sea.
    """
    for number in END_SIGNALS:
        signal.signal(number, leave_program)
    with tempfile.TemporaryDirectory(prefix="trainer-class-") as sockets:
        fleet = Fleet(planned, folder, Path(sockets), tokens, tell, distant_boats(planned))
        sea = sea_of(fleet)
        tell(f"{planned.boats} boats; all they leave is kept in {folder}")
        try:
            fleet.begin()
            if sea:
                sea.begin()
            threading.Thread(target=leave_after, args=(fleet,), daemon=True).start()
            for boat in fleet.boats.values():
                tell(f"{boat.title}: trainer attach --connect {boat.address}")
            tell(f"the instructor's page is {place.address.url}class")
            click.echo(announce_address(place.address), err=True)
            pages = partial(class_pages, fleet.boats, guarded=bool(tokens))
            listener, address, certificate = place
            serve_at_socket(pages, listener, address, certificate, send_no_pulse)
        except SystemExit:  # the only way out of the pages, by a signal
            pass
        finally:
            for number in END_SIGNALS:  # the end has a limit of its own, and is not to be cut off
                signal.signal(number, signal.SIG_IGN)
            tell("the class ends")
            if sea:
                sea.end()
            fleet.end()
    if all(boat.state is BoatState.LOST for boat in fleet.boats.values()):
        return 1
    tell(f"it goes on by: trainer class --resume {folder}")
    return 0


def distant_boats(planned: ClassFile) -> dict[int, DistantBoat]:
    """Return the boats whose sessions run elsewhere, by their numbers."""
    return {row.number: DistantBoat(row, tell) for row in planned.boat if row.on}


def sea_of(fleet: Fleet) -> OneSea | None:
    """Return the one sea of a class; None where each boat is alone."""
    spacing = fleet.planned.one_sea_m
    if spacing is None:
        return None
    heads = (each.partition("instructor=") for each in fleet.tokens)
    words = (word for before, head, word in heads if head and not before)
    tell(f"all boats are in one sea, each {spacing:g} m east of the one before")
    return OneSea(fleet.boats, spacing, next(words, ""), tell)


def refuse_addresses(planned: ClassFile) -> None:
    """Raise ConfigError for an address where no session can be."""
    for row in (each for each in planned.boat if each.on):
        try:
            client.check(row.on or "")
        except LinkError as wrong:
            raise ConfigError(f"{row.title}: on {wrong}") from None


def leave_after(fleet: Fleet) -> None:
    """End this program when no boat will be at sea again."""
    fleet.await_end()
    signal.pthread_kill(threading.main_thread().ident or 0, signal.SIGTERM)


def leave_program(*_signal: object) -> NoReturn:
    """End this program, as its user has asked; exit code 0."""
    sys.exit(0)


def tell(text: str) -> None:
    """Tell the terminal something. Any thread may call this."""
    click.echo(f"class: {text}", err=True)
