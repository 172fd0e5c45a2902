"""The default places of a session's socket, its address, and its recordings.

Programs find a session of the same user by them without an option. Each operating system has its
own customs for such places, which ``platformdirs`` knows.
"""

import errno
import os
import re
import tempfile
from collections.abc import Iterator
from datetime import UTC, datetime
from itertools import count
from pathlib import Path
from typing import Final

DEFAULT_HOST: Final = "127.0.0.1"
DEFAULT_PORT: Final = 17800  # of a session, by TCP
PAGES_PORT: Final = 17880  # the port of stations in a browser
RECORDING_SUFFIX: Final = ".trainer"

# What a session says of itself as it starts, for its user and for the program that started it
MAKING_READY: Final = "making ready:"  # its options are right, and it compiles or waits
LISTENING_TEXT: Final = "listening at"

_FOLDER_NAME: Final = "submarine-trainer"
_OTHER_FOLDERS: Final = (
    "recordings and trainees' progress go there; XDG_STATE_HOME=FOLDER names another place, "
    "--record FILE one for this run, and --no-record keeps none"
)


def socket_path() -> Path:
    """Return the local socket of this user's session."""
    runtime = os.environ.get("XDG_RUNTIME_DIR")
    if runtime:
        return Path(runtime) / _FOLDER_NAME / "session.sock"
    user = os.getuid() if hasattr(os, "getuid") else os.environ.get("USERNAME", "user")
    return Path(tempfile.gettempdir()) / f"{_FOLDER_NAME}-{user}" / "session.sock"


def nearest_session() -> str:
    """Return where this machine's session listens, by its local socket if there is one."""
    path = socket_path()
    return (
        str(path) if path.exists() else left_address()[0] or f"tcp://{DEFAULT_HOST}:{DEFAULT_PORT}"
    )


def address_path() -> Path:
    """Return the file with a session's address, for systems without local sockets."""
    return socket_path().with_suffix(".address")


def left_token(url: str | None) -> str | None:
    """Return the token that a session has left, where `url` is its address or None."""
    address, token = left_address()
    return token or None if url in (None, address) else None


def leave_address(url: str, token: str) -> None:
    """Leave the session's address and its token for this user's stations."""
    path = address_path()
    path.parent.mkdir(mode=0o700, parents=True, exist_ok=True)
    path.unlink(missing_ok=True)
    path.touch(mode=0o600)
    path.write_text(f"{url} {token}\n", encoding="ascii")


def left_address() -> tuple[str, str]:
    """Return the address and the token that a session has left, "" and "" without."""
    try:
        url, token = address_path().read_text(encoding="ascii").split()
    except (OSError, ValueError):
        return "", ""
    return url, token


def recordings_folder() -> Path:
    """Return the default folder of recordings, by the system's custom.

    A folder that ``XDG_STATE_HOME`` names comes first, then one that an earlier version made.
    OSError, with the next step, for a user without a home.
    """
    named = os.environ.get("XDG_STATE_HOME")
    try:
        state = Path(named or Path.home() / ".local" / "state")
    except RuntimeError:
        raise FileNotFoundError(
            errno.ENOENT, f"this user has no home folder: {_OTHER_FOLDERS}"
        ) from None
    import platformdirs  # noqa: PLC0415  few ask where recordings go

    earlier = state / _FOLDER_NAME  # of all systems, once
    here = named or earlier.is_dir()
    folder = earlier if here else platformdirs.user_state_path(_FOLDER_NAME, appauthor=False)
    return folder / "recordings"


def made_folder(folder: Path) -> Path:
    """Make a folder and return it. OSError says what was to go there, and the next step."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
        if not os.access(folder, os.W_OK):
            raise PermissionError(errno.EACCES, os.strerror(errno.EACCES), str(folder))
    except OSError as error:
        why = f"{error.strerror}: {_OTHER_FOLDERS}"
        raise OSError(error.errno, why, error.filename) from None
    return folder


def recording_paths(name: str, folder: Path | None = None) -> Iterator[Path]:
    """Yield files for a new recording of ``name`` in a folder, None: the usual one.

    The folder is made if it is not there.
    Each is for use when the earlier ones are taken. OSError, with the next step, without a folder.
    """
    folder = made_folder(folder or recordings_folder())
    name = dated_name(name)
    path = folder / f"{name}{RECORDING_SUFFIX}"
    yield path
    yield from further_paths(path)


def further_paths(path: Path) -> Iterator[Path]:
    """Yield the same name with -2, -3 and so on.

    Each is for use when the earlier ones are taken.
    """
    for again in count(2):
        yield path.with_name(f"{path.stem}-{again}{path.suffix}")


def dated_name(name: str) -> str:
    """Return the name of what an exercise leaves, with day and time."""
    plain = re.sub(r"[^a-z0-9-]+", "-", Path(name).stem.casefold()).strip("-") or "run"
    return f"{plain}-{datetime.now(UTC).strftime('%Y%m%d-%H%M%S')}"
