"""The pages' scripts and styles as they are written: types, rules, size, nobody else's files."""

import gzip
import re

import pytest
from helpers import node
from helpers.places import ROOT

from trainer.io.orders.sentences import FACTS
from trainer.web.modules import ASSETS_FOLDER

MOST = 304_500  # [bytes] packed: all that a browser can ask for
FACT_TABLE = re.compile(r"(?:FACTS = \{(.*?)^\};|onFacts\(\{(.*?)\}\);)", re.DOTALL | re.MULTILINE)


@pytest.mark.process
def test_types_fit() -> None:
    assert not node.run("typescript/bin/tsc", "-p", str(ROOT / "tests/web/tsconfig.json"))


@pytest.mark.process
def test_rules_are_kept() -> None:
    rules = str(ROOT / "tests/web/eslint.config.js")

    # its base path is where it runs: the assets may lie outside the checkout, in an environment
    assert not node.run("eslint/bin/eslint.js", "--config", rules, "js", folder=ASSETS_FOLDER)


def test_pages_wait_for_no_fact_that_the_session_never_tells() -> None:
    scripts = [path.read_text(encoding="utf-8") for path in ASSETS_FOLDER.rglob("*.js")]
    names = {name for script in scripts for name in awaited_facts(script)}

    assert {"crew-order", "own-alert", "step-missed", "debrief-page", "aboard"} <= names
    assert not names - FACTS.keys()


def awaited_facts(script: str) -> set[str]:
    """Return the facts that a script has rows for, in any table."""
    tables = "".join(inner for found in FACT_TABLE.findall(script) for inner in found)
    while tables != (outer := re.sub(r"\{[^{}]*\}", "", tables)):  # deeds have keys too
        tables = outer
    return set(re.findall(r'([a-z-]+)"?: ', tables))


def test_assets_are_small() -> None:
    packed = {
        path.relative_to(ASSETS_FOLDER): len(gzip.compress(path.read_bytes()))
        for path in ASSETS_FOLDER.rglob("*")
        if path.is_file()
    }
    assert packed
    assert sum(packed.values()) <= MOST, packed


def test_assets_are_our_own_scripts_styles_and_words() -> None:
    kinds = {path.suffix for path in ASSETS_FOLDER.rglob("*") if path.is_file()}

    assert kinds <= {".js", ".css", ".svg", ".json", ".woff2", ".txt"}
    assert not [
        path for path in ASSETS_FOLDER.rglob("*") if ".min." in path.name or path.is_symlink()
    ]


def test_nothing_is_fetched_from_elsewhere() -> None:
    paths = sorted(ASSETS_FOLDER.rglob("*.[jc]s*"))
    fetched = [
        f"{path.relative_to(ASSETS_FOLDER)}: {address}"
        for path in paths
        for address in foreign_addresses(path.read_text(encoding="utf-8"))
    ]

    assert paths
    assert not fetched


def foreign_addresses(text: str) -> list[str]:
    """Return what a script or a style asks for that is not beside it."""
    own = re.sub(r"http://www\.w3\.org/\S+", "", text)
    styles = re.findall(r"https?://\S*|@import.*|\burl\((?!['\"]?(?:data:|#|\./fonts/)).*", own)
    return styles + re.findall(r"\bimport\b[^;]*from\s+\"(?!\.).*", own)
