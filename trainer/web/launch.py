"""The start of the pages' server: its address, its certificate, the session it serves.

There are two ways in. ``serve_pages`` is the command ``trainer web``: somebody starts the pages for
a session that runs already, or will. ``serve_owner`` is called in a process that a session has
started itself (``session/doors/page_server``): it ends when that session ends, and writes a byte
each second, because the session starts it again when the bytes stop.
"""

import contextlib
import os
import signal
import socket
import ssl
import sys
import threading
from collections.abc import Callable
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Final, NoReturn

import click

from trainer.config.files import ConfigError
from trainer.io import client, paths
from trainer.io.orders import sentences
from trainer.io.orders.grammar import Refused
from trainer.io.serial_line import LinkError
from trainer.io.server import listen_at, parse_address
from trainer.web.address import Address, announce_address, open_page
from trainer.web.bridge import Reach
from trainer.web.front import Front
from trainer.web.server import Certificate, application, serve_at_socket

# X509_V_ERR_CERT_NOT_YET_VALID, X509_V_ERR_CERT_HAS_EXPIRED of OpenSSL
CERTIFICATE_DATE_ERRORS: Final = (9, 10)
HANDSHAKE_ROUNDS: Final = 5  # in memory; three are needed, and a limit ends the loop


class OpenError(LinkError):
    """A session without a token, where other machines could come in by pages."""


def serve_pages(
    url: str | None, address: Address, certificate: Certificate | None, *, opens: bool
) -> None:
    """Serve the pages of the session at ``url``, None for this machine's; ConfigError.

    The pages wait for a session that is not there yet. When it ends, they serve the next one there.
    """
    refuse_other_lines(url)
    reach = find_session(url, address)
    try:
        reach().close()
    except OpenError as error:
        raise ConfigError(str(error)) from None
    except LinkError as error:
        click.echo(f"trainer: {error}; the pages wait for one", err=True)
    run_pages(reach, address, listen_for_browsers(address), certificate, send_no_pulse, opens=opens)


def serve_owner(
    url: str, address: Address, certificate: Certificate | None, owner: int, *, opens: bool
) -> None:
    """Serve the pages of the session that has begun this program, and end with it.

    ``owner`` is the number of the socket that the session has opened, negative where none can be
    inherited. The session itself has checked whether other machines need a token.
    """
    threading.Thread(target=end_with_owner, name="owner", daemon=True).start()
    listener = listen_for_browsers(address) if owner < 0 else socket.socket(fileno=owner)
    pulse = pulse_for_owner()
    run_pages(lambda: client.reach(url), address, listener, certificate, pulse, opens=opens)


def run_pages(
    reach: Reach,
    asked: Address,
    listener: socket.socket,
    certificate: Certificate | None,
    pulse: Callable[[], None],
    *,
    opens: bool,
) -> None:
    """Tell where the pages are, open them, and serve them until a signal."""
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, leave_program)
    address = replace(asked, port=listener.getsockname()[1])
    with listener:
        click.echo(announce_address(address), err=True)
        if opens:
            threading.Thread(
                target=open_pages, args=(address,), name="browser", daemon=True
            ).start()
        serve_at_socket(partial(application, reach), listener, address, certificate, pulse)


def leave_program(*_signal: object) -> NoReturn:
    """End this program, as its user has asked; exit code 0."""
    sys.exit(0)


def open_pages(address: Address) -> None:
    """Open the pages in a browser, or say what to do."""
    if message := open_page(address):
        click.echo(message, err=True)


def refuse_other_lines(url: str | None) -> None:
    """Raise ConfigError for a serial line, because many pages cannot share one."""
    try:
        if url is not None:
            client.check(url)
    except LinkError as error:
        raise ConfigError(f"--connect {error}") from None


def find_session(url: str | None, address: Address) -> Reach:
    """Return a function that connects to the session that is there now.

    For pages beyond this machine it first checks that the session asks for a token. It checks at
    every call, because another session may be there by then.
    """
    front = address.front
    asked = f"--public-url {front.url}" if front else f"--web {address.host}:{address.port}"

    def reach() -> socket.socket:
        at = url or paths.nearest_session()
        if not address.here and not asks_token(at):
            raise OpenError(f"{asked}: beyond this machine only for a session with --token WORD")
        return client.reach(at)

    return reach


def address_of(text: str, certificate: Certificate | None, front: Front | None) -> Address:
    """Return the address of pages at ``HOST:PORT``; ConfigError."""
    try:
        host, port = parse_address(text, f"{paths.DEFAULT_HOST}:{paths.PAGES_PORT}")
    except LinkError as error:
        raise ConfigError(f"--web {error}") from None
    return Address(host, port, certificate is not None, front)


def listen_for_browsers(address: Address) -> socket.socket:
    """Return a socket that listens for browsers; ConfigError."""
    try:
        return listen_at(address.host, address.port)
    except LinkError as error:
        raise ConfigError(f"--web {error}") from None


def end_with_owner() -> None:
    """End this program when its owner, which holds its standard input open, has gone."""
    while os.read(0, 1):
        pass
    signal.raise_signal(signal.SIGTERM)


def send_no_pulse() -> None:
    """Do nothing, because no owner waits for a sign of life."""


def pulse_for_owner() -> Callable[[], None]:
    """Return a function that writes a byte to the standard output, which the owner reads.

    Then the standard output is the null device, because a browser that is started here would
    inherit it and could write to the owner.
    """
    pipe = os.dup(1)
    with Path(os.devnull).open("wb") as nowhere:
        os.dup2(nowhere.fileno(), 1)
    if os.name == "posix":
        os.set_blocking(pipe, False)  # an owner that is stopped reads nothing

    def beat() -> None:
        with contextlib.suppress(OSError):
            os.write(pipe, b".")

    return beat


def certificate_of(cert: Path | None, key: Path | None) -> Certificate | None:
    """Return the files of a certificate and its key, None without; ConfigError for one alone."""
    if cert is None and key is None:
        return None
    if key is None:
        raise ConfigError(f"--cert {cert}: a certificate needs its key: add --key FILE")
    if cert is None:
        raise ConfigError(f"--key {key}: a key needs its certificate: add --cert FILE")
    for option, path in (("--cert", cert), ("--key", key)):
        try:
            path.read_bytes()
        except OSError as error:
            raise ConfigError(f"{option} {path}: {error.strerror}") from None
    try:
        # without this OpenSSL would ask for a password at a terminal that nobody may look at
        server = ssl.SSLContext(ssl.PROTOCOL_TLS_SERVER)
        server.load_cert_chain(cert, key, password=lambda: b"")
    except (OSError, ValueError):
        raise ConfigError(
            f"--cert {cert}, --key {key}: not a certificate and its own key, both PEM, the key "
            "without a password"
        ) from None
    # every browser would refuse it later, and this machine would not hear why
    if refused := out_of_date(server, cert):
        raise ConfigError(f"--cert {cert}: {refused.reason}: no browser takes it; make a new one")
    return Certificate(cert, key)


def out_of_date(server: ssl.SSLContext, cert: Path) -> Refused | None:
    """Return that a certificate has expired or is not valid yet, None if valid.

    A handshake in memory finds out, by a client that trusts this certificate itself.
    """
    trusting = ssl.SSLContext(ssl.PROTOCOL_TLS_CLIENT)
    trusting.check_hostname = False  # its name is the browser's business
    trusting.verify_flags |= ssl.VerifyFlags.VERIFY_X509_PARTIAL_CHAIN
    trusting.load_verify_locations(cert)
    to_server, back = ssl.MemoryBIO(), ssl.MemoryBIO()
    client = trusting.wrap_bio(back, to_server)
    host = server.wrap_bio(to_server, back, server_side=True)
    for _ in range(HANDSHAKE_ROUNDS):
        for end in (client, host):
            try:
                end.do_handshake()
            except ssl.SSLWantReadError:
                continue
            except ssl.SSLCertVerificationError as error:
                dated = error.verify_code in CERTIFICATE_DATE_ERRORS
                return Refused(error.verify_message) if dated else None
            except ssl.SSLError:  # a browser will tell all other faults
                return None
    return None


def asks_token(url: str) -> bool:
    """Return whether a session asks for a token; LinkError if none answers."""
    arrived = threading.Event()
    line = client.dial(url, arrived)
    try:
        # A session with a token refuses even this harmless question of a stranger.
        line.send(sentences.order_sentence("who", "1"))
        return client.answer_of(line, arrived, "1")[0] == "no"
    finally:
        line.close(client.ANSWER_TIMEOUT_S)
