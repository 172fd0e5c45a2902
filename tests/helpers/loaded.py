"""What a page of HTML, or a sheet of styles, loads from another host when it is opened."""

import re
from html.parser import HTMLParser
from typing import Final

LOADING_ATTRIBUTES: Final = frozenset({"src", "srcset", "poster", "data", "xlink:href"})
LOADING_TAGS: Final = frozenset({"use", "image"})  # of SVG, by their href
LOADING_LINKS: Final = frozenset(  # by their rel; others say where a page stands
    {"stylesheet", "icon", "manifest", "preload", "prefetch", "preconnect", "modulepreload"}
)
STYLE_ADDRESS: Final = re.compile(r"(?:url\(|@import)\s*[\"']?([^\"')\s;]+)")
OUTSIDE: Final = re.compile(r"(?:https?:)?//")


def loaded_from_outside(text: str) -> list[str]:
    """Return the addresses on other hosts from which a page or its styles load something."""
    page = LoadedAddresses()
    page.feed(text)
    return [each for each in (*page.found, *STYLE_ADDRESS.findall(text)) if OUTSIDE.match(each)]


class LoadedAddresses(HTMLParser):
    """The addresses that a page loads by itself, and not those that its links lead to."""

    def __init__(self) -> None:
        super().__init__()
        self.found: list[str] = []

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        """Note what the tag loads."""
        kinds = set((dict(attrs).get("rel") or "").lower().split())
        names = LOADING_ATTRIBUTES
        if tag in LOADING_TAGS or (tag == "link" and LOADING_LINKS & kinds):
            names |= {"href"}
        for name, value in attrs:
            if name in names and value:
                several = value.split(",") if name == "srcset" else [value]
                self.found += [address.strip() for address in several]
