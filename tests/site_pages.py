"""What mkdocs adds to the documents: a menu, made pages, and a look at what the site loads.

`mkdocs build` calls the functions `on_...`. The menu is that of docs/index.md. The home page is the
README. Files of the repository that a page names come with it.
"""

import json
import posixpath
import re
import tempfile
from pathlib import Path
from typing import Final

from helpers.address import project_urls
from helpers.loaded import loaded_from_outside
from helpers.notebooks import NOTEBOOKS, outputs_of
from helpers.places import ROOT
from helpers.shell import typed
from mkdocs.config.defaults import MkDocsConfig
from mkdocs.exceptions import PluginError
from mkdocs.structure.files import File, Files
from mkdocs.structure.pages import Page

import trainer
import trainer.identify

DOCS: Final = ROOT / "docs"
SITE_NAMES: Final = {  # of what has another name in the site than in the repository
    "README.md": "index.md",
    "docs/index.md": "documents.md",
    **{f"docs/{path.name}": f"{path.stem}-notebook.md" for path in NOTEBOOKS},
}
SOURCES: Final = {name: path for path, name in SITE_NAMES.items()}
FIRST: Final = {  # in a group of the menu, before the documents of that reader
    "Everybody": [
        {"Trainer": "index.md"},
        {"All documents": "documents.md"},
        {"Sail a boat here": "sail.md"},
        {"Pictures": "pictures.md"},
    ],
    "Reference": [{"Python, by its docstrings": "api.md"}],
}
FACES: Final = {trainer: trainer.__all__, trainer.identify: trainer.identify.PYTHON_FACE}
SAILED: Final = "stern-plane-jam.html"
SAIL_LINE: Final = re.compile(r"^trainer run .* --recording .*$", re.MULTILINE)
GROUP: Final = re.compile(r"^## For (?:the )?(.*?)\n(.*?)(?=^## |\Z)", re.MULTILINE | re.DOTALL)
ENTRY: Final = re.compile(r"^- \[(.*?)\]\((.*?)\): ", re.MULTILINE)
FENCE: Final = re.compile(r"(^```.*?^```)", re.MULTILINE | re.DOTALL)
CODE_IN_TABLE: Final = re.compile(r"`[^`\n]*\\\|[^`\n]*`")  # its pipes need no backslash here
LINK: Final = re.compile(r"\]\(([^)\s#:]+)(#[^)\s]*)?\)")
PICTURE: Final = re.compile(r"!\[([^]]*)\]\((?:docs/)?(images/[^)]+)\)")
SAIL_PAGE: Final = f"""\
# Sail a boat here

After this page you have had a submarine's planes jam, and have tried to save the boat.

[![The instructor's page: instruments and time line](images/page-instructor.png)]({SAILED})

**[Go aboard]({SAILED})**. The page begins with a card that says what breaks, when, and which
limits to keep. Its key takes over there, and time runs. After two minutes the card has your
result beside what was recorded, when nobody was aboard.

It is one file with the boat inside. Keep it, mail it, open it without a network:
[Send a boat by mail](boat-by-mail.md) says how to make one of any boat and any run.
"""
PICTURES_HEAD: Final = """\
# Pictures

After this page you know what the trainer looks like. Each picture leads to its full size.

<div class="grid cards" markdown>

"""
API_HEAD: Final = """\
# Python, by its docstrings

After this page you know what each public name takes and returns. [Python](python.md) has examples.

"""


def text_of(path: str) -> str:
    """Return a text of the repository."""
    return (ROOT / path).read_text(encoding="utf-8")


def on_config(config: MkDocsConfig) -> MkDocsConfig:
    """Make the menu; say where the site is to be."""
    config.site_url = project_urls()["Homepage"]
    config.nav = []
    for reader, text in GROUP.findall(text_of("docs/index.md")):
        group = reader.capitalize()
        entries = [{title: site_name(f"docs/{path}")} for title, path in ENTRY.findall(text)]
        config.nav.append({group: [*FIRST.get(group, []), *entries]})
    return config


def site_name(path: str) -> str:
    """Return what a file of the repository is called in the site."""
    path = posixpath.normpath(path)
    return SITE_NAMES.get(path, path.removeprefix("docs/"))


def on_files(files: Files, *, config: MkDocsConfig) -> Files:
    """Add what is not in docs/, and what is made."""
    files.remove(files.src_uris["index.md"])
    pages = {site_name(path.name): path.read_text("utf-8") for path in ROOT.glob("*.md")}
    pages |= {site_name(f"docs/{path.name}"): notebook_page(path) for path in NOTEBOOKS}
    pages |= {
        "documents.md": text_of("docs/index.md"),
        SAILED: sailed_page(),
        "sail.md": SAIL_PAGE,
        "pictures.md": pictures_page(),
        "api.md": api_page(),
    }
    for name, content in pages.items():
        files.append(File.generated(config, name, content=content))
    return files


def notebook_page(path: Path) -> str:
    """Return a notebook as a page, with what it prints: a test holds that it does."""
    parts = []
    for cell in json.loads(path.read_text(encoding="utf-8"))["cells"]:
        text = "".join(cell["source"])
        if cell["cell_type"] == "code":
            printed = outputs_of(cell)
            text = f"```python\n{text}\n```" + (f"\n\n```text\n{printed}```" if printed else "")
        parts.append(text)
    parts.append(f'<a href="{path.name}" download>This page as a notebook</a>')
    return "\n\n".join(parts)


def sailed_page() -> str:
    """Return the page with a boat inside, made by its line in docs/boat-by-mail.md."""
    (line,) = SAIL_LINE.findall(text_of("docs/boat-by-mail.md"))
    with tempfile.TemporaryDirectory() as folder:
        done = typed(line, Path(folder), "")
        if done.returncode:
            raise PluginError(f"{line}\n{done.stderr}")
        return (Path(folder) / "drill.html").read_text(encoding="utf-8")


def pictures_page() -> str:
    """Return a page of all pictures, each with its words and the page that it is from."""
    pictures: dict[str, tuple[str, str, str]] = {}
    for path in (ROOT / "README.md", *sorted(DOCS.glob("*.md"))):
        text = path.read_text(encoding="utf-8")
        title = text.partition("\n")[0].removeprefix("# ")
        for words, picture in PICTURE.findall(text):
            pictures.setdefault(picture, (words, title, site_name(path.name)))
    cards = [
        f"- [![{words}]({picture})]({picture})\n\n    {words}: [{title}]({name})\n"
        for picture, (words, title, name) in pictures.items()
    ]
    return PICTURES_HEAD + "\n".join(cards) + "\n</div>\n"


def api_page() -> str:
    """Return a page of all that Python calls, for mkdocstrings to fill from the sources."""
    names = [f"{face.__name__}.{name}" for face, names in FACES.items() for name in names]
    return API_HEAD + "".join(f"::: {name}\n\n" for name in names)


def on_page_markdown(markdown: str, *, page: Page, config: MkDocsConfig, files: Files) -> str:
    """Lead links to where things are in the site; take there what they name in the repository."""
    name = page.file.src_uri
    path = SOURCES.get(name, f"docs/{name}" if (DOCS / name).exists() else name)

    def led(match: re.Match[str]) -> str:
        target = posixpath.normpath(posixpath.join(posixpath.dirname(path), match[1]))
        there = site_name(target)
        if there not in files.src_uris and (ROOT / target).is_file():
            files.append(File.generated(config, there, abs_src_path=str(ROOT / target)))
        return f"]({there}{match[2] or ''})"

    parts = FENCE.split(markdown)
    for at in range(0, len(parts), 2):
        parts[at] = CODE_IN_TABLE.sub(lambda code: code[0].replace(r"\|", "|"), parts[at])
        parts[at] = LINK.sub(led, parts[at])
    return "".join(parts)


def on_post_build(*, config: MkDocsConfig) -> None:
    """Refuse a site of which a page loads something from another host; tell its size."""
    site = Path(config.site_dir)
    pages = sorted(site.rglob("*.html"))
    texts = [*pages, *site.rglob("*.css")]
    faults = [
        f"{path.relative_to(site)}: {address}"
        for path in texts
        for address in loaded_from_outside(path.read_text(encoding="utf-8"))
    ]
    if faults:
        raise PluginError("\n".join(("loaded from another host:", *faults)))
    size = sum(path.stat().st_size for path in site.rglob("*") if path.is_file())
    print(f"{len(pages)} pages, {size / 1e6:.1f} MB, nothing from another host")
