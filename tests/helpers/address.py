"""Where the project is on the net: one line of pyproject.toml, from which all others follow.

Change ``Source`` there, then type ``python -m helpers.address`` in tests/: it writes all others.
"""

import re
import tomllib
from typing import Final

from helpers.places import ROOT

WRITTEN_IN: Final = ("pyproject.toml", "CITATION.cff", "codemeta.json", ".zenodo.json")
SOURCE: Final = re.compile(r"https://github\.com/([\w-]+)/([\w.-]+)")


def project_urls() -> dict[str, str]:
    """Return the addresses of pyproject.toml by name."""
    table = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
    return dict(table["project"]["urls"])


def renewed(text: str, source: str) -> str:
    """Return a text with its addresses of the project as they follow from ``source``.

    ValueError where that is not ``https://github.com/OWNER/NAME``: pages, raw files and workflows
    are that host's.
    """
    named = SOURCE.fullmatch(source)
    if named is None:
        raise ValueError(f"[project.urls] Source {source!r}: must be https://github.com/OWNER/NAME")
    owner, name = named.groups()
    text = SOURCE.sub(source, text)
    text = re.sub(
        r"(https://raw\.githubusercontent\.com)/[\w-]+/[\w.-]+", rf"\1/{owner}/{name}", text
    )
    return re.sub(r"https://[\w-]+\.github\.io/[\w.-]+", f"https://{owner}.github.io/{name}", text)


def main() -> None:
    """Write every address again from the one."""
    source = project_urls()["Source"]
    for file in WRITTEN_IN:
        path = ROOT / file
        path.write_text(renewed(path.read_text(encoding="utf-8"), source), encoding="utf-8")


if __name__ == "__main__":
    main()
