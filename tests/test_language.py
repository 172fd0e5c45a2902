"""The documents and messages are in plain English, for readers whose second language it is."""

import re
from pathlib import Path
from typing import Final

import pytest

ROOT: Final = Path(__file__).parent.parent
PAGES: Final = [*sorted(ROOT.glob("docs/*.md")), ROOT / "README.md", ROOT / "CONTRIBUTING.md"]
SOURCES: Final = [
    *sorted(ROOT.glob("trainer/**/*.py")),
    *sorted(ROOT.glob("trainer/**/*.toml")),
    *sorted(ROOT.glob("configs/**/*.toml")),
]
# phrases of the control room, as the crew says them
PHRASES: Final = re.compile(
    r"\b(ease|meet|meeting) her\b|\bsteady as she goes\b|\bease \[her\|", re.IGNORECASE
)
# a word that is gone, and what is said in its place
GONE: Final = {
    "she": "the boat, it",
    "her": "its",
    "hers": "its",
    "herself": "itself",
    "lest": "so that not",
    "nought": "zero",
    "whence": "from where",
    "thereby": "so",
    "wherewith": "with which",
    "beforehand": "before",
    "hangs on": "depends on",
    "fitted out": "made into a boat",
}
# words of our own that the documents do without
OURS: Final = {
    "whoever": "who, everybody who",
    "besides": "also, as well",
    "athwart": "sideways",
    "wholly": "completely",
    "account": "summary",
    "dial": "connect",
    "dials": "connects",
    "fitout": "assembly",
    "yardstick": "objective",
    "dossier": "data",
    "outbox": "queue of lines",
    "nursery": "fork server",
    "vats": "tanks",
    "lapses": "ends",
}
PROMISE: Final = re.compile(r"\bAfter this page (you|a script)\b")


def found(text: str, words: dict[str, str]) -> list[str]:
    """Return the lines of a text that use such a word, with what to say in its place."""
    pattern = re.compile(rf"\b({'|'.join(words)})\b", re.IGNORECASE)
    lines = enumerate(PHRASES.sub("", text).splitlines(), 1)
    uses = ((number, use) for number, line in lines for use in pattern.findall(line))
    return [f"{number}: {use}; say: {words[use.lower()]}" for number, use in uses]


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_a_document_uses_words_that_every_reader_knows(page: Path) -> None:
    assert found(page.read_text(encoding="utf-8"), GONE | OURS) == []


def test_messages_and_docstrings_call_a_boat_it_and_use_no_words_that_are_gone() -> None:
    texts = {file: file.read_text(encoding="utf-8") for file in SOURCES}
    uses = {
        str(file.relative_to(ROOT)): lines
        for file, text in texts.items()
        if (lines := found(text, GONE))
    }

    assert len(texts) > 400
    assert uses == {}


def test_the_phrases_of_the_control_room_are_no_fault() -> None:
    assert found("`meet her`, then steady as she goes", GONE) == []
    assert found("She heels", GONE) == ["1: She; say: the boat, it"]


@pytest.mark.parametrize("page", sorted(ROOT.glob("docs/*.md")), ids=lambda page: page.name)
def test_a_page_begins_with_what_its_reader_can_do_after_it(page: Path) -> None:
    if page.name != "index.md":
        text = page.read_text(encoding="utf-8")
        assert PROMISE.search(text.partition("\n## ")[0])
