"""A page as one HTML file that needs no server, for ``trainer boat export-page``.

The file holds the page's scripts and styles, the boat's numbers, and the core as WebAssembly, which
its script runs in a worker. Scripts of the pages are ES modules, which a browser does not load from
a file. So ``bundle`` joins the modules into one script.
"""

import base64
import hashlib
import json
import re
import zlib
from collections.abc import Iterable, Mapping
from functools import partial
from html import escape
from typing import Any, Final

from trainer.io.orders.words import ORDER_WORDS
from trainer.web.modules import (
    ASSETS_FOLDER,
    FONT_URL,
    SCRIPT_TAG,
    STYLESHEET_TAG,
    collect_modules,
    read_font,
    wrap_modules,
)
from trainer.web.pages import PAGES, order_words, render
from trainer.web.styles import join_styles
from trainer.web.words import said_in_script

# A page in a file has no server to link to. So its link is to the boat in its own worker.
REPLACED_SCRIPTS: Final = {"js/protocol/link.js": "js/tab/link.js"}
WORKER_SCRIPT: Final = "js/tab/worker.js"
SPEAKING_SCRIPTS: Final = ("js/tab/card.js", "js/tab/first-lever.js")
TAB_STYLE: Final = "css/tab.css"
# Orders that such a page takes, beside the boat's own rows, which only write numbers.
TAB_ORDERS: Final = {word.name for word in ORDER_WORDS.values() if word.in_page}
TAB_NOTE: Final = (
    "A boat in a file: it is flown by this page alone. "
    "Marks are not judged here; nothing is sent or kept."
)


def bundle(entry: str) -> str:
    """Return one script of a module and all that it imports."""
    sources = collect_modules(entry, REPLACED_SCRIPTS)
    return f'"use strict";\n(() => {{\nconst M = {{}};\n\n{wrap_modules(sources)}}})();\n'


def close_text(text: str) -> str:
    """Return a script's text in which no character ends the element around it."""
    return re.sub(r"<(?=/script|!--|script)", r"\\x3c", text, flags=re.IGNORECASE)


def pack_data(data: bytes) -> str:
    """Return bytes deflated and in base64; the same bytes give the same text."""
    return base64.b64encode(zlib.compress(data, 9)).decode("ascii")


def data_url(font: str) -> str:
    """Return the address of a font that holds it whole."""
    return f"data:font/woff2;base64,{base64.b64encode(read_font(font)).decode('ascii')}"


def digest(text: str) -> str:
    """Return the source expression of an inline script or style."""
    hash_bytes = hashlib.sha256(text.encode()).digest()
    return f"'sha256-{base64.b64encode(hash_bytes).decode('ascii')}'"


def policy(scripts: list[str], sheet: str) -> str:
    """Return what the page may do: its own scripts, style, core and worker."""
    hashes = " ".join(map(digest, scripts))
    return (
        f"default-src 'none'; script-src {hashes} 'wasm-unsafe-eval'; style-src {digest(sheet)}; "
        "worker-src blob:; img-src data:; font-src data:; base-uri 'none'; form-action 'none'"
    )


def said_in_tab() -> set[str]:
    """Return what such a page says beside what its station's page says."""
    scripts = ((ASSETS_FOLDER / path).read_text(encoding="utf-8") for path in SPEAKING_SCRIPTS)
    return {TAB_NOTE}.union(*map(said_in_script, scripts))


def find_styles(html: str) -> Iterable[str]:
    """Return the sheets that a page links, and those that its modules need besides.

    A module needs each sheet that all served pages link which run it.
    """
    linked, needed = STYLESHEET_TAG.findall(html), set[str]()
    served = [(run_modules(each, {}), STYLESHEET_TAG.findall(each)) for each in map(render, PAGES)]
    for module in run_modules(html, REPLACED_SCRIPTS):
        links = [set(sheets) for run, sheets in served if module in run]
        needed |= set.intersection(*links) if links else set()
    return dict.fromkeys((*linked, *sorted(needed), TAB_STYLE))


def run_modules(html: str, replaced: Mapping[str, str]) -> set[str]:
    """Return the paths of the modules that a page runs."""
    return {path for entry in SCRIPT_TAG.findall(html) for path in collect_modules(entry, replaced)}


def single_file(name: str, boat: Mapping[str, Any], core: bytes, title: str) -> str:
    """Return the station's page with a boat inside."""
    page = next(each for each in PAGES if name in (each.name, each.role))
    taken = {row.split(";")[0].split()[0] for row in boat["orders"]} | TAB_ORDERS
    recorded = boat.get("recording") or {}
    causes = {says.partition("|")[0] for *_, says in recorded.get("causes", ())}
    html = render(
        page, said_in_tab() | causes, order_words=partial(order_words, taken), lessons=list
    )
    sheet = join_styles(find_styles(html))
    sheet = FONT_URL.sub(lambda url: f'url("{data_url(url[1])}")', sheet)
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
    note = note if page.name != "kiosk" else ""  # visitors read one sentence at a time
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
