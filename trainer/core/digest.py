"""The digest of the core's sources, by which the boat is computed.

A recording names that of the core that made it, so that a replay by another core is told; so do
the shipped machine code and what is exported. ``cache`` names its folder by that of all kernels.

Comments, docstrings and blank lines do not count: words compute nothing. They are found by their
form, which the formatter keeps, because to parse the core would take a tenth of a start.
"""

import hashlib
import re
from functools import cache
from pathlib import Path

KERNEL_FOLDERS = (  # folders that have any
    "core",
    "boat/ship",
    "identify/kernels",
    "analysis/sweep",
)
# Digests of earlier cores, whose standard hour ended in the bits of this one's.
SAME_BITS: frozenset[str] = frozenset({"0896c78e0d8ddf4a"})
DIGEST_SOURCE = Path(__file__)  # which says what counts, and computes nothing
DOCSTRING_PATTERN = re.compile(r'(\A|:(?:  #[^\n]*)?\n)\s*"""(?:[^"\\]|\\.|"(?!""))*"""', re.DOTALL)
COMMENT_PATTERN = re.compile(r"""((?:"(?:[^"\\]|\\.)*"|'(?:[^'\\]|\\.)*'|[^#"'])*)#.*""")


@cache
def core_digest() -> str:
    """Return a short hash of the core's sources, by which the boat is computed."""
    return digest_sources("core")


def sources(*folders: str) -> list[Path]:
    """Return the sources in folders of the package, whole, but for this one."""
    here = Path(__file__).parents[1]
    return [
        here / "units.py",
        *(
            path
            for each in folders
            for path in sorted((here / each).rglob("*.py"))
            if path != DIGEST_SOURCE
        ),
    ]


def digest_sources(*folders: str) -> str:
    """Return a short hash of the sources in folders of the package."""
    digest = hashlib.sha256()
    for path in sources(*folders):
        digest.update(f"{path.name}\0{without_words(read_source(path))}".encode())
    return digest.hexdigest()[:16]


def same_core(digest: object) -> bool:
    """Return whether a core of that digest computes the bits of this one."""
    return digest == core_digest() or digest in SAME_BITS


def read_source(path: Path) -> str:
    """Return a source with its line ends as the repository has them."""
    return path.read_bytes().replace(b"\r\n", b"\n").decode()


def without_words(source: str) -> str:
    """Return the lines of a source that compute: without comments, docstrings and blank lines."""
    lines = DOCSTRING_PATTERN.sub(r"\1", source).splitlines()
    return "\n".join(
        line
        for each in lines
        if (line := COMMENT_PATTERN.sub(r"\1", each).rstrip() if "#" in each else each)
    )
