"""The pages' scripts and styles as they are written: types, rules, size, nobody else's files."""

import gzip
import re

import pytest
from helpers import node
from helpers.places import ROOT

from trainer.web.modules import ASSETS_FOLDER

MOST = 250_000  # [bytes] packed: all that a browser can ask for


@pytest.mark.process
def test_types_fit() -> None:
    assert not node.run("typescript/bin/tsc", "-p", str(ROOT / "tests/web/tsconfig.json"))


@pytest.mark.process
def test_rules_are_kept() -> None:
    rules = str(ROOT / "tests/web/eslint.config.js")

    # its base path is where it runs: the assets may lie outside the checkout, in an environment
    assert not node.run("eslint/bin/eslint.js", "--config", rules, "js", folder=ASSETS_FOLDER)


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

    assert kinds <= {".js", ".css", ".svg", ".json"}
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
    styles = re.findall(r"https?://\S*|@import.*|\burl\(\s*['\"]?(?!data:|#).*", own)
    return styles + re.findall(r"\bimport\b[^;]*from\s+\"(?!\.).*", own)
