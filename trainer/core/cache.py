"""The folders of the kernels' machine code, and the digests of that code.

Numba stamps a cached kernel with the source of its own file only, so that a changed callee or
constant of another file would otherwise go on serving the old physics: a kernel's code therefore
lies in a folder named by a hash of its file and of all that is imported there. Importing this
module claims the folder of these folders.

A file of machine code has its digests beside it. One that does not fit, or has none, is set aside
before numba reads it: numba then finds nothing, and compiles. This is against damage. Against other
users the folder is this user's alone, and is not used where another could put code there. Python
tells of every file that is opened and renamed (its audit events), so that nothing of numba's own is
touched.
"""

import contextlib
import hashlib
import os
import stat
import sys
import threading
from collections.abc import Callable, Iterator
from functools import cache
from pathlib import Path
from typing import Any

from trainer.core.digest import digest_sources, imported_sources

_FOLDER_PREFIX = "submarine-trainer-"
_FOLDER_NAME = _FOLDER_PREFIX + "kernels"
_PRIVATE_PREFIX = "trainer-private-"


def _cache_root() -> Path:
    """Return the folder that machine code of any version goes into."""
    chosen = os.environ.get("NUMBA_CACHE_DIR")
    if chosen:
        path = Path(chosen)
        return path.parent if path.name.startswith(_FOLDER_PREFIX) else path
    if os.name == "nt" and "LOCALAPPDATA" in os.environ:
        return Path(os.environ["LOCALAPPDATA"])
    return Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache")


def _claim_cache() -> Path:
    """Return the cache folder; where home is read-only one that lasts for this run."""
    checked = os.environ.get("NUMBA_BOUNDSCHECK", "0") not in ("", "0")  # other machine code
    name = _FOLDER_NAME + "-checked" * checked
    try:
        path = _cache_root() / name
        path.mkdir(0o700, parents=True, exist_ok=True)
        if foreign := _foreign_place(path):
            print(
                f"trainer: {path}: another user could put code there, {foreign}; it is not used: "
                "NUMBA_CACHE_DIR names a folder of yours",
                file=sys.stderr,
            )
        elif os.access(path, os.W_OK):
            path.chmod(0o700)  # one that an earlier version made
            return path
    except (OSError, RuntimeError):  # RuntimeError: this user has no home
        pass
    path = _claim_private() / name
    path.mkdir()
    return path


def _foreign_place(path: Path) -> str:
    """Return where another user could put code into a folder, and how, "" for nowhere."""
    if not hasattr(os, "geteuid"):
        return ""
    own, status = os.geteuid(), path.lstat()
    if not stat.S_ISDIR(status.st_mode) or status.st_uid != own:
        return "who owns it"
    if _is_open(status):  # until now: the code in it is ours if all of its files are
        for each in path.rglob("*"):
            if each.lstat().st_uid != own:
                return f"who has left {each.name}"
    for above in path.resolve().parents:
        status = above.stat()
        sticky = status.st_mode & stat.S_ISVTX  # only its owner may rename what is in it
        if status.st_uid not in (0, own) or (_is_open(status) and not sticky):
            return f"who may write in {above}"
    return ""


def _is_open(status: os.stat_result) -> bool:
    """Return whether others may write in a folder. Where umask is 002, this user's group may."""
    others_group = status.st_mode & stat.S_IWGRP and status.st_gid != os.getegid()
    return bool(status.st_mode & stat.S_IWOTH or others_group)


def _claim_private() -> Path:
    """Return a new folder that goes when this process ends.

    It is not the shared temporary folder itself: numba runs what it finds in its cache.
    """
    import atexit  # noqa: PLC0415  rarely needed
    import shutil  # noqa: PLC0415
    import tempfile  # noqa: PLC0415

    private = Path(tempfile.mkdtemp(prefix=_PRIVATE_PREFIX))
    atexit.register(shutil.rmtree, private, ignore_errors=True)
    return private


os.environ["NUMBA_CACHE_DIR"] = str(_claim_cache())
if "numba" in sys.modules:  # it has read the environment already
    sys.modules["numba"].config.CACHE_DIR = os.environ["NUMBA_CACHE_DIR"]
_DECLARING = threading.Lock()  # numba has one folder at a time


CODE_SUFFIXES = (".nbi", ".nbc")  # numba's index of a kernel, and the code itself
DIGEST_SUFFIX = ".digest"
MOST_DIGESTS = 2**20  # [bytes] in hexadecimal, a line each
DAMAGED_SUFFIX = ".damaged"


def _digest_of(path: str) -> bytes:
    """Return the digest of a file; OSError if it cannot be read."""
    descriptor = os.open(path, os.O_RDONLY)
    with contextlib.closing(os.fdopen(descriptor, "rb")) as file:
        return hashlib.blake2b(file.read(), digest_size=16).hexdigest().encode()


def keep_digest(made: str, path: str) -> None:
    """Add the digest of a new file to those beside ``path``.

    It is called before the new file is renamed. The others stay: another process may still read
    the file that is there now, or may be about to rename one of its own.
    """
    with contextlib.suppress(OSError):
        descriptor = os.open(path + DIGEST_SUFFIX, os.O_WRONLY | os.O_CREAT | os.O_APPEND, 0o666)
        try:
            os.write(descriptor, b"\n" + _digest_of(made))
        finally:
            os.close(descriptor)


def check_digest(path: str) -> None:
    """Set a file aside that differs from what was written, and say so."""
    try:
        found = _digest_of(path)
    except FileNotFoundError:
        return
    except OSError:
        found = b""
    with contextlib.suppress(OSError):
        descriptor = os.open(path + DIGEST_SUFFIX, os.O_RDONLY)
        try:
            if found in os.read(descriptor, MOST_DIGESTS).split():
                return
        finally:
            os.close(descriptor)
    with contextlib.suppress(OSError):
        os.rename(path, path + DAMAGED_SUFFIX)  # noqa: PTH104  it is done for every file that is opened
    _tell_damage()


@cache
def _tell_damage() -> None:
    """Say once that code is damaged; the files set aside have a name that says so."""
    print("trainer: compiled code was damaged, and is compiled again", file=sys.stderr)


def _attend(event: str, told: tuple[Any, ...]) -> None:
    """Check what numba is about to read, and keep a digest of what it is about to write."""
    if event == "open":
        path, mode, _ = told
        if mode == "r" and isinstance(path, str) and path.endswith(CODE_SUFFIXES):
            check_digest(path)
    elif event == "os.rename":
        made, path = str(told[0]), str(told[1])
        if path.endswith(CODE_SUFFIXES):
            keep_digest(made, path)


sys.addaudithook(_attend)


def cache_folder() -> Path:
    """Return the folder of all machine code."""
    return Path(os.environ["NUMBA_CACHE_DIR"])


@contextlib.contextmanager
def keep_by_sources(kernel: Callable[..., Any]) -> Iterator[None]:
    """Have numba keep what the block declares in the folder of the sources of ``kernel``."""
    import numba  # noqa: PLC0415  what does not compile does without

    own = cache_folder() / digest_sources(imported_sources(Path(kernel.__code__.co_filename)))
    with _DECLARING:
        numba.config.CACHE_DIR = str(own)  # type: ignore[attr-defined]
        try:
            yield
        finally:
            numba.config.CACHE_DIR = str(cache_folder())  # type: ignore[attr-defined]
