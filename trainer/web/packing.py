"""The pages' scripts and styles as they are served: few files, named by hash.

A file whose name has its hash never changes. So a browser keeps it, and a second visit asks for
nothing but the page. Modules import each other by their plain names, and an import map in each
page, made here at the start, leads every name to the file that has it now. On a slow line each file
costs a round trip. So what all stations share is one file, and the rest of a page another.
"""

import gzip
import hashlib
import json
from dataclasses import dataclass
from pathlib import PurePosixPath
from typing import Final

from trainer.web.modules import (
    EXPORTED_NAME,
    FONT_URL,
    SCRIPT_TAG,
    STYLESHEET_TAG,
    Sources,
    collect_modules,
    read_font,
    wrap_modules,
)
from trainer.web.styles import join_styles

ASSETS_ROOT: Final = "./assets/"  # of the plain names too, which no request asks for
MEDIA_TYPES: Final = {
    ".js": "text/javascript; charset=utf-8",
    ".css": "text/css; charset=utf-8",
    ".woff2": "font/woff2",
}
HASH_DIGITS: Final = 16
# What each station has of these, all have: state, alerts, briefing, orders, the line, words.
SHARED_ENTRIES: Final = ("js/frame.js", "js/model/session.js", "js/protocol/link.js", "js/words.js")


@dataclass(frozen=True)
class Asset:
    """One file that is served."""

    body: bytes
    packed: bytes  # by gzip
    media_type: str


class Assets:
    """All files that the pages ask for, by their names."""

    def __init__(self) -> None:
        self.files: dict[str, Asset] = {}
        self._shared: Sources = {}
        for entry in SHARED_ENTRIES:
            collect_modules(entry, {}, self._shared)
        self._shared_address = self._keep("shared.js", join_shared(self._shared).encode())

    def link(self, html: str) -> tuple[str, str]:
        """Return a page that asks for hashed files, and its import map."""
        (entry,) = SCRIPT_TAG.findall(html)
        name = PurePosixPath(entry).stem
        sheet = join_styles(STYLESHEET_TAG.findall(html))
        fonts = {each: self._keep(each, read_font(each)) for each in FONT_URL.findall(sheet)}
        sheet = FONT_URL.sub(lambda url: f'url("{PurePosixPath(fonts[url[1]]).name}")', sheet)
        tags, script_map = self._script(name, entry)
        address = self._keep(f"{name}.css", sheet.encode())
        head = f'<link rel="stylesheet" href="{address}">\n{tags}'
        html = SCRIPT_TAG.sub("", STYLESHEET_TAG.sub("", html))
        return html.replace("</title>\n", f"</title>\n{head}", 1), script_map

    def _script(self, name: str, entry: str) -> tuple[str, str]:
        """Return the tags of a page's script, and the import map among them."""
        sources = collect_modules(entry, {})
        own = {path: source for path, source in sources.items() if path not in self._shared}
        shared = self._shared_address
        address = self._keep(f"{name}.js", join_own(own, self._shared).encode()) if own else shared
        modules = dict.fromkeys((ASSETS_ROOT + path for path in self._shared), shared)
        script_map = json.dumps({"imports": modules}, separators=(",", ":"))
        return (
            f'<script type="importmap">{script_map}</script>\n'
            f'<link rel="modulepreload" href="{shared}">\n'
            f'<script type="module" src="{address}"></script>\n'
        ), script_map

    def _keep(self, name: str, body: bytes) -> str:
        """Keep a file under its hashed name; return its address."""
        path = PurePosixPath(name)
        digits = hashlib.sha256(body).hexdigest()[:HASH_DIGITS]
        hashed = f"{path.stem}.{digits}{path.suffix}"
        packed = gzip.compress(body, 9, mtime=0)
        self.files[hashed] = Asset(body, packed, MEDIA_TYPES[path.suffix])
        return ASSETS_ROOT + hashed


def join_shared(sources: Sources) -> str:
    """Return one module that exports what all these modules do, whose names differ."""
    exports = [
        f"export const {{ {', '.join(names)} }} = M[{json.dumps(path)}];\n"
        for path, source in sources.items()
        if (names := EXPORTED_NAME.findall(source))
    ]
    return "".join(["const M = {};\n", wrap_modules(sources), *exports])


def join_own(sources: Sources, shared: Sources) -> str:
    """Return one module of a page's own modules, which imports what is shared."""
    imports = [
        f"import * as m{number} from {json.dumps('./' + path)};\n"
        for number, path in enumerate(shared)
    ]
    table = ", ".join(f"{json.dumps(path)}: m{number}" for number, path in enumerate(shared))
    return "".join([*imports, f"const M = {{ {table} }};\n", wrap_modules(sources)])
