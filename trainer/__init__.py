"""An open, real-time submarine ship-control trainer.

Importing the package points numba's machine-code cache at a folder named by a hash of the core's
sources: numba stamps a cached kernel with the source of its own file only, so that a changed
callee in another file would otherwise go on serving the old physics.
"""

import hashlib
import os
import tempfile
from pathlib import Path

__version__ = "0.1.0"

_PREFIX = "submarine-trainer-"


def _core_digest() -> str:
    """Return a short hash of the core's sources and of what else changes its machine code."""
    digest = hashlib.sha256(os.environ.get("NUMBA_BOUNDSCHECK", "").encode())
    for path in sorted((Path(__file__).parent / "core").glob("*.py")):
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
    """Return this version's cache folder, a private temporary one where home is read-only."""
    path = _cache_root() / (_PREFIX + _core_digest())
    try:
        path.mkdir(parents=True, exist_ok=True)
    except OSError:
        return Path(tempfile.mkdtemp(prefix=_PREFIX))
    return path if os.access(path, os.W_OK) else Path(tempfile.mkdtemp(prefix=_PREFIX))


os.environ["NUMBA_CACHE_DIR"] = str(_claim_cache())


def machine_code_is_compiled() -> bool:
    """Return whether this version's kernels have been compiled on this machine before."""
    return any(Path(os.environ["NUMBA_CACHE_DIR"]).rglob("update.update-*.nbi"))
