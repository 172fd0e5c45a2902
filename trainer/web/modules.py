"""The modules of the pages' scripts, joined: each becomes a function that returns its exports.

It knows only the forms of ``import`` and ``export`` that the pages use. ``single_file`` joins all
of a page into one script; ``packing`` joins what all stations share, and the rest of each page.
"""

import json
import re
from collections.abc import Mapping
from functools import cache, partial
from pathlib import Path, PurePosixPath
from typing import Final

ASSETS_FOLDER: Final = Path(__file__).parent / "assets"
IMPORT_STATEMENT: Final = re.compile(
    r'^import (?:(\{[^}]*\}) from )?"(\.[^"]+)";$', re.MULTILINE | re.DOTALL
)
EXPORT_KEYWORD: Final = re.compile(
    r"^export (?=(?:async )?(?:const|let|class|function) )", re.MULTILINE
)
EXPORTED_NAME: Final = re.compile(
    r"^export (?:async )?(?:const|let|class|function) (\w+)", re.MULTILINE
)
# lines that are nothing but a comment, and comments that are whole lines: no browser needs them
COMMENT_LINES: Final = re.compile(
    r"^[ \t]*(?://[^\n]*|/\*\*(?:(?!\*/).)*\*/[ \t]*)\n", re.MULTILINE | re.DOTALL
)

FONT_URL: Final = re.compile(r'url\("\./fonts/(\S+?)"\)')  # in a style
STYLESHEET_TAG: Final = re.compile(r'<link rel="stylesheet" href="\./assets/(\S+)">\n?')
SCRIPT_TAG: Final = re.compile(r'<script type="module" src="\./assets/(\S+)"></script>\n?')

Sources = dict[str, str]  # of modules, by their paths; what a module imports stands before it


class UnknownFormError(Exception):
    """A module with an import or export of a kind that is not known."""


def read_font(name: str) -> bytes:
    """Return a font of the pages."""
    return (ASSETS_FOLDER / "fonts" / name).read_bytes()


def collect_modules(
    entry: str, replaced: Mapping[str, str], found: Sources | None = None
) -> Sources:
    """Return the sources of a module and its imports; ``replaced`` has other files for some."""
    sources = {} if found is None else found
    source, imported = read_module(entry, ASSETS_FOLDER / replaced.get(entry, entry))
    for wanted in imported:
        if wanted not in sources:
            collect_modules(wanted, replaced, sources)
    sources[entry] = source
    return sources


@cache  # the pages share most of their modules
def read_module(module: str, path: Path) -> tuple[str, tuple[str, ...]]:
    """Return the source of a module in a file, and the modules that it imports."""
    source = path.read_text(encoding="utf-8")
    found = IMPORT_STATEMENT.findall(source)
    return source, tuple(resolve_module(module, wanted) for _, wanted in found)


def resolve_module(module: str, path: str) -> str:
    """Return the module that another names by a relative path."""
    parts: list[str] = []
    for part in (PurePosixPath(module).parent / path).parts:
        if part == "..":
            parts.pop()
        elif part != ".":
            parts.append(part)
    return "/".join(parts)


def wrap_modules(sources: Sources) -> str:
    """Return modules as functions, whose exports are in a table ``M`` by their paths."""
    return "".join(wrap_module(path, source) for path, source in sources.items())


@cache
def wrap_module(path: str, source: str) -> str:
    """Return one module as a function; UnknownFormError."""
    text = EXPORT_KEYWORD.sub("", IMPORT_STATEMENT.sub(partial(replace_import, path), source))
    if re.search(r"^(?:import|export)\b", text, re.MULTILINE):
        raise UnknownFormError(f"{path}: an import or export of a kind that is not known")
    text = COMMENT_LINES.sub("", text)
    names = ", ".join(EXPORTED_NAME.findall(source))
    return f"M[{json.dumps(path)}] = (() => {{\n{text}\nreturn {{ {names} }};\n}})();\n"


def replace_import(module: str, found: re.Match[str]) -> str:
    """Return the statement that replaces an import: the same names from the table."""
    if not found[1]:
        return ""
    names = re.sub(r"(\w+) as (\w+)", r"\1: \2", found[1])
    return f"const {names} = M[{json.dumps(resolve_module(module, found[2]))}];"
