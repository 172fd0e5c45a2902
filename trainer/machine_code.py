"""Where the core's machine code is kept, and what it is the code of.

Numba stamps a cached kernel with the source of its own file only, so that a changed callee in
another file would otherwise go on serving the old physics: the cache therefore lies in a folder
named by a hash of the core's sources. Importing this module points numba there; the core does so
before its first kernel.
"""

import hashlib
import os
import sys
from functools import cache
from pathlib import Path

_PREFIX = "submarine-trainer-"
_PRIVATE = "trainer-private-"


@cache
def core_digest() -> str:
    """Return a short hash of the core's sources: what the boat is computed by."""
    return _digest("core")


def _digest(*folders: str) -> str:
    """Return a short hash of the sources in folders of the package."""
    digest = hashlib.sha256()
    for folder in folders:
        for path in sorted((Path(__file__).parent / folder).glob("*.py")):
            digest.update(path.name.encode() + b"\0" + path.read_bytes())
    return digest.hexdigest()[:16]


def _cache_root() -> Path:
    """Return the folder that machine code of any version goes into."""
    chosen = os.environ.get("NUMBA_CACHE_DIR")
    if chosen:
        path = Path(chosen)
        return path.parent if path.name.startswith(_PREFIX) else path
    if os.name == "nt" and "LOCALAPPDATA" in os.environ:
        return Path(os.environ["LOCALAPPDATA"])
    return Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache")


def _claim_cache() -> Path:
    """Return this version's cache folder; where home is read-only one that lasts for this run."""
    checked = os.environ.get("NUMBA_BOUNDSCHECK", "0") not in ("", "0")  # other machine code
    name = _PREFIX + _digest("core", "identify/kernels", "sweep/kernels") + "-checked" * checked
    path = _cache_root() / name
    try:
        path.mkdir(parents=True, exist_ok=True)
        writable = os.access(path, os.W_OK)
    except OSError:
        writable = False
    if writable:
        return path
    path = _claim_private() / name
    path.mkdir()
    return path


def _claim_private() -> Path:
    """Return a new folder that goes when this process ends.

    It is not the shared temporary folder itself: numba runs what it finds in its cache.
    """
    import atexit  # noqa: PLC0415  rarely needed
    import shutil  # noqa: PLC0415
    import tempfile  # noqa: PLC0415

    private = Path(tempfile.mkdtemp(prefix=_PRIVATE))
    atexit.register(shutil.rmtree, private, ignore_errors=True)
    return private


os.environ["NUMBA_CACHE_DIR"] = str(_claim_cache())
if "numba" in sys.modules:  # it has read the environment already
    sys.modules["numba"].config.CACHE_DIR = os.environ["NUMBA_CACHE_DIR"]


def cache_folder() -> Path:
    """Return the folder of this version's machine code."""
    return Path(os.environ["NUMBA_CACHE_DIR"])


def cache_lasts() -> bool:
    """Return whether what is put into the cache is there at the next start."""
    return not cache_folder().parent.name.startswith(_PRIVATE)
