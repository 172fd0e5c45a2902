"""The digest of the core's sources, by which the boat is computed.

A recording names that of the core that made it, so that a replay by another core is told; so do
the shipped machine code and what is exported. ``cache`` names the folder of a kernel by the digest
of the module that has it and of all that is imported there, because constants are compiled in.

Comments, docstrings and blank lines do not count: words compute nothing. They and imports are found
by their form, which the formatter keeps, because to parse the core would take a tenth of a start.
"""

import hashlib
import re
from collections.abc import Iterable
from functools import cache
from pathlib import Path

PACKAGE_FOLDER = Path(__file__).parents[1]
# Digests of earlier cores, whose standard hour ended in the bits of this one's.
SAME_BITS: frozenset[str] = frozenset({"0896c78e0d8ddf4a", "43ed887495848b23"})
DIGEST_SOURCE = Path(__file__)  # which says what counts, and computes nothing
DOCSTRING_PATTERN = re.compile(
    r'(\A|:(?:  #[^\n]*)?\n)\s*r?"""(?:[^"\\]|\\.|"(?!""))*"""', re.DOTALL
)
COMMENT_PATTERN = re.compile(r"""^((?:"(?:[^"\\]|\\.)*"|'(?:[^'\\]|\\.)*'|[^#"'])*)#.*""")
# a module's imports at its left margin: others are made when a function is called
IMPORT_PATTERN = re.compile(r"^from (trainer[\w.]*) import (\([^)]*\)|.*)", re.MULTILINE)
RENAMED_PATTERN = re.compile(r"#.*| as \w+")


@cache
def core_digest() -> str:
    """Return a short hash of the core's sources, by which the boat is computed."""
    return digest_sources(
        [PACKAGE_FOLDER / "units.py", *sorted((PACKAGE_FOLDER / "core").rglob("*.py"))]
    )


def imported_sources(*paths: Path) -> list[Path]:
    """Return sources and all of the package's that they import, and those import, in order.

    Of a folder it is all sources in it.
    """
    found = set[Path]()
    to_read = [each for path in paths for each in (path.rglob("*.py") if path.is_dir() else [path])]
    while to_read:
        path = to_read.pop()
        if path not in found and path.is_file():  # none of what was typed at a prompt
            found.add(path)
            to_read += _imports(path)
    return sorted(found)


@cache
def _imports(path: Path) -> list[Path]:
    """Return the sources of the package that a source imports at its head."""
    return [
        source
        for package, names in IMPORT_PATTERN.findall(read_source(path))
        for name in re.findall(r"\w+", RENAMED_PATTERN.sub("", names))
        if (source := _source_of(f"{package}.{name}") or _source_of(package))
    ]


@cache
def _source_of(module: str) -> Path | None:
    """Return the source of a module by its name, None if it is no module of the package."""
    place = PACKAGE_FOLDER.joinpath(*module.split(".")[1:])
    files = (place.with_suffix(".py"), place / "__init__.py")
    return next((path for path in files if path.is_file()), None)


def digest_sources(paths: Iterable[Path]) -> str:
    """Return a short hash of what computes in sources."""
    digest = hashlib.sha256()
    for path in paths:
        if path != DIGEST_SOURCE:
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
