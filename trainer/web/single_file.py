"""A page as one file: scripts, styles and data inside, nothing from outside."""

import base64
import hashlib
import json
import re
import zlib
from collections.abc import Mapping
from functools import partial
from html import escape
from pathlib import PurePosixPath
from typing import Any, Final

from trainer.web.pages import ASSETS_FOLDER, PAGES, order_words, render

STYLESHEET_TAG: Final = re.compile(r'<link rel="stylesheet" href="/assets/(\S+)">\n?')
SCRIPT_TAG: Final = re.compile(r'<script type="module" src="/assets/(\S+)"></script>\n?')
IMPORT_STATEMENT: Final = re.compile(
    r'^import (?:(\{[^}]*\}) from )?"(\.[^"]+)";$', re.MULTILINE | re.DOTALL
)
EXPORT_KEYWORD: Final = re.compile(
    r"^export (?=(?:async )?(?:const|let|class|function) )", re.MULTILINE
)
EXPORTED_NAME: Final = re.compile(
    r"^export (?:async )?(?:const|let|class|function) (\w+)", re.MULTILINE
)
# A page in a file has no server to link to. So its link is to the boat in its own worker.
REPLACED_SCRIPTS: Final = {"js/protocol/link.js": "js/tab/link.js"}
WORKER_SCRIPT: Final = "js/tab/worker.js"
# Orders that such a page takes, beside the boat's own rows, which only write numbers.
# fmt: off
TAB_ORDERS: Final = frozenset(
    (
        "sea", "casualty", "clear", "casualties", "freeze", "run", "step", "time", "snapshot",
        "snapshots", "restore", "reset", "backtrack", "replay", "take", "branches", "branch",
        "mark", "log", "status", "history",
    )
)
# fmt: on
TAB_NOTE: Final = (
    "A boat in a file: it is flown by this page alone. "
    "Marks are not judged here; nothing is sent or kept."
)


class UnknownPageError(Exception):
    """A page that cannot be one file."""


def collect_modules(entry: str, seen: dict[str, str] | None = None) -> dict[str, str]:
    """Return the sources of a module and its imports, which stand first."""
    sources = {} if seen is None else seen
    source = (ASSETS_FOLDER / REPLACED_SCRIPTS.get(entry, entry)).read_text(encoding="utf-8")
    for _, path in IMPORT_STATEMENT.findall(source):
        wanted = resolve_module(entry, path)
        if wanted not in sources:
            collect_modules(wanted, sources)
    sources[entry] = source
    return sources


def resolve_module(module: str, path: str) -> str:
    """Return the module that another names by a relative path."""
    parts: list[str] = []
    for part in (PurePosixPath(module).parent / path).parts:
        if part == "..":
            parts.pop()
        elif part != ".":
            parts.append(part)
    return "/".join(parts)


def bundle(entry: str) -> str:
    """Return one script of a module and all that it imports.

    Each module is a function of its own, whose exports are in a table by its path.
    """
    parts = ['"use strict";\n(() => {\nconst M = {};\n']
    for path, source in collect_modules(entry).items():
        names = EXPORTED_NAME.findall(source)
        text = EXPORT_KEYWORD.sub("", IMPORT_STATEMENT.sub(partial(replace_import, path), source))
        if re.search(r"^(?:import|export)\b", text, re.MULTILINE):
            raise UnknownPageError(f"{path}: an import or export of a kind that is not known")
        parts.append(
            f"M[{json.dumps(path)}] = (() => {{\n{text}\nreturn {{ {', '.join(names)} }};\n}})();\n"
        )
    parts.append("})();\n")
    return "".join(parts)


def replace_import(module: str, found: re.Match[str]) -> str:
    """Return the statement that replaces an import: the same names from the table."""
    if not found[1]:
        return ""
    names = re.sub(r"(\w+) as (\w+)", r"\1: \2", found[1])
    return f"const {names} = M[{json.dumps(resolve_module(module, found[2]))}];"


def close_text(text: str) -> str:
    """Return a script's text in which no character ends the element around it."""
    return re.sub(r"<(?=/script|!--|script)", r"\\x3c", text, flags=re.IGNORECASE)


def pack_data(data: bytes) -> str:
    """Return bytes deflated and in base64; the same bytes give the same text."""
    return base64.b64encode(zlib.compress(data, 9)).decode("ascii")


def digest(text: str) -> str:
    """Return the source expression of an inline script or style."""
    hash_bytes = hashlib.sha256(text.encode()).digest()
    return f"'sha256-{base64.b64encode(hash_bytes).decode('ascii')}'"


def policy(scripts: list[str], sheet: str) -> str:
    """Return what the page may do: its own scripts, style, core and worker."""
    hashes = " ".join(map(digest, scripts))
    return (
        f"default-src 'none'; script-src {hashes} 'wasm-unsafe-eval'; style-src {digest(sheet)}; "
        "worker-src blob:; img-src data:; base-uri 'none'; form-action 'none'"
    )


def single_file(name: str, boat: Mapping[str, Any], core: bytes, title: str) -> str:
    """Return the station's page with a boat inside."""
    page = next(each for each in PAGES if each.name == name)
    taken = {row.split(";")[0].split()[0] for row in boat["orders"]} | TAB_ORDERS
    html = render(page, order_words=partial(order_words, taken), lessons=list)
    sheet = "\n".join(
        (ASSETS_FOLDER / path).read_text(encoding="utf-8") for path in STYLESHEET_TAG.findall(html)
    )
    entry = SCRIPT_TAG.findall(html)[0]
    script = close_text(bundle(entry))
    policed = policy([script], sheet)
    head = (
        f'<meta http-equiv="Content-Security-Policy" content="{escape(policed)}">\n'
        f"<style>{sheet}</style>\n"
    )
    html = SCRIPT_TAG.sub("", STYLESHEET_TAG.sub("", html))
    html = re.sub(r"<title>.*?</title>", lambda _: f"<title>{escape(title)}</title>", html)
    html = html.replace('<meta charset="utf-8">\n', f'<meta charset="utf-8">\n{head}', 1)
    note = f'<aside id="tab-note" class="quiet" aria-label="This page">{escape(TAB_NOTE)}</aside>'
    text = json.dumps(boat, separators=(",", ":"), sort_keys=True)
    blocks = {
        "worker": close_text(bundle(WORKER_SCRIPT)),
        "core": pack_data(core),
        "boat": pack_data(text.encode()),
    }
    data = "".join(
        f'<script type="text/plain" id="tab-{block}">{content}</script>\n'
        for block, content in blocks.items()
    )
    foot = f"{note}\n{data}<script>{script}</script>\n</body>"
    return html.replace("</body>", foot, 1)
